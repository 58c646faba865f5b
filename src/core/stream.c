#include "stream.h"

#include "bytes.h"
#include "clock.h"

int32_t lum_stream_lead(const int64_t *clock_us, const int64_t *other_us)
{
    const uint64_t us = (uint64_t)*clock_us - (uint64_t)*other_us;
    const int32_t low = signed32((uint32_t)us);
    const int32_t limit = us >> 63 != 0 ? INT32_MIN : INT32_MAX;
    return us == (uint64_t)low ? low : limit;
}

/* Within 2^61 us of 0, 70,000 years: sums and differences of clocks fit. Only
 * forged packets lead farther; of these, a stray, it is known that it is far
 * from all clocks. */
static bool is_clock(const int64_t *us)
{
    const uint32_t high = (uint32_t)((uint64_t)*us >> 32);
    return high + (UINT32_C(1) << 29) < UINT32_C(1) << 30;
}

/* is_newest: set where it is the largest clock since the last break. */
static enum lum_stream_place judge(const lum_assembler *a,
                                   const lum_eye_stream *s, bool *is_newest)
{
    const int64_t *clock_us = &a->awaited.clock_us;
    const uint32_t gap_us = a->config.gap_us;
    if (!is_clock(clock_us)) {
        return STREAM_STRAY;
    }
    *is_newest = true;
    if (s->seen == 0) {
        return STREAM_NEAR;
    }
    const int32_t lead_us = lum_stream_lead(clock_us, &s->newest_us);
    if (stream_is_within(lead_us, gap_us)) {
        *is_newest = lead_us > 0;
        return STREAM_NEAR;
    }
    return stream_is_within(lum_stream_lead(clock_us, &s->candidate_us), gap_us)
               ? STREAM_BREAK
               : STREAM_STRAY;
}

enum lum_stream_place lum_stream_take(lum_assembler *a, lum_eye_stream *s)
{
    bool is_newest = false;
    const int64_t *clock_us = &a->awaited.clock_us;
    const enum lum_stream_place place = judge(a, s, &is_newest);
    if (place == STREAM_STRAY) {
        s->candidate_us = *clock_us;
        return place;
    }
    s->candidate_us = STREAM_LONG_AGO;
    clock_take(&a->stream.clock, &a->awaited.ticks);
    if (place == STREAM_BREAK || a->stream.begun == 0) {
        /* silence of either eye is counted from here on */
        a->eye[LUM_EYE_BLUE].stream.heard_us = *clock_us;
        a->eye[LUM_EYE_GREEN].stream.heard_us = *clock_us;
        a->stream.begun = 1;
    }
    if (is_newest) {
        s->newest_us = *clock_us;
    }
    s->heard_us = s->newest_us;
    s->seen = 1;
    return place;
}

void lum_stream_end(lum_assembler *a)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        a->eye[e].stream.seen = 0;
        a->eye[e].stream.candidate_us = STREAM_LONG_AGO;
    }
    a->stream.begun = 0;
}
