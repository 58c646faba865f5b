/* The sensor's clock as its packets tell it (docs/protocol.md, section 6,
 * Reassembly, rules 1 and 2). */
#ifndef LUM_CORE_STREAM_H
#define LUM_CORE_STREAM_H

#include "lum/assembler.h"

/* Before all clocks, and far enough from the limit to be subtracted from. */
#define STREAM_LONG_AGO (INT64_MIN / 2)

/* Where a packet stands. */
enum lum_stream_place {
    STREAM_STRAY, /* far away */
    STREAM_NEAR,  /* in the stream */
    STREAM_BREAK, /* the stream has jumped to it */
};

/* Judges the clock of the packet at hand, and takes note of it. */
enum lum_stream_place lum_stream_take(lum_assembler *a, lum_eye_stream *s);

/* Any clock may come next. */
void lum_stream_end(lum_assembler *a);

/* How far a clock is ahead of another, cut to what 32 bits hold: all that it is
 * held against is less. */
int32_t lum_stream_lead(const int64_t *clock_us, const int64_t *other_us);

/* reach_us: below 2^31. */
static inline bool stream_is_within(int32_t lead_us, uint32_t reach_us)
{
    return (uint32_t)lead_us + reach_us <= 2u * reach_us;
}

#endif
