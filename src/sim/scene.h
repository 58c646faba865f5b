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
    lum_shape_list shapes; /**< private: near to far */
    lum_ground ground;     /**< private */
    uint32_t *cells;       /**< private: first entry of each cell */
    uint32_t *entries;     /**< private: indices of shapes */
    size_t room;           /**< private: of entries */
} lum_scene;

/** Set the scene for a moment. Parameters as lum_place_lay_out().
 * @param place stays where it is as long as the scene is used.
 * @return 0, or -1 when there is no memory. */
int lum_scene_set(lum_scene *scene, const lum_place *place, double time_s,
                  const float mount[3]);

/** Free what a scene holds. */
void lum_scene_free(lum_scene *scene);

/** The hits of a ray, from near to far, up to the first one that stops the rest
 * of the beam.
 * @param hits room for ::LUM_SCENE_HITS_MAX.
 * @return how many; 0: the sky. */
size_t lum_scene_cast(const lum_scene *scene, const lum_ray *ray,
                      lum_hit *hits);

#endif
