/** @file
 * The blocks that a room and a yard are made of. */
#ifndef LUM_SIM_BLOCKS_H
#define LUM_SIM_BLOCKS_H

#include <stdbool.h>
#include <stddef.h>

/** A block of six faces. The first one of a place is the place itself, from
 * inside. */
typedef struct lum_block {
    float middle[3];    /**< metres */
    float size[3];      /**< metres */
    float turn_deg[3];  /**< roll, pitch, yaw */
    float reflectivity; /**< 0..1 */
} lum_block;

/** Blocks of a place. */
typedef struct lum_blocks {
    const lum_block *list; /**< static */
    size_t count;          /**< how many */
    bool is_open;          /**< the first one has no top */
} lum_blocks;

/** Those of a closed room. */
lum_blocks lum_blocks_of_room(void);

/** Those of a yard. */
lum_blocks lum_blocks_of_yard(void);

/** Whether a point is inside the first block and outside all others.
 * @param margin_m how far from each face it must be at least,
 *                 above 0. */
bool lum_blocks_leave_open(lum_blocks blocks, const double at[3],
                           double margin_m);

#endif
