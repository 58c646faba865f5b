/** @file
 * Smooths angles: a Savitzky-Golay filter along each line, azimuth and
 * elevation separately (docs/smoothing.md).
 *
 * A mirror moves smoothly, but its encoder has noise. Each pixel's angle is
 * taken from the least-squares polynomial through the readings around it.
 *
 * @code
 * lum_angle angles[LUM_LINE_PIXELS];
 * lum_line smoothed = *line;
 * lum_smooth_line(&smooth, line, angles);
 * smoothed.angles = angles;
 * @endcode
 *
 * The functions that take lines (lum/points.h) also take the smoothed one. No
 * heap, no I/O and no libm; all state belongs to the caller. A lum_smooth, once
 * made, is only read, so threads may share it. */
#ifndef LUM_SMOOTH_H
#define LUM_SMOOTH_H

#include "lum/assembler.h"
#include "lum/group.h"
#include "lum/result.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LUM_SMOOTH_WINDOW_MAX 63u /**< widest window, in pixels */
#define LUM_SMOOTH_ORDER_MAX  5u  /**< highest order */
#define LUM_SMOOTH_WINDOW     31u /**< the window to begin with */

/** The order that suits a window: 2, or 1 with a window of 3. */
#define LUM_SMOOTH_ORDER(window) ((window) > 3u ? 2u : (window) > 1u ? 1u : 0u)

/** A filter. Private: made by lum_smooth_init(). */
typedef struct lum_smooth {
    float weights[LUM_SMOOTH_WINDOW_MAX / 2u + 1u]; /**< private: of a pixel's
                                                         distance */
    uint8_t window;                                 /**< private */
    uint8_t order;                                  /**< private */
} lum_smooth;

/** Make a filter.
 * @param out    caller-owned; written only on LUM_OK.
 * @param window pixels that each angle is taken from: odd,
 *               1..LUM_SMOOTH_WINDOW_MAX; 1 is off and changes nothing.
 * @param order  of the polynomials, 0..LUM_SMOOTH_ORDER_MAX and below window;
 *               window - 1 changes nothing either. See LUM_SMOOTH_ORDER().
 * @return LUM_OK; LUM_E_VALUE if either is outside its range. */
LUM_MUST_CHECK lum_result lum_smooth_init(lum_smooth *out, uint32_t window,
                                          uint32_t order);

/** Smooth a line's angles.
 * @param line its raw angles and their marks are read.
 * @param out  LUM_LINE_PIXELS raw angles, rounded to the nearest; may be where
 *             line->angles points. Pixels without angles keep what they have.
 *
 * Pixels that have angles are smoothed run by run: a pixel without angles ends
 * a run, and pixels beyond it have no influence. Within half a window of a
 * run's end the polynomial of its last whole window is used, so that the ends
 * are not pulled inwards. A run shorter than the window is one polynomial; one
 * of order + 1 pixels or fewer stays as it is.
 *
 * 8 KB of stack. Time is linear in the window: on a PC some 8 us a line with
 * ::LUM_SMOOTH_WINDOW, 12 us with the widest; for all lines of both eyes, 64 at
 * 10 Hz, 1 % of a core. */
void lum_smooth_line(const lum_smooth *smooth, const lum_line *line,
                     lum_angle out[LUM_LINE_PIXELS]);

#ifdef __cplusplus
}
#endif

#endif
