/** @file
 * A frame as a picture, and back: which point fills each pixel, and the pixel
 * of each point (docs/reader.md).
 *
 * Raw lines (lum_frame_grid_index()) bend, and every second one is scanned from
 * right to left. In a picture, rows are elevations and columns are azimuths,
 * seen from the sensor's origin (lum/image.h), so that a straight edge is
 * straight. This also holds if lum_frame_pose() has placed the points on a
 * vehicle; lum_image_index() has no pose, and looks from the points' origin.
 *
 * @code
 * lum_image_options options = {.struct_size = sizeof options};
 * lum_frame_image_default(frame, LUM_IMAGE_BOTH, &options);
 * const size_t pixels = (size_t)options.view.rows * options.view.columns;
 * uint32_t *index = malloc(pixels * sizeof *index);
 * float *range = malloc(pixels * sizeof *range);
 * if (lum_frame_image_index(frame, &options, index, NULL, NULL) == LUM_OK) {
 *     (void)lum_frame_image(frame, LUM_COLUMN_RANGE, index, pixels, range);
 * }
 * @endcode
 *
 * All functions only read the frame and write the caller's memory; any thread.
 */
#ifndef LUM_FRAME_IMAGE_H
#define LUM_FRAME_IMAGE_H

#include "lum/frame/frame.h"
#include "lum/image.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Which of the points in a pixel fills it; among equals, the first in the
 * frame. A frame's points are in the order of their lines, and those of one
 * pixel of a line in the order of their returns. */
typedef enum lum_image_choice {
    LUM_IMAGE_NEAREST,  /**< the one with the smallest distance to the origin */
    LUM_IMAGE_FARTHEST, /**< the one with the largest */
    LUM_IMAGE_STRONGEST, /**< the widest pulse; needs ::LUM_COLUMN_PULSE_WIDTH
                          */
    LUM_IMAGE_FIRST,     /**< the first in the frame */
    LUM_IMAGE_LAST       /**< the last in the frame */
} lum_image_choice;

/** What is requested. */
typedef struct lum_image_options {
    size_t struct_size; /**< sizeof(lum_image_options), set by the caller */
    uint32_t eyes;      /**< one of ::lum_image_eyes */
    lum_image_choice choice; /**< of the points of a pixel */
    lum_image_view view;     /**< what is shown, in how many pixels */
} lum_image_options;

/** What happened to the points of the requested eyes. The sum is the number of
 * these points. */
typedef struct lum_image_counts {
    size_t struct_size; /**< sizeof(lum_image_counts), set by the caller */
    uint64_t filled;    /**< fill a pixel */
    uint64_t hidden;    /**< lie in a pixel that another point fills */
    uint64_t outside;   /**< lie outside of the view, or have no direction */
} lum_image_counts;

/** Fill in the usual options: these eyes, ::LUM_IMAGE_NEAREST, and
 * lum_image_view_default() for lum_frame_rows(), the larger one of two eyes.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_frame_image_default(const lum_frame *frame, uint32_t eyes,
                                   lum_image_options *out);

/** Which point fills each pixel, and where each point lies.
 *
 * A mask on the picture can select points in two ways: those that fill its
 * pixels, out[p] of each pixel p of the mask; or all that lie there, hidden
 * ones too: each point i with pixels[i] in the mask. A point that fills a pixel
 * lies in it: pixels[out[p]] is p, and out[p] is the one that options->choice
 * takes of the points in p. So out[p] is LUM_FRAME_MISSING only if no point
 * lies in p.
 *
 * Linear; docs/internals/performance.md says how long it takes.
 * @param out     gets rows x columns indices of points, or LUM_FRAME_MISSING.
 * @param pixels  NULL, or gets for each point of the frame its pixel, or
 *                LUM_FRAME_MISSING for points outside of the view or of other
 *                eyes.
 * @param counts  NULL, or gets counts; its struct_size is set by the caller.
 * @return LUM_OK; LUM_E_VALUE if the frame lacks x, y, z or what the choice
 *         needs, if eyes, choice or a value of the view is out of its range, or
 *         if a struct_size is not set: then nothing is written. */
LUM_MUST_CHECK lum_result lum_frame_image_index(
    const lum_frame *frame, const lum_image_options *options, uint32_t *out,
    uint32_t *pixels, lum_image_counts *counts);

/** The numbers of a column as a picture. Pixels without a point are NaN.
 * Integers become floats; exact below 2^24.
 * @param index  n values of lum_frame_image_index().
 * @param out    gets n numbers.
 * @return LUM_OK; LUM_E_VALUE if the frame has no such column, or if an index
 *         that is not LUM_FRAME_MISSING is no point of the frame: then out is
 *         written only in part. Linear. */
LUM_MUST_CHECK lum_result lum_frame_image(const lum_frame *frame,
                                          lum_column column,
                                          const uint32_t *index, size_t n,
                                          float *out);

/** Any points, in the order of a frame. */
typedef struct lum_image_points {
    size_t struct_size; /**< sizeof(lum_image_points), set by the caller */
    size_t count;       /**< points, below 2^31 */
    const float *x;     /**< metres, forward */
    const float *y;     /**< metres, left */
    const float *z;     /**< metres, up */
    const float *pulse_width; /**< from 0; NULL, except for
                                   ::LUM_IMAGE_STRONGEST */
    const uint8_t *eye;       /**< an ::lum_eye of each; NULL: all points are
                                   requested */
} lum_image_points;

/** As lum_frame_image_index(), for arrays. */
LUM_MUST_CHECK lum_result lum_image_index(const lum_image_points *points,
                                          const lum_image_options *options,
                                          uint32_t *out, uint32_t *pixels,
                                          lum_image_counts *counts);

/** As lum_frame_image(), for an array of count numbers. */
LUM_MUST_CHECK lum_result lum_image_take(const float *numbers, size_t count,
                                         const uint32_t *index, size_t n,
                                         float *out);

#ifdef __cplusplus
}
#endif

#endif
