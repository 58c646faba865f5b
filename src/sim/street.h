/** @file
 * The street that the simulated sensor drives along: its objects at a moment.
 *
 * It has no end: each lot is computed from the seed and its number, so only the
 * part in reach of the sensor has to exist. */
#ifndef LUM_SIM_STREET_H
#define LUM_SIM_STREET_H

#include "shape.h"

#include <stdbool.h>
#include <stdint.h>

/** Height of the sensor above the road, metres. */
#define LUM_STREET_SENSOR_HEIGHT 1.8

/** Speed of the sensor along the street, m/s. */
#define LUM_STREET_SENSOR_SPEED 5.0

/** How far the sensor sees, metres. */
#define LUM_STREET_REACH 250.0f

/** The road between its kerbs, and the pavements beyond them. Metres, around
 * the eye. */
typedef struct lum_ground {
    bool is_there;      /**< else nothing below counts, and no ray hits it */
    float road_z;       /**< height of the road */
    float pavement_z;   /**< height of the pavements, above road_z */
    float kerb_right_y; /**< y of the right kerb */
    float kerb_left_y;  /**< y of the left kerb */
    float marks_x;      /**< where a dash of the centre line begins */
    float crossing_x;   /**< where a pedestrian crossing begins */
} lum_ground;

/** Lay out the street.
 * @param seed   of the street.
 * @param time_s since the beginning of the drive.
 * @param ahead_m how far ahead of its place in the drive the sensor is.
 * @param eye    where the eye is mounted, in the frame of the sensor; all
 *               that is laid out is relative to it.
 * @param out    emptied, then filled; failed is set when there is no memory.
 * @param ground gets the ground. */
void lum_street_lay_out(uint64_t seed, double time_s, double ahead_m,
                        const float eye[3], lum_shape_list *out,
                        lum_ground *ground);

/** Where a ray hits the ground.
 * @return whether it does within ::LUM_STREET_REACH. */
bool lum_ground_cast(const lum_ground *ground, const lum_ray *ray,
                     lum_hit *hit);

#endif
