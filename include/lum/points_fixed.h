/** @file
 * Lines to points, in integers only (docs/protocol.md, section 7).
 *
 * For controllers without a floating-point unit: no float, no
 * mathematical library, no division, no heap. x forward, y left, z up, in
 * sixteenths of a millimetre, in the frame of the sensor. The same integers on
 * every target.
 *
 * Error, whatever the calibration: at most 0.17 mm and 0.32 um for each metre
 * of range, so 0.25 mm at 250 m; the largest that was measured there is 0.12
 * mm. An angle lsb of a profile adds 0.25 um for each metre of range and each
 * degree of a bit, so 0.06 um at 250 m and 0.001 degrees (docs/fixed.md).
 */
#ifndef LUM_POINTS_FIXED_H
#define LUM_POINTS_FIXED_H

#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/point_losses.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Units of a coordinate in a millimetre. */
#define LUM_FIXED_PER_MM 16

/** Raised when a ::lum_fixed_projector that was made elsewhere (by lumtable)
 * would differ from what lum_fixed_projector_init() makes of the same
 * calibration. */
#define LUM_FIXED_PROJECTOR_VERSION 1

/** How raw angles of an axis become angles of 2^-32 turns. Private. */
typedef struct lum_fixed_axis {
    uint32_t center; /**< private: of raw 0 */
    uint32_t whole;  /**< private: of a bit, whole units */
    int32_t part;    /**< private: of a bit, 2^-15 units */
} lum_fixed_axis;

/** How one eye's samples become geometry. Private: made by
 * lum_fixed_projector_init(). */
typedef struct lum_fixed_eye {
    int64_t mount[3];    /**< private: 2^-28 units, plus a half */
    uint64_t range_base; /**< private: 2^-32 units, plus a half, at first_tof */
    uint32_t range_lsb;  /**< private: 2^-20 units a bit */
    int32_t first_tof;   /**< private */
    lum_fixed_axis azimuth;   /**< private */
    lum_fixed_axis elevation; /**< private */
    int32_t axes[3][3];       /**< private: the sensor's, 2^-30 */
} lum_fixed_eye;

/** How a sensor's samples become points. Once made it is only read, so threads
 * and interrupts may share it. */
typedef struct lum_fixed_projector {
    lum_fixed_eye eye[LUM_EYES]; /**< private */
} lum_fixed_projector;

/** Make a projector.
 * @param out         caller-owned; written only on LUM_OK.
 * @param calibration checked here; not kept.
 * @param layout      has the scale of angles: that of the assembler whose lines
 *                    will be projected; not kept.
 * @return LUM_OK; LUM_E_VALUE as lum_calibration_check(). */
LUM_MUST_CHECK lum_result lum_fixed_projector_init(
    lum_fixed_projector *out, const lum_calibration *calibration,
    const lum_layout *layout);

/** A point and the word it came from. Sixteenths of a millimetre; within
 * +-1.4 x 10^9. */
typedef struct lum_fixed_point {
    int32_t x;     /**< forward */
    int32_t y;     /**< left */
    int32_t z;     /**< up */
    uint32_t word; /**< the range word: time of flight, edge, pixel */
} lum_fixed_point;

/** Words of a line to points, in their order: all at once, or block by block
 * into a small buffer. Falling edges become points as rising ones do; choose
 * with lum_word_is_rising(point.word). lumdump writes only those of rising
 * edges.
 *
 * Points keep the order of words; words without a point are left out and
 * counted. To find the return of each point, go through words and points side
 * by side: if the next point has another word than the current one, the current
 * word has no point. lum_returns_compute() sees only the words that it is
 * given: give it whole pixels.
 *
 * @code
 * n = lum_points_fixed_compute(&p, line, first, count, points, &losses);
 * lum_returns_compute(line->words + first, count, returns);
 * for (i = 0, k = 0; k < n; i++) {
 *     if (points[k].word == line->words[first + i]) {
 *         use(&points[k++], &returns[i]);
 *     }
 * }
 * @endcode
 *
 * In this example first + count must not exceed line->word_count, and a block
 * must begin where a pixel begins (or be the whole line).
 * @param line   from an assembler or a receiver: the pixels of its words are
 *               below LUM_LINE_PIXELS, which is not checked here.
 * @param first  index of the first word; none are taken past the end.
 * @param count  how many words; fewer are taken where the line ends.
 * @param out    room for that many points.
 * @param losses words without a point are added to it; not NULL.
 * @return how many points were written. Linear; reentrant. The direction of a
 *         pixel is computed once for its words that follow each other. */
size_t lum_points_fixed_compute(const lum_fixed_projector *projector,
                                const lum_line *line, uint32_t first,
                                uint32_t count, lum_fixed_point *out,
                                lum_point_losses *losses);

#ifdef __cplusplus
}
#endif

#endif
