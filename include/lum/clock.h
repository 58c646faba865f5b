/** @file
 * The sensor's clock beyond its bits (docs/protocol.md, section 6).
 * Integers alone, reentrant, constant time. */
#ifndef LUM_CLOCK_H
#define LUM_CLOCK_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The clock of an assembler or a receiver. Private. */
typedef struct lum_clock {
    uint32_t unit_ns; /**< private: length of a tick, for layout_any.c */
    uint64_t mask;    /**< private: its bits, likewise; 0: there is none */
    uint64_t half;    /**< private: half a wrap */
    uint64_t lowest;  /**< private: ticks that the next packet has at least:
                           half a wrap below the last but strays */
} lum_clock;

/** Extend a wrapped clock by its signed difference from the reading before.
 * @param before the extended reading before this one, in ticks.
 * @param raw    the new reading; bits above its width are ignored.
 * @param bits   width of the reading on the wire, 1..63; with 0 there is no
 *               clock and the answer is before.
 * @return the extended reading, within half the wrap of before. A clock below 0
 *         is below 2^64 as much. */
uint64_t lum_clock_extend(uint64_t before, uint64_t raw, unsigned bits);

/** Ticks in microseconds, rounded down.
 * @param ticks   an extended reading; below 0 from 2^64 - 1000 x 2^52 on.
 * @param unit_ns length of a tick, 1..::LUM_CLOCK_UNIT_MAX_NS.
 * @return exact within 2^61 us of 0; of what is farther away, the lowest 64
 *         bits. */
int64_t lum_clock_us(uint64_t ticks, uint32_t unit_ns);

#ifdef __cplusplus
}
#endif

#endif
