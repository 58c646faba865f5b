/* The clocks of the host, on POSIX. */
#define _POSIX_C_SOURCE 200809L
#include "lum/base/time.h"

#include <time.h>

#define NS_PER_S INT64_C(1000000000)

static int64_t read_clock(clockid_t id)
{
    struct timespec now = {0};
    (void)clock_gettime(id, &now);
    return (int64_t)now.tv_sec * NS_PER_S + now.tv_nsec;
}

int64_t lum_time_monotonic_ns(void)
{
    return read_clock(CLOCK_MONOTONIC);
}

int64_t lum_time_utc_ns(void)
{
    return read_clock(CLOCK_REALTIME);
}

#if defined(__linux__)

void lum_time_sleep_until(int64_t monotonic_ns)
{
    const struct timespec until = {.tv_sec = (time_t)(monotonic_ns / NS_PER_S),
                                   .tv_nsec = (long)(monotonic_ns % NS_PER_S)};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
}

#else

/* Systems without clock_nanosleep(): a wait of the rest. */
void lum_time_sleep_until(int64_t monotonic_ns)
{
    const int64_t left = monotonic_ns - lum_time_monotonic_ns();
    if (left > 0) {
        const struct timespec wait = {.tv_sec = (time_t)(left / NS_PER_S),
                                      .tv_nsec = (long)(left % NS_PER_S)};
        (void)nanosleep(&wait, NULL);
    }
}

#endif
