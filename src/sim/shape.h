/** @file
 * Solid objects of a scene, and where a beam from the origin hits them.
 *
 * Metres; x forward, y left, z up. All beams start at the origin, so a scene is
 * laid out around the eye that looks at it. */
#ifndef LUM_SIM_SHAPE_H
#define LUM_SIM_SHAPE_H

#include "face.h"

#include <stdbool.h>
#include <stddef.h>
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
    LUM_THING_OTHER /**< what stands about: bins, crates, sheds */
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

/** What fills the box that bounds a shape. */
typedef enum lum_shape_kind {
    LUM_SHAPE_BOX,    /**< the box itself */
    LUM_SHAPE_CABIN,  /**< a box whose sides lean inwards towards its top */
    LUM_SHAPE_FACADE, /**< a box with rows of windows and doors in its sides
                           along x */
    LUM_SHAPE_PILLAR, /**< a cylinder that stands */
    LUM_SHAPE_WHEEL,  /**< a cylinder whose axis lies along y */
    LUM_SHAPE_BALL,   /**< a sphere */
    LUM_SHAPE_LEAVES, /**< a sphere of leaves that lets part of a beam pass */
    LUM_SHAPE_FACE,   /**< a face, in the middle of the box */
    LUM_SHAPES        /**< how many there are */
} lum_shape_kind;

/** How far the sides of a cabin's top are inside those of its bottom;
 * metres. */
typedef struct lum_shape_lean {
    float front; /**< towards +x */
    float back;  /**< towards -x */
    float side;  /**< on either side */
} lum_shape_lean;

/** Openings of a facade; metres. */
typedef struct lum_shape_openings {
    float bay;    /**< from one column of windows to the next */
    float storey; /**< from one floor to the next */
    float recess; /**< how deep panes and doors stand behind the wall */
    float door;   /**< the bay that has a door at the ground, counted along x */
} lum_shape_openings;

/** One shape. */
typedef struct lum_shape {
    float min[3];               /**< lowest corner of the bounding box */
    float max[3];               /**< highest corner */
    float near_m;               /**< distance of the box, for who sorts */
    float reflectivity;         /**< 0..1 */
    float cover;                /**< leaves: share of a beam they stop */
    lum_shape_lean lean;        /**< cabins only */
    lum_shape_openings opening; /**< facades only */
    const lum_face *face;       /**< faces only: kept, not copied */
    lum_shape_kind kind;        /**< which */
    float velocity[3];          /**< m/s; who lays out a moment may set it */
    uint32_t object;            /**< number of what it is part of */
    uint8_t thing;              /**< class of that, a ::lum_thing */
    bool is_turned; /**< by a quarter turn to the left: what is said of x and y
                         above, but for the box, is of y and -x */
} lum_shape;

/** A beam from the origin. */
typedef struct lum_ray {
    float d[3];       /**< unit vector */
    float inverse[3]; /**< 1 / d, finite */
} lum_ray;

/** Where a beam meets something. */
typedef struct lum_hit {
    float range;        /**< metres */
    float cover;        /**< share of the beam that is stopped, above 0 to 1 */
    float reflectivity; /**< 0..1 */
    float cosine;       /**< of the angle of incidence, 0..1 */
    float bias;         /**< on top of the range that is measured, metres */
    uint32_t object;    /**< number of what is hit; 0: none is known */
    uint8_t thing;      /**< class of that, a ::lum_thing */
    bool is_rim;        /**< part of the beam passes a round one's rim */
} lum_hit;

/** Nothing nearer than this is hit; metres. */
#define LUM_SHAPE_NEAREST 0.5f

/** Half the width of a beam for each metre of range. */
#define LUM_BEAM_HALF_WIDTH 0.0005f

/** Make a ray.
 * @param d unit vector. */
lum_ray lum_ray_make(const float d[3]);

/** Where a ray hits a shape. A round shape's rim stops only part of a beam.
 * @param hit written only if the result is true. */
bool lum_shape_cast(const lum_shape *shape, const lum_ray *ray, lum_hit *hit);

/** As lum_shape_cast(), of a shape that is elsewhere by this much. */
bool lum_shape_cast_moved(const lum_shape *shape, const float by[3],
                          const lum_ray *ray, lum_hit *hit);

/** Where eyes look from. All 0 but the place: everywhere. */
typedef struct lum_sight_view {
    double at[3];     /**< the middle of where eyes are, metres */
    float edge[2][2]; /**< of what they see, in x and y: unit vectors that point
                           inwards, or 0 */
    float reach_m;    /**< how far from `at` an eye is at most */
} lum_sight_view;

/** Whether something around `at` may be seen.
 * @param x      its middle, from there.
 * @param radius in x and y. */
static inline bool lum_view_has(const lum_sight_view *view, float x, float y,
                                float radius)
{
    const float most = -(radius + view->reach_m);
    return x * view->edge[0][0] + y * view->edge[0][1] >= most &&
           x * view->edge[1][0] + y * view->edge[1][1] >= most;
}

/** Shapes, in an array that grows. */
typedef struct lum_shape_list {
    lum_shape *items; /**< heap */
    size_t count;     /**< how many there are */
    size_t room;      /**< how many fit */
    bool failed;      /**< there was no memory for one */
} lum_shape_list;

/** Append a copy; sets failed when there is no memory. */
void lum_shape_list_add(lum_shape_list *list, const lum_shape *shape);

/** Free the contents of a list; it is empty then. */
void lum_shape_list_free(lum_shape_list *list);

#endif
