/** @file
 * Extends the sensor's clock beyond its width on the wire (docs/protocol.md,
 * section 6). Integers only, reentrant, constant time. */
#ifndef LUM_CLOCK_H
#define LUM_CLOCK_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The clock of an assembler or a receiver. Private. */
typedef struct lum_clock {
    uint32_t unit_ns; /**< private: length of a tick, for layout_any.c */
    uint64_t mask;    /**< private: of its bits, likewise; 0: no clock */
    uint64_t half;    /**< private: half a wrap */
    uint64_t lowest;  /**< private: least ticks of the next packet: half a wrap
                           below the last that was no stray */
} lum_clock;

/** Extend a wrapped clock by its signed difference from the reading before.
 * @param before the extended reading before this one, in ticks.
 * @param raw    the new reading; bits above its width are ignored.
 * @param bits   width of the reading on the wire, 1..63; 0: there is no clock,
 *               and before is returned.
 * @return the extended reading, within half the wrap of before; 2^64 - n means
 *         -n. */
uint64_t lum_clock_extend(uint64_t before, uint64_t raw, unsigned bits);

/** Ticks in microseconds, rounded down.
 * @param ticks   an extended reading; from 2^64 - 1000 x 2^52 on it is
 *                negative.
 * @param unit_ns length of a tick, 1..::LUM_CLOCK_UNIT_MAX_NS.
 * @return exact within 2^61 us of 0; beyond that, only the lowest 64 bits. */
int64_t lum_clock_us(uint64_t ticks, uint32_t unit_ns);

#ifdef __cplusplus
}
#endif

#endif
