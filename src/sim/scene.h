/** @file
 * A place at a moment, as one eye sees it, ready for many rays.
 *
 * All rays start at the eye, so shapes are stored by the directions that they
 * cover: a grid over azimuth and elevation, each cell with its shapes from near
 * to far. */
#ifndef LUM_SIM_SCENE_H
#define LUM_SIM_SCENE_H

#include "place.h"
#include "shape.h"
#include "street.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Most hits of one ray. */
#define LUM_SCENE_HITS_MAX 16u

/** A scene. Private except its size; begin with all zero. */
typedef struct lum_scene {
    lum_shape_list shapes;         /**< private */
    struct lum_scene_place *order; /**< private: of shapes, near to far */
    size_t order_room;             /**< private */
    lum_ground ground;             /**< private */
    uint32_t *cells;               /**< private: first entry of each cell */
    uint32_t *entries;             /**< private: indices of shapes */
    size_t room;                   /**< private: of entries */
    float reach_m; /**< private: how far an eye is from the origin */
    float half_s;  /**< private: how far a time is from the middle */
} lum_scene;

/** A short time in which the sensor and others move a little. */
typedef struct lum_section {
    lum_sight_view view; /**< in the frame of the place */
    double time_s;       /**< its middle */
    double half_s;       /**< how far before and after that it reaches */
} lum_section;

/** From where and when a ray starts, in the middle of a section. */
typedef struct lum_start {
    float from[3]; /**< of the eye, from the middle of the view, metres */
    float late_s;  /**< after the section's middle */
} lum_start;

/** Set the scene for a moment. Parameters as lum_place_lay_out().
 * @param place stays where it is as long as the scene is used.
 * @return 0, or -1 when there is no memory. */
int lum_scene_set(lum_scene *scene, const lum_place *place, double time_s,
                  const float mount[3]);

/** Set the scene for a section, of a place where all moves. Parameters and
 * result as lum_scene_set(). */
int lum_scene_set_section(lum_scene *scene, const lum_place *place,
                          const lum_section *section);

/** Free what a scene holds. */
void lum_scene_free(lum_scene *scene);

/** The hits of a ray, from near to far, up to the first one that stops the rest
 * of the beam.
 * @param hits room for ::LUM_SCENE_HITS_MAX.
 * @return how many; 0: the sky. */
size_t lum_scene_cast(const lum_scene *scene, const lum_ray *ray,
                      lum_hit *hits);

/** As lum_scene_cast(), in a section.
 * @param start where the ray starts, within the reach of the section. */
size_t lum_scene_cast_from(const lum_scene *scene, const lum_start *start,
                           const lum_ray *ray, lum_hit *hits);

#endif
