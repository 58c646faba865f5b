/** @file
 * Distributes the lines of a Y-scan over elevations, and makes the table of raw
 * values (docs/protocol.md, sections 4, 6, 7).
 *
 * Distributions are in integers: millionths of a degree, the eye's own
 * elevation, line 0 uppermost. They strictly fall if the span has room for
 * that. Linear in n, reentrant, no allocation. */
#ifndef LUM_HOST_YSCAN_PLAN_H
#define LUM_HOST_YSCAN_PLAN_H

#include "lum/calibration.h"
#include "lum/host/yscan.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most regions of a distribution. */
#define LUM_YSCAN_REGIONS_MAX 16u

/** A band of elevations and its share of the lines. */
typedef struct lum_yscan_region {
    int32_t min_udeg; /**< lower end */
    int32_t max_udeg; /**< upper end, above min */
    uint32_t weight;  /**< share of the lines relative to other regions,
                           1..1000000 */
} lum_yscan_region;

/** Lines at equal distances, each in the middle of an equal part of the span.
 * @param n 1..LUM_YSCAN_LINES_MAX, here and below.
 * @return LUM_OK; LUM_E_VALUE if min is not below max or n is out of range. */
LUM_MUST_CHECK lum_result lum_yscan_uniform(int32_t min_udeg, int32_t max_udeg,
                                            int32_t *out_udeg, size_t n);

/** Lines as a normal distribution around an elevation, cut off at both ends:
 * densest at center, and as many lines within sigma of it as a normal
 * distribution has there.
 * @param sigma_udeg 10000..90000000.
 * @return LUM_OK; LUM_E_VALUE if a value or n is out of range, or center is
 *         outside min to max. */
LUM_MUST_CHECK lum_result lum_yscan_gaussian(int32_t min_udeg, int32_t max_udeg,
                                             int32_t center_udeg,
                                             int32_t sigma_udeg,
                                             int32_t *out_udeg, size_t n);

/** Lines by regions of interest, at equal distances within each. Shares are
 * rounded so that they add up; every region gets at least one line.
 * @param regions count of them, from the uppermost down, without overlap.
 * @return LUM_OK; LUM_E_VALUE if they overlap or are out of order, a weight is
 *         out of range, count is 0 or above LUM_YSCAN_REGIONS_MAX or n. */
LUM_MUST_CHECK lum_result lum_yscan_regions(const lum_yscan_region *regions,
                                            size_t count, int32_t *out_udeg,
                                            size_t n);

/** How lines are distributed. */
typedef enum lum_yscan_kind {
    LUM_YSCAN_UNIFORM,  /**< lum_yscan_uniform() */
    LUM_YSCAN_GAUSSIAN, /**< lum_yscan_gaussian() */
    LUM_YSCAN_REGIONS   /**< lum_yscan_regions() */
} lum_yscan_kind;

/** The parameters of a distribution, for any number of lines. */
typedef struct lum_yscan_shape {
    lum_yscan_kind kind; /**< decides which other members are used */
    int32_t min_udeg;    /**< uniform, gaussian; INT32_MIN: the span's */
    int32_t max_udeg;    /**< uniform, gaussian; INT32_MAX: the span's */
    int32_t center_udeg; /**< gaussian */
    int32_t sigma_udeg;  /**< gaussian */
    size_t region_count; /**< regions */
    lum_yscan_region regions[LUM_YSCAN_REGIONS_MAX]; /**< uppermost first */
} lum_yscan_shape;

/** Lines distributed by a shape.
 * @param span_min_udeg used for an open lower end.
 * @param span_max_udeg used for an open upper end.
 * @return as the function of its kind; LUM_E_VALUE for an unknown kind. */
LUM_MUST_CHECK lum_result lum_yscan_make(const lum_yscan_shape *shape,
                                         int32_t span_min_udeg,
                                         int32_t span_max_udeg,
                                         int32_t *out_udeg, size_t n);

/** Elevation of a raw value (docs/protocol.md, section 7), as seen from the
 * eye, saturated at 32 bits. Cannot fail. */
int32_t lum_yscan_elevation(const lum_eye_calibration *eye,
                            const lum_layout *layout, int16_t raw);

/** Check a distribution against an eye's calibrated span and make its raw
 * table (docs/protocol.md, sections 4, 6, 7).
 * @param udeg  n elevations that never turn: all falling or all rising; equal
 *              neighbours are allowed.
 * @param at    may be NULL; gets the index of the first wrong one.
 * The span's upper end, 32768 in raw, becomes 32767.
 * @return LUM_OK; LUM_E_VALUE if one is outside the span or turns, or cannot be
 *         expressed in 16 bits with the layout's angle_lsb. */
LUM_MUST_CHECK lum_result lum_yscan_encode(const lum_eye_calibration *eye,
                                           const lum_layout *layout,
                                           const int32_t *udeg, size_t n,
                                           int16_t *out, size_t *at);

#ifdef __cplusplus
}
#endif

#endif
