#define _GNU_SOURCE /* CLOCK_BOOTTIME */
#include "clock_calls.h"

#include "host.h"
#include "task.h"
#include "time.h"

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <time.h>

#define CLOCK_NS 100
#define SLEEP_NS (1 * WORLD_US)

/* The calendar's clock may be set while somebody sleeps by it: the sleeper
 * looks again this often. */
#define LOOK_NS WORLD_S

static bool is_of_calendar(clockid_t clock)
{
    return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE;
}

static bool is_known(clockid_t clock)
{
    return is_of_calendar(clock) || clock == CLOCK_MONOTONIC ||
           clock == CLOCK_MONOTONIC_RAW || clock == CLOCK_MONOTONIC_COARSE ||
           clock == CLOCK_BOOTTIME;
}

static int64_t read_clock(clockid_t clock)
{
    const world_host *host = world_process_self()->host;
    return is_of_calendar(clock) ? world_host_utc_ns(host)
                                 : world_host_mono_ns(host);
}

static struct timespec timespec_of(int64_t ns)
{
    return (struct timespec){.tv_sec = (time_t)(ns / WORLD_S),
                             .tv_nsec = (long)(ns % WORLD_S)};
}

int world_call_clock_gettime(clockid_t clock, struct timespec *out)
{
    world_call(CLOCK_NS);
    if (!is_known(clock)) {
        errno = EINVAL;
        return -1;
    }
    *out = timespec_of(read_clock(clock));
    return 0;
}

time_t world_call_time(time_t *out)
{
    world_call(CLOCK_NS);
    const time_t now = (time_t)(read_clock(CLOCK_REALTIME) / WORLD_S);
    if (out != NULL) {
        *out = now;
    }
    return now;
}

/* The hosts of the world are in UTC. */
struct tm *world_call_localtime_r(const time_t *time, struct tm *out)
{
    return gmtime_r(time, out);
}

/* 0, or EINTR. */
static int sleep_until(clockid_t clock, int64_t until_ns)
{
    const world_host *host = world_process_self()->host;
    world_queue nobody = {NULL, NULL};
    for (int64_t left_ns = until_ns - read_clock(clock); left_ns > 0;
         left_ns = until_ns - read_clock(clock)) {
        const int64_t look_ns =
            is_of_calendar(clock) && left_ns > LOOK_NS ? LOOK_NS : left_ns;
        const int64_t mono_ns = world_host_mono_ns(host) + look_ns;
        if (world_wait(&nobody, world_host_true_ns(host, mono_ns)) ==
            WORLD_INTERRUPTED) {
            return EINTR;
        }
    }
    return 0;
}

/* A relative sleep is by the monotonic clock, whichever is named. */
int world_call_clock_nanosleep(clockid_t clock, int flags,
                               const struct timespec *wanted,
                               struct timespec *left)
{
    world_call(SLEEP_NS);
    const int64_t wanted_ns =
        (int64_t)wanted->tv_sec * WORLD_S + (int64_t)wanted->tv_nsec;
    if (!is_known(clock) || wanted->tv_sec < 0 || wanted->tv_nsec < 0 ||
        wanted->tv_nsec >= WORLD_S) {
        return EINVAL;
    }
    if ((flags & TIMER_ABSTIME) != 0) {
        return sleep_until(clock, wanted_ns);
    }
    const int64_t until_ns = read_clock(CLOCK_MONOTONIC) + wanted_ns;
    const int code = sleep_until(CLOCK_MONOTONIC, until_ns);
    if (code != 0 && left != NULL) {
        const int64_t left_ns = until_ns - read_clock(CLOCK_MONOTONIC);
        *left = timespec_of(left_ns > 0 ? left_ns : 0);
    }
    return code;
}
