/** @file
 * Roads between kerbs, and the pavements beyond them. Metres, around the
 * eye. */
#ifndef LUM_SIM_GROUND_H
#define LUM_SIM_GROUND_H

#include "shape.h"

#include <stdbool.h>

/** How far the sensor sees, metres. */
#define LUM_STREET_REACH 250.0f

/** From the middle of a road to its kerbs, metres. */
#define LUM_ROAD_HALF 5.7f

/** How high a pavement is above the road, metres. */
#define LUM_PAVEMENT_Z 0.13f

/** Most roads of a town in each direction. */
#define LUM_ROADS_MAX 3u

/** Roads of a town that cross each other at right angles: their middles. */
typedef struct lum_roads {
    unsigned count[2];              /**< along x, along y; both 0: a street */
    float middle[2][LUM_ROADS_MAX]; /**< y of those along x, x of those along
                                         y */
    float marks_y;                  /**< as marks_x, of those along y */
} lum_roads;

/** The ground of a street along x, or of a town. */
typedef struct lum_ground {
    bool is_there;      /**< else nothing below counts, and no ray hits it */
    float road_z;       /**< height of the road */
    float pavement_z;   /**< height of the pavements, above road_z */
    float kerb_right_y; /**< y of the right kerb; of a street only */
    float kerb_left_y;  /**< y of the left kerb; of a street only */
    float marks_x;      /**< where a dash of the centre line begins */
    float crossing_x;   /**< where a pedestrian crossing begins; of a street
                             only */
    lum_roads roads;    /**< of a town */
} lum_ground;

/** Where a ray hits the ground.
 * @return whether it does within ::LUM_STREET_REACH. */
bool lum_ground_cast(const lum_ground *ground, const lum_ray *ray,
                     lum_hit *hit);

/** The ground around an eye that is elsewhere by this much. */
lum_ground lum_ground_seen_from(const lum_ground *ground, const float by[3]);

#endif
