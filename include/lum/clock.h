/** @file
 * The sensor's clock beyond its 32 bits (docs/protocol.md, section 6).
 * Integers alone, reentrant, constant time. */
#ifndef LUM_CLOCK_H
#define LUM_CLOCK_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Extend a wrapped clock by its signed difference from the reading before.
 * @param before the extended reading before this one.
 * @param raw    the new reading; bits above its width are ignored.
 * @param bytes  width of the reading on the wire: 1, 2 or 4; with 0 there is
 *               no clock and the answer is before.
 * @return the extended reading, within half the wrap of before. */
int64_t lum_clock_extend(int64_t before, uint32_t raw, unsigned bytes);

#ifdef __cplusplus
}
#endif

#endif
