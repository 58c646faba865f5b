/** @file
 * Where points lie in a picture. Its rows have equal elevation, the highest
 * first, and its columns equal azimuth, from left to right when looking
 * forward.
 *
 * Angles are seen from the origin of the points, which is that of the sensor:
 * azimuth atan2(y, x), positive to the left; elevation atan2(z, hypot(x, y)).
 * So both eyes make one picture, and a point has one place in it, whichever eye
 * saw it. No heap and no I/O; all state belongs to the caller. Pictures of
 * frames are in lum/frame/image.h. */
#ifndef LUM_IMAGE_H
#define LUM_IMAGE_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Marks a point that lies outside of a picture, and a pixel without one. */
#define LUM_IMAGE_NONE UINT32_MAX

/** Most pixels of a picture. */
#define LUM_IMAGE_PIXELS_MAX 0x10000000u

/** The eyes of a picture, a bit each: 1 << an ::lum_eye. */
typedef enum lum_image_eyes {
    LUM_IMAGE_BLUE = 1,  /**< it looks right */
    LUM_IMAGE_GREEN = 2, /**< it looks left */
    LUM_IMAGE_BOTH = 3   /**< one picture of both */
} lum_image_eyes;

/** What a picture shows, and in how many pixels. */
typedef struct lum_image_view {
    float left_deg;   /**< azimuth of its left edge; -360..360 */
    float right_deg;  /**< below left_deg, by at most 360 */
    float top_deg;    /**< elevation of its upper edge; at most 90 */
    float bottom_deg; /**< below top_deg; at least -90 */
    uint32_t rows;    /**< from 1 */
    uint32_t columns; /**< from 1; rows x columns: at most
                           ::LUM_IMAGE_PIXELS_MAX */
} lum_image_view;

/** The view of the manual's typical eyes: elevations from 3 down to -17
 * degrees; azimuths from 60 to 0 degrees (green), 0 to -60 (blue), 60 to -60
 * (both).
 *
 * An eye gets 800 columns, both 1600: 0.075 degrees, so that lines of 1000
 * pixels leave no column empty where their mirror is fastest. Rows are the
 * lines, rounded up to a multiple of 64, at least 64: a frame that lacks its
 * last lines has the same picture. Cannot fail.
 * @param eyes  a value other than ::lum_image_eyes means both.
 * @param lines of an eye; limited so that the pixels are at most
 *              ::LUM_IMAGE_PIXELS_MAX. */
void lum_image_view_default(lum_image_view *out, unsigned eyes, uint32_t lines);

/** A view, made ready for lum_image_pixels(). Private: made by
 * lum_image_scale_init(). */
typedef struct lum_image_scale {
    float left;       /**< private: columns from forward to the left edge */
    float top;        /**< private: rows from elevation 0 to the upper edge */
    float per_column; /**< private: columns of a radian */
    float per_row;    /**< private: rows of a radian */
    float columns;    /**< private */
    float rows;       /**< private */
    int32_t width;    /**< private: columns */
    int32_t height;   /**< private: rows */
    bool is_before;   /**< private: no part of it is behind or steep */
} lum_image_scale;

/** Make a view ready.
 * @param out written only on LUM_OK.
 * @return LUM_OK; LUM_E_VALUE if a value of the view is out of its range. */
LUM_MUST_CHECK lum_result lum_image_scale_init(lum_image_scale *out,
                                               const lum_image_view *view);

/** The pixels that points lie in.
 *
 * Points beyond an edge by at most half a pixel lie in the pixel at the edge,
 * so that noise does not remove them. Angles are exact within 0.0005 degrees. A
 * view that lies in front of the sensor and within 45 degrees of elevation 0 is
 * computed in vectors, others point by point.
 * @param x,y,z n numbers each, in any unit.
 * @param out   gets n values: row x columns + column, or ::LUM_IMAGE_NONE for
 *              points outside, without an azimuth (0, 0, z), or with a number
 *              that is not finite.
 * Linear. Results of vectors are the same on every processor. */
void lum_image_pixels(const lum_image_scale *scale, const float *x,
                      const float *y, const float *z, size_t n, uint32_t *out);

#ifdef __cplusplus
}
#endif

#endif
