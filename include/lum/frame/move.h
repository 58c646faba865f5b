/** @file
 * Corrects the sensor's motion: a frame as of one moment, or in the world, by
 * each point's own time (docs/reader.md, "Motion").
 *
 * @code
 * lum_move_options options = {.struct_size = sizeof options,
 *                             .poses = poses,
 *                             .to = LUM_MOVE_TO_WORLD};
 * lum_move_counts counts = {0};
 * if (lum_frame_move(frame, &options, x, y, z, &counts, &error) != 0) { ... }
 * @endcode
 *
 * Between two poses the sensor moves along their screw. This is computed at the
 * ends of short intervals, and a point's matrix is interpolated within its
 * interval. For a point up to 100 m away this differs from the screw itself by
 * at most 0.1 mm, besides the rounding of floats: 0.05 mm at 100 m, and if the
 * result is far from 0, a float's step there (0.5 mm at 5 km). Beyond 100 m the
 * difference grows in proportion to the distance. */
#ifndef LUM_FRAME_MOVE_H
#define LUM_FRAME_MOVE_H

#include "lum/base/error.h"
#include "lum/frame/frame.h"
#include "lum/frame/poses.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Where points are moved to. */
typedef enum lum_move_to {
    LUM_MOVE_TO_START,  /**< as seen from where the sensor was when the frame
                             began */
    LUM_MOVE_TO_MIDDLE, /**< as of halfway between its earliest and latest
                             line */
    LUM_MOVE_TO_WORLD   /**< into the poses' fixed frame */
} lum_move_to;

/** How points are moved. */
typedef struct lum_move_options {
    size_t struct_size;     /**< sizeof(lum_move_options) */
    const lum_poses *poses; /**< live as long as the call */
    lum_move_to to;         /**< where to */
    bool clamps; /**< a point whose time has no pose is moved by the nearest
                      pose; false: it becomes NaN. It is counted either way */
    double origin[3]; /**< LUM_MOVE_TO_WORLD: subtracted from coordinates before
                           they are rounded to float; else 0 */
} lum_move_options;

/** What happened to points; each call adds to it. It never grows. */
typedef struct lum_move_counts {
    uint64_t points;   /**< all of them */
    uint64_t before;   /**< without a pose: before the first one */
    uint64_t after;    /**< after the last one */
    uint64_t in_gap;   /**< in a gap of the poses */
    uint64_t no_time;  /**< their time is not a number; NaN even if clamped */
    uint64_t no_start; /**< they have a pose, but the moment that they are moved
                            to has none */
} lum_move_counts;

/** Sum of the points without a pose. */
static inline uint64_t lum_move_counts_without(const lum_move_counts *counts)
{
    return counts->before + counts->after + counts->in_gap + counts->no_time +
           counts->no_start;
}

/** Move a frame's points into the caller's arrays.
 * @param frame  with the columns x, y, z and time.
 * @param x,y,z  lum_frame_count() numbers each, metres.
 * @param counts not NULL; its numbers grow.
 * @return 0, or -1 with the reason in error: the frame lacks a column or the
 *         poses' clock, options.to is none of ::lum_move_to, or struct_size is
 *         not set; errno is EINVAL. Nothing is written then.
 *
 * Linear, no heap. Any thread, as long as no two write the same arrays. */
LUM_MUST_CHECK int lum_frame_move(const lum_frame *frame,
                                  const lum_move_options *options, float *x,
                                  float *y, float *z, lum_move_counts *counts,
                                  lum_error *error);

/** Points that are in no frame. */
typedef struct lum_move_points {
    size_t struct_size; /**< sizeof(lum_move_points) */
    const float *x;     /**< count numbers each */
    const float *y;     /**< metres */
    const float *z;     /**< metres */
    const float *time;  /**< seconds from begin_ns */
    size_t count;       /**< how many */
    int64_t begin_ns;   /**< by the poses' clock */
    int64_t start_ns;   /**< likewise: the moment that points are moved to; not
                             used for the world */
} lum_move_points;

/** As lum_frame_move(), for arrays: options.to only says whether points are
 * moved into the world or to start_ns. x, y and z must not be the arrays of
 * points.
 * @return 0, or -1 with the reason in error: options.to is none of
 *         ::lum_move_to, or a struct_size is not set; errno is EINVAL. */
LUM_MUST_CHECK int lum_points_move(const lum_move_points *points,
                                   const lum_move_options *options, float *x,
                                   float *y, float *z, lum_move_counts *counts,
                                   lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
