/** @file
 * A picture in memory: pixels, text, a colour scale, PNG. Internal to
 * picture. */
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

/** Pixels, row by row from the top left. */
typedef struct lum_canvas {
    int width;    /**< pixels */
    int height;   /**< pixels */
    lum_rgb *rgb; /**< width x height */
} lum_canvas;

/** Part of a canvas. */
typedef struct lum_box {
    int x;      /**< left */
    int y;      /**< top */
    int width;  /**< pixels */
    int height; /**< pixels */
} lum_box;

#define LUM_GLYPH_WIDTH  6 /**< of a character at scale 1, gap included */
#define LUM_GLYPH_HEIGHT 7 /**< of a character at scale 1 */

/** Colour a pixel; outside of the canvas nothing happens. */
void lum_canvas_set(lum_canvas *canvas, int x, int y, lum_rgb colour);

/** Colour a box. */
void lum_canvas_fill(lum_canvas *canvas, lum_box box, lum_rgb colour);

/** Write capitals, digits, blanks and . , : - ( ) / m (metres) ^ (degrees);
 * other characters stay blank.
 * @param scale pixels of canvas for a pixel of a letter. */
void lum_canvas_text(lum_canvas *canvas, int x, int y, int scale,
                     lum_rgb colour, const char *text);

/** How wide a text is at a scale. */
int lum_canvas_text_width(const char *text, int scale);

/** The colour scale: 0 is near, red; 1 is far, violet. */
lum_rgb lum_colour(float part);

/** A colour, darkened: 1 leaves it, 0 is black. */
lum_rgb lum_shade(lum_rgb colour, float light);

/** Write a canvas as PNG.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_canvas_write(const lum_canvas *canvas, lum_sink *sink,
                                    lum_error *error);

#endif
