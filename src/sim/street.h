/** @file
 * The street that the simulated sensor drives along: its objects at a moment.
 *
 * It has no end: each lot is computed from the seed and its number, so only the
 * part in reach of the sensor has to exist. */
#ifndef LUM_SIM_STREET_H
#define LUM_SIM_STREET_H

#include "ground.h"
#include "shape.h"

#include <stdbool.h>
#include <stdint.h>

/** Height of the sensor above the road, metres. */
#define LUM_STREET_SENSOR_HEIGHT 1.8

/** Speed of the sensor along the street, m/s. */
#define LUM_STREET_SENSOR_SPEED 5.0

/** When, and where the sensor is. */
typedef struct lum_street_moment {
    double time_s;  /**< since the beginning of the drive */
    double ahead_m; /**< how far it is ahead of ::LUM_STREET_SENSOR_SPEED x
                         time_s */
    bool leads;     /**< vehicles of its lane keep their distance to it; else
                         they have a speed of their own */
    double speed;   /**< where it leads: along the street, m/s */
} lum_street_moment;

/** Lay out the street.
 * @param seed   of the street.
 * @param eye    where the eye is mounted, in the frame of the sensor; all
 *               that is laid out is relative to it.
 * @param out    emptied, then filled; failed is set when there is no memory.
 * @param ground gets the ground. */
void lum_street_lay_out(uint64_t seed, const lum_street_moment *at,
                        const float eye[3], lum_shape_list *out,
                        lum_ground *ground);

#endif
