/** @file
 * The things of a street: trees, furniture, people, vehicles, houses.
 *
 * They are added along x, to the left and right of the middle of a road. */
#ifndef LUM_SIM_THINGS_H
#define LUM_SIM_THINGS_H

#include "ground.h"
#include "random.h"
#include "shape.h"

#include <stdbool.h>
#include <stdint.h>

/* Across the street, from its middle: two lanes, parked cars, the kerb
 * (::LUM_ROAD_HALF), the pavement, the houses. Metres. */
#define LUM_LANE_Y      1.75f
#define LUM_PARKING_Y   4.6f
#define LUM_WALK_Y      8.0f
#define LUM_HOUSES_Y    10.0f
#define LUM_HOUSE_DEPTH 12.0f

/** Where things are added, and as what. */
typedef struct lum_things {
    lum_shape_list *list;
    lum_random random;
    float x;           /**< where the lot or the thing at hand begins */
    float y;           /**< the middle of the street */
    float z;           /**< the road */
    float side;        /**< +1 left, -1 right */
    double time_s;     /**< since the beginning of the drive */
    float velocity[2]; /**< of what is added, along x and y; m/s */
    bool is_turned;    /**< x and y above lie along y and -x of the scene */
    float origin[2];   /**< where they begin there */
    float low[2];      /**< what ends below this is left out */
    float high[2];     /**< what begins above this is left out */
    const lum_sight_view
        *view;       /**< what is out of it is left out; NULL: nothing */
    uint32_t object; /**< number of the last thing */
    uint8_t thing;   /**< its class, a ::lum_thing */
} lum_things;

/** A moving value kept within [low, high) by turns around it. */
float lum_things_wrap(double x, double low, double high);

/* All that follows takes x from s->x, and y and z as in a street. A number is
 * taken for each. */
void lum_things_add_tree(lum_things *s, float x, float y);
void lum_things_add_bush(lum_things *s, float x, float y);
void lum_things_add_lamp(lum_things *s, float x, float y);
void lum_things_add_sign(lum_things *s, float x, float y);
void lum_things_add_bin(lum_things *s, float x, float y);

/** Four of them, at the kerb of s->side. */
void lum_things_add_posts(lum_things *s, float x);

/** Somebody who walks, or stands where speed is 0. */
void lum_things_add_person(lum_things *s, float x, float y, float z,
                           float speed);

/** Vehicles begin at x and face +x when facing is 1, -x when it is -1. */
void lum_things_add_car(lum_things *s, float x, float y, float facing,
                        float paint);
void lum_things_add_van(lum_things *s, float x, float y, float facing,
                        float paint);
void lum_things_add_truck(lum_things *s, float x, float y, float facing,
                          float paint);
void lum_things_add_cyclist(lum_things *s, float x, float y, float facing,
                            float paint);

/** A house on s->side.
 * @param setback how far it stands behind the line of houses, metres. */
void lum_things_add_facade(lum_things *s, float x, float length, float setback);

#endif
