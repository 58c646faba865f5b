/** @file
 * What a simulated point lies on. */
#ifndef LUM_SIM_LABEL_H
#define LUM_SIM_LABEL_H

#include <stdint.h>

/** Classes of things; lumsim.1 has the same table. */
typedef enum lum_thing {
    LUM_THING_NONE,     /**< nothing of these */
    LUM_THING_GROUND,   /**< roads, kerbs, pavements, floors */
    LUM_THING_BUILDING, /**< houses, and walls around a room or yard */
    LUM_THING_CAR,
    LUM_THING_TRUCK, /**< and vans */
    LUM_THING_CYCLIST,
    LUM_THING_PERSON,
    LUM_THING_TREE, /**< and bushes */
    LUM_THING_POLE, /**< lamps, posts */
    LUM_THING_SIGN,
    LUM_THING_OTHER, /**< what stands about: bins, crates, sheds */
    LUM_THINGS       /**< how many there are */
} lum_thing;

/** The number of the ground; other objects have larger ones. */
#define LUM_OBJECT_GROUND 1u

/** What a point lies on. */
typedef struct lum_label {
    uint32_t object;  /**< the same for the same object during a drive */
    uint8_t thing;    /**< a ::lum_thing */
    uint8_t is_mixed; /**< 1: its pulse is of several surfaces, or of the rim of
                           a round one, where part of the beam passes */
} lum_label;

#endif
