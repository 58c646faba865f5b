#include "stream.h"

#include "bytes.h"
#include "frames.h"
#include "lum/clock.h"

int32_t lum_stream_lead(const int64_t *clock_us, const int64_t *other_us)
{
    const int64_t us = *clock_us - *other_us;
    const int32_t low = signed32((uint32_t)us);
    const int32_t limit = us < 0 ? INT32_MIN : INT32_MAX;
    return us == low ? low : limit;
}

/* Silence is counted from here on, for a clock that has begun or jumped. */
static void hear_both(lum_assembler *a)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        a->eye[e].heard_us = a->packet_clock_us;
    }
}

static void read_clock(lum_assembler *a, uint32_t raw)
{
    if (a->clock_begun) {
        a->packet_clock_us = lum_clock_extend(a->clock_us, raw, a->clock_bytes);
    } else {
        a->clock_begun = true;
        a->packet_clock_us = raw;
        hear_both(a);
    }
}

/* Within 2^61 us of 0, 70,000 years: sums and differences of clocks fit. Only
 * forged packets lead the clock farther. */
static bool is_clock(int64_t us)
{
    return ((uint64_t)us + (UINT64_C(1) << 61)) >> 62 == 0;
}

enum lum_stream_place lum_stream_place(lum_assembler *a, lum_eye_state *eye,
                                       uint32_t clock_raw)
{
    const uint32_t gap_us = a->config.gap_us;
    const int64_t *clock_us = &a->packet_clock_us;
    enum lum_stream_place place = STREAM_NEAR;
    read_clock(a, clock_raw);
    if (!is_clock(*clock_us)) {
        return STREAM_STRAY;
    }
    const int32_t ahead_us =
        eye->seen ? lum_stream_lead(clock_us, &eye->newest_us) : 0;
    if (stream_is_within(ahead_us, gap_us)) {
        if (ahead_us >= 0) {
            eye->newest_us = *clock_us;
        }
        eye->heard_us = eye->newest_us;
        eye->seen = true;
    } else if (stream_is_within(lum_stream_lead(clock_us, &eye->candidate_us),
                                gap_us)) {
        place = STREAM_BREAK;
    } else {
        eye->candidate_us = *clock_us;
        return STREAM_STRAY;
    }
    eye->candidate_us = STREAM_LONG_AGO;
    a->clock_us = *clock_us;
    return place;
}

void lum_stream_jump(lum_assembler *a, lum_eye_state *eye)
{
    eye->newest_us = a->packet_clock_us;
    eye->low_clock_us = STREAM_LONG_AGO;
    eye->closed_next = 0;
    eye->closed_count = 0;
    hear_both(a);
    lum_frames_break(eye);
}
