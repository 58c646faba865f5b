/** @file
 * Runs of points of a packed frame: where they end and in which order they are
 * sent (lum/frame/packed.h). Internal. */
#ifndef LUM_FRAME_PACKED_INTERNAL_H
#define LUM_FRAME_PACKED_INTERNAL_H

#include "lum/frame/packed.h"

/** Coordinates of a point. */
#define LUM_PACKED_AXES 3u
/** Kinds that a run names. */
#define LUM_PACKED_KINDS 3u
/** Steps that 18 bits reach over. */
#define LUM_PACKED_STEPS_MAX 262143.0
/** The coarsest step is 2 to the power of minus this, in metres. */
#define LUM_PACKED_COARSEST 9u

/** Points of one line, which follow each other. */
typedef struct lum_packed_run {
    const lum_packed_part *part;     /**< whose they are */
    uint32_t begin;                  /**< the first, of the part's points */
    uint32_t first;                  /**< of the frame's points */
    uint32_t count;                  /**< points, at least 1 */
    uint32_t order;                  /**< the smaller, the earlier it is sent */
    uint32_t others;                 /**< points of no kind that it names */
    uint32_t pixel_bytes;            /**< of its pixels as bits */
    int32_t origin[LUM_PACKED_AXES]; /**< steps */
    uint16_t kinds[LUM_PACKED_KINDS]; /**< its most frequent ones */
    uint8_t exponent;                 /**< of the steps */
} lum_packed_run;

/** All of a frame. */
typedef struct lum_packed_runs {
    lum_packed_run *at; /**< to be freed */
    size_t count;       /**< of them */
    size_t room;        /**< for so many there is memory */
} lum_packed_runs;

/** Add the runs of a part.
 * @param first where its points begin in the frame.
 * @return LUM_OK; LUM_E_SPACE without memory. */
lum_result lum_packed_runs_add(lum_packed_runs *runs,
                               const lum_packed_part *part, uint32_t first);

/** Bring them into the order in which they are sent. */
void lum_packed_runs_sort(lum_packed_runs *runs);

/** A point's kind, as the header tells it. */
static inline uint16_t lum_packed_kind(const lum_packed_part *part, size_t i)
{
    const uint32_t number = part->return_number[i];
    const uint32_t returns = part->number_of_returns[i];
    return (uint16_t)((number < 127u ? number : 127u) |
                      (uint32_t)(part->strongest[i] != 0) << 7 |
                      (uint32_t)(part->edge[i] != 0) << 9 |
                      (returns < 63u ? returns : 63u) << 10);
}

/** A coordinate of all points of a part. */
static inline const float *lum_packed_axis(const lum_packed_part *part,
                                           unsigned axis)
{
    const float *const axes[LUM_PACKED_AXES] = {part->x, part->y, part->z};
    return axes[axis];
}

#endif
