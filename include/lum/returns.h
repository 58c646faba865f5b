/** @file
 * Returns of a line: numbers, counts and pulse widths (docs/protocol.md,
 * section 7). */
#ifndef LUM_RETURNS_H
#define LUM_RETURNS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The place of a word among the words of its pixel. */
typedef struct lum_return {
    uint16_t number;    /**< from 1, among words of the same edge */
    uint16_t count;     /**< words of the pixel with the same edge */
    uint32_t width_tof; /**< pulse width of a rising word in units of the tof
                             lsb; 0 if unknown */
} lum_return;

/** Number the words of a line.
 * @param words ordered by pixel, as a line is handed out; not kept.
 * @param n     how many, at most 65,535.
 * @param out   caller-owned, n entries, all written.
 * One pass, linear; reentrant. */
void lum_returns_compute(const uint32_t *words, size_t n, lum_return *out);

#ifdef __cplusplus
}
#endif

#endif
