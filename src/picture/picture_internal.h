/** @file
 * The parts of a picture, and what it keeps of the points, in bounded memory: a
 * range image of each eye, the ground seen from above at several scales, and
 * the distribution of ranges. Internal to picture. */
#ifndef LUM_PICTURE_PICTURE_INTERNAL_H
#define LUM_PICTURE_PICTURE_INTERNAL_H

#include "canvas.h"

#include "lum/cloud/writer.h"
#include "lum/image.h"

/* --- What is kept: picture_raster.c --- */

#define LUM_PANORAMA_CELLS 1024  /**< of a range image, each way */
#define LUM_GROUND_CELLS   2048  /**< of a ground level, each way */
#define LUM_GROUND_LEVELS  8     /**< each twice as wide as the one before */
#define LUM_GROUND_REACH   16.0f /**< metres from the origin, level 0 */
#define LUM_RANGE_BINS     16384 /**< of the histogram; the last takes all */
#define LUM_RANGE_BIN      0.1f  /**< metres */

/** What one eye saw: the nearest range in each cell of angles. */
typedef struct lum_panorama {
    lum_image_view view;   /**< a little more than the eye can see */
    lum_image_scale scale; /**< of it */
    float nearest[LUM_PANORAMA_CELLS * LUM_PANORAMA_CELLS]; /**< metres, as
                             lum_image_pixels() places them; 0: nothing */
} lum_panorama;

/** All of it; more than 40 MB, but a scene uses only a small part. */
typedef struct lum_raster {
    lum_panorama eye[LUM_EYES]; /**< range images */
    uint8_t ground[LUM_GROUND_LEVELS][LUM_GROUND_CELLS]
                  [LUM_GROUND_CELLS]; /**< points by x and y, saturating */
    uint64_t ranges[LUM_RANGE_BINS];  /**< histogram */
    uint64_t points;                  /**< all of them */
} lum_raster;

/** Prepare a zeroed raster.
 * @param projector tells the angles of the eyes; NULL: the typical ones. */
void lum_raster_begin(lum_raster *raster, const lum_projector *projector);

/** Take a line in. */
void lum_raster_add(lum_raster *raster, const lum_line_samples *line);

/** The range that a share of the points (0..1) does not exceed, in metres; 0
 * when there are none. */
float lum_raster_range(const lum_raster *raster, double share);

/* --- What is drawn of it --- */

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

/** Draw an eye's range image. It is cropped to the part with data; its angles
 * are left of the box and below it. */
void lum_draw_panorama(lum_canvas *canvas, lum_box box,
                       const lum_panorama *panorama, lum_depth depth);

/** Draw the scene from above, and rings of equal distance. */
void lum_draw_ground(lum_canvas *canvas, lum_box box, const lum_raster *raster,
                     lum_depth depth);

/** Draw the colour scale and its numbers. */
void lum_draw_scale(lum_canvas *canvas, lum_box box, lum_depth depth);

#endif
