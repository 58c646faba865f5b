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

static bool is_known(const age *a, int64_t now_ms)
{
    return a->answered && now_ms - a->asked_ms <= (int64_t)AGE_KEPT_MS;
}

/* Modulo 2^32, as the sensor's clock is. */
static uint32_t find_age_us(const age *a, uint32_t clock_us, int64_t now_ms)
{
    return (uint32_t)(now_ms - a->asked_ms) * US_PER_MS -
           (clock_us - a->clock_us);
}

bool age_is_ahead(const age *a, uint32_t clock_us, int64_t now_ms,
                  uint32_t ahead_ms)
{
    const uint32_t ahead_us = 0u - find_age_us(a, clock_us, now_ms);

    return is_known(a, now_ms) && ahead_us > ahead_ms * US_PER_MS &&
           ahead_us <= AGE_MAX_MS * US_PER_MS;
}

uint32_t age_of(const age *a, uint32_t clock_us, int64_t now_ms)
{
    const uint32_t age_us = find_age_us(a, clock_us, now_ms);

    if (!is_known(a, now_ms)) {
        return AGE_UNKNOWN;
    }
    if (0u - age_us <= AGE_AHEAD_MS * US_PER_MS) {
        return 0;
    }
    return age_us / US_PER_MS + (age_us % US_PER_MS != 0 ? 1u : 0u);
}
