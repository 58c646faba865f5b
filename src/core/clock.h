/* Clocks that wrap. */
#ifndef LUM_CORE_CLOCK_H
#define LUM_CORE_CLOCK_H

#include "lum/clock.h"
#include "lum/group.h"

/* What is not set is 0 already, so that the first packet's clock is extended to
 * itself. */
void lum_clock_init(lum_clock *clock, const lum_profile *profile);

/* A packet's clock in microseconds; ticks gets its extended ticks. */
int64_t lum_clock_follow(const lum_clock *clock, const lum_group *group,
                         uint64_t *ticks);

/* The next packet's clock is within half a wrap of these ticks. */
static inline void clock_take(lum_clock *clock, const uint64_t *ticks)
{
    clock->lowest = *ticks - clock->half;
}

#endif
