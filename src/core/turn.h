/* Angles and directions in integers. An angle is a uint32_t of 2^-32 turns:
 * adding angles wraps as a circle does. */
#ifndef LUM_TURN_H
#define LUM_TURN_H

#include "lum/points_fixed.h"

#include <stdint.h>

/* From the sum of two of -360..360 degrees whose mean it is; within 1.03 x
 * 2^-32 turns. */
uint32_t lum_turn_from_udeg(int32_t sum_udeg);

/* The sensor's axes as seen by an eye that is mounted so and turned to its
 * azimuth center: vectors of length 1, in 2^-30. */
void lum_turn_axes(const lum_eye_calibration *eye, int32_t out[3][3]);

/* Where a pixel looks, in 2^-28. */
void lum_turn_look(const lum_fixed_eye *eye, const lum_angle *angle,
                   int32_t out[3]);

#endif
