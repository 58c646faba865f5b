/** @file
 * A town: streets along x and along y between blocks of houses, with vehicles
 * and people that move.
 *
 * Its origin lies on the northern one of two streets along x, in the lane in
 * which one drives along x. All that stands is the same at any time, and
 * whatever way one comes. */
#ifndef LUM_SIM_TOWN_H
#define LUM_SIM_TOWN_H

#include "ground.h"
#include "path.h"
#include "shape.h"

#include <stdbool.h>
#include <stdint.h>

/** The way round the block: in the right lane, with right turns. */
lum_course lum_town_circuit(void);

/** Whether a point is above a road or its pavements, or above the houses, and
 * not below the ground.
 * @param margin_m how far above the ground and from the houses. */
bool lum_town_is_open(const double at[3], double margin_m);

/** Lay out what can be seen. Parameters as lum_street_lay_out().
 * @param view what is outside may be left out. */
void lum_town_lay_out(uint64_t seed, double time_s, const lum_sight_view *view,
                      lum_shape_list *out, lum_ground *ground);

#endif
