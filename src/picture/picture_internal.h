/** @file
 * The parts of a picture, and the points that it keeps, in bounded memory.
 * Internal to picture. */
#ifndef LUM_PICTURE_PICTURE_INTERNAL_H
#define LUM_PICTURE_PICTURE_INTERNAL_H

#include "canvas.h"

#include "lum/cloud/writer.h"
#include "lum/image.h"
#include "lum/picture/picture.h"

/* --- What is kept: picture_dots.c --- */

/** A point. */
typedef struct lum_dot {
    float x;     /**< metres, forward */
    float y;     /**< metres, left */
    float z;     /**< metres, up */
    float range; /**< metres from the eye */
    float value; /**< what its colour means */
} lum_dot;

#define LUM_DOTS_MAX    ((size_t)1 << 22) /**< kept at most */
#define LUM_DOTS_SAMPLE 65536u            /**< that answer for all */

/** Points. Of many only every second, every fourth and so on is kept. All bytes
 * 0 except step, which is 1, has none. */
typedef struct lum_dots {
    lum_dot *at;   /**< count of them */
    size_t count;  /**< at most LUM_DOTS_MAX */
    size_t room;   /**< of at */
    uint64_t all;  /**< that came */
    uint64_t step; /**< of so many one is kept */
} lum_dots;

/** Take a point in; one whose numbers are not finite is only counted.
 * @return 0, or -1 without memory. */
LUM_MUST_CHECK int lum_dots_add(lum_dots *dots, const lum_dot *dot);

/** Bring all points into another frame, in which their own one is there. */
void lum_dots_move(lum_dots *dots, const lum_pose *pose);

/** Free what it holds. */
void lum_dots_free(lum_dots *dots);

/** A number of a point. */
typedef float lum_dot_number(const lum_dot *dot);

lum_dot_number lum_dot_value;    /**< its value */
lum_dot_number lum_dot_distance; /**< from the origin as seen from above */

/** The numbers that two shares of the points (0..1) do not exceed; 0 where
 * there is no point, or no memory. */
void lum_dots_limits(const lum_dots *dots, lum_dot_number *number,
                     const double shares[2], float out[2]);

/* --- What it becomes --- */

/** What colours mean. */
typedef struct lum_scale {
    lum_picture_colour colour; /**< of what */
    float low;                 /**< value of the first colour */
    float high;                /**< of the last, above it */
} lum_scale;

/** The scale of points: all but the lowest and the highest 2 %. */
lum_scale lum_scale_of(lum_picture_colour colour, const lum_dots *dots);

/** The colour of a value. */
lum_rgb lum_scale_colour(const lum_scale *scale, float value);

/** What a picture draws with. */
typedef struct lum_drawing {
    lum_canvas *canvas;
    const lum_dots *dots;
    lum_scale scale;
    float unit; /**< pixels of the picture for one of 1600 x 1200 */
} lum_drawing;

extern const lum_rgb lum_paper; /**< background */
extern const lum_rgb lum_panel; /**< background where data could be */
extern const lum_rgb lum_ink;   /**< text */
extern const lum_rgb lum_dim;   /**< less important text */
extern const lum_rgb lum_grid;  /**< lines behind data */

/** So many pixels of a picture of 1600 x 1200, at least 1. */
int lum_pixels(const lum_drawing *d, float n);

/** Write a text of a size, in pixels of a picture of 1600 x 1200.
 * @param cover as lum_style.cover, of the panel. */
void lum_write(const lum_drawing *d, float size, lum_align align, int x, int y,
               float cover, const char *text);

/** A step of 1, 2 or 5 times a power of ten, so that a span has about n. */
float lum_nice_step(float span, int n);

/** The angles of the picture of both eyes: those of lum_image_view_default(),
 * or where a calibration turned the eyes away from these, those of the
 * points. */
lum_image_view lum_panorama_view(const lum_dots *dots);

/** Draw the image of both eyes; its angles are left of the box and below it. */
void lum_draw_panorama(const lum_drawing *d, lum_box box,
                       const lum_image_view *view);

/** Draw the scene from above, and rings of equal distance. */
void lum_draw_ground(const lum_drawing *d, lum_box box);

/** Draw the colour scale with its unit, its ends and numbers between, or the
 * colours of labels. */
void lum_draw_scale(const lum_drawing *d, lum_box box);

#endif
