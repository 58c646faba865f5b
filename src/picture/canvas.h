/** @file
 * A picture in memory that cairo draws: pixels, boxes, circles, text, a colour
 * scale, PNG. Internal to picture.
 *
 * What lies outside a canvas is not drawn. If cairo runs out of memory, the
 * rest is not drawn either, and lum_canvas_write() reports it. */
#ifndef LUM_PICTURE_CANVAS_H
#define LUM_PICTURE_CANVAS_H

#include "cloud/sink.h"

#include <stdint.h>

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

#endif
