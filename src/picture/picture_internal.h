/** @file
 * The parts of a picture, and the points that it keeps, in bounded memory.
 * Internal to picture. */
#ifndef LUM_PICTURE_PICTURE_INTERNAL_H
#define LUM_PICTURE_PICTURE_INTERNAL_H

#include "cloud/sink.h"

#include "lum/cloud/writer.h"
#include "lum/image.h"
#include "lum/picture/picture.h"

#include <stdint.h>

/* --- Pixels, boxes, circles, text, a colour scale, PNG: canvas.c ---
 *
 * What lies outside a canvas is not drawn. If cairo runs out of memory, the
 * rest is not drawn either, and lum_canvas_write() reports it. */

/** A colour. */
typedef struct lum_rgb {
    uint8_t r; /**< red */
    uint8_t g; /**< green */
    uint8_t b; /**< blue */
} lum_rgb;

/** Pixels, x from the left, y from the top. */
typedef struct lum_canvas lum_canvas;

/** Part of a canvas. */
typedef struct lum_box {
    int x;      /**< left */
    int y;      /**< top */
    int width;  /**< pixels */
    int height; /**< pixels */
} lum_box;

/** Which part of a text is at the given place. */
typedef enum lum_align {
    LUM_ALIGN_LEFT,   /**< its beginning */
    LUM_ALIGN_MIDDLE, /**< its middle */
    LUM_ALIGN_RIGHT   /**< its end */
} lum_align;

/** How a text looks. */
typedef struct lum_style {
    float size;      /**< pixels from the top of a line to that of the next */
    lum_align align; /**< about x */
    lum_rgb colour;  /**< of the letters */
    lum_rgb back;    /**< of a box behind them */
    float cover;     /**< opacity of that box: 0 hides nothing, 1 all */
} lum_style;

/** Make a black canvas.
 * @return NULL: no memory. */
lum_canvas *lum_canvas_new(int width, int height);

/** Free one. NULL is allowed. */
void lum_canvas_free(lum_canvas *canvas);

/** Colour a pixel. */
void lum_canvas_set(lum_canvas *canvas, int x, int y, lum_rgb colour);

/** The colour of a pixel; black outside. */
lum_rgb lum_canvas_get(const lum_canvas *canvas, int x, int y);

/** Colour a box. */
void lum_canvas_fill(lum_canvas *canvas, lum_box box, lum_rgb colour);

/** Draw the part of a circle that lies in a box, as a line of one pixel.
 * @param x,y,radius pixels. */
void lum_canvas_circle(lum_canvas *canvas, lum_box box, float x, float y,
                       float radius, lum_rgb colour);

/** Write a text in printable ASCII; y is half way up its digits. */
void lum_canvas_text(lum_canvas *canvas, const lum_style *style, int x, int y,
                     const char *text);

/** The colour scale, viridis: from 0, dark blue, to 1, yellow. It rises in
 * brightness, so that those who cannot tell red from green can read it. */
lum_rgb lum_colour(float part);

/** The colour of a label; the ninth has that of the first again. */
lum_rgb lum_label_colour(float label);

/** A colour, darkened: 1 does not change it, 0 is black. */
lum_rgb lum_shade(lum_rgb colour, float light);

/** Write a canvas as PNG.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_canvas_write(const lum_canvas *canvas, lum_sink *sink,
                                    lum_error *error);

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
