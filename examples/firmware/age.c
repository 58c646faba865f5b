#include "age.h"

#define US_PER_MS 1000u

void age_init(age *a)
{
    *a = (age){.answered = false};
}

void age_answer(age *a, const lum_timestamp *answer, int64_t now_ms,
                uint32_t max_ms)
{
    const uint32_t ago_ms = (uint32_t)now_ms - answer->sequence;
    const int64_t asked_ms = now_ms - (int64_t)ago_ms;

    if (ago_ms >= max_ms || (a->answered && asked_ms < a->asked_ms)) {
        return;
    }
    a->asked_ms = asked_ms;
    a->clock_us = answer->clock_us;
    a->answered = true;
}

/* Modulo 2^32, as the sensor's clock is. */
uint32_t age_of(const age *a, uint32_t clock_us, int64_t now_ms)
{
    const int64_t since_ms = now_ms - a->asked_ms;
    uint32_t age_us;

    if (!a->answered || since_ms > (int64_t)AGE_KEPT_MS) {
        return AGE_UNKNOWN;
    }
    age_us = (uint32_t)since_ms * US_PER_MS - (clock_us - a->clock_us);
    if (0u - age_us <= AGE_AHEAD_MS * US_PER_MS) {
        return 0;
    }
    return age_us / US_PER_MS + (age_us % US_PER_MS != 0 ? 1u : 0u);
}
