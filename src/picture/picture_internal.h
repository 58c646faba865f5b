/** @file
 * The parts of a picture. Internal to picture. */
#ifndef LUM_PICTURE_PICTURE_INTERNAL_H
#define LUM_PICTURE_PICTURE_INTERNAL_H

#include "canvas.h"
#include "picture_raster.h"

/** The ranges that the colour scale spans, logarithmically. */
typedef struct lum_depth {
    float near_m; /**< metres, above 0 */
    float far_m;  /**< metres, above near_m */
} lum_depth;

extern const lum_rgb lum_paper; /**< background */
extern const lum_rgb lum_panel; /**< background where data could be */
extern const lum_rgb lum_ink;   /**< text */
extern const lum_rgb lum_dim;   /**< less important text */
extern const lum_rgb lum_grid;  /**< lines behind data */

/** The colour of a range. */
lum_rgb lum_depth_colour(lum_depth depth, float range);

/** A step of 1, 2 or 5 times a power of ten, so that a span has about n. */
float lum_nice_step(float span, int n);

/** Draw an eye's range image, with the highest elevation and the largest
 * azimuth at the top left. It is cropped to the part with data; its angles are
 * left of the box and below it. */
void lum_draw_panorama(lum_canvas *canvas, lum_box box,
                       const lum_panorama *panorama, lum_depth depth);

/** Draw the scene from above, and rings of equal distance. */
void lum_draw_ground(lum_canvas *canvas, lum_box box, const lum_raster *raster,
                     lum_depth depth);

/** Draw the colour scale and its numbers. */
void lum_draw_scale(lum_canvas *canvas, lum_box box, lum_depth depth);

#endif
