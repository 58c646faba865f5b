/* The space that has to be empty, and the distance of an object in it. */
#ifndef ZONE_H
#define ZONE_H

#include "lum/points_fixed.h"

#include <stdbool.h>
#include <stdint.h>

#define ZONE_SLOPE_ONE 65536 /* a slope of 1: 45 degrees */

/* Lengths in 1/LUM_FIXED_PER_MM mm, in the frame of the calibration's mount: x
 * forward, y left, z up. A box; with a range, only the part of it that is also
 * in a sector seen from above: between two edges, no further than the range. */
typedef struct zone {
    int32_t min[3]; /* x, y, z */
    int32_t max[3];
    int32_t range; /* of a sector; 0: only the box */
    int32_t left;  /* slope y / x of its left edge, in 1/ZONE_SLOPE_ONE */
    int32_t right; /* of its right edge; not above left */
} zone;

/* What was seen in a zone. Begins as zone_empty(). */
typedef struct zone_sight {
    uint64_t nearest_square; /* of the distance from the frame's origin */
    uint32_t hits;           /* returns in the zone */
} zone_sight;

zone_sight zone_empty(void);

bool zone_holds(const zone *z, const lum_fixed_point *point);

/* Adds the rising edges among n points. */
void zone_look(const zone *z, zone_sight *sight, const lum_fixed_point *points,
               size_t n);

/* Distance of the nearest return in mm; 0 if there was none. */
uint32_t zone_nearest_mm(const zone_sight *sight);

#endif
