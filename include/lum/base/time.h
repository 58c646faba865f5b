/** @file
 * The host's monotonic clock and its UTC clock. Each call is reentrant and
 * cannot fail. */
#ifndef LUM_BASE_TIME_H
#define LUM_BASE_TIME_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Time since an arbitrary moment, ns; never goes back, the same for all
 * processes of a host where the system has such a clock. */
int64_t lum_time_monotonic_ns(void);

/** Time since 1970 UTC, ns; jumps when the host's clock is set. */
int64_t lum_time_utc_ns(void);

/** Sleep until the monotonic clock reaches a time. Returns at once when it has
 * passed, and early when a signal comes. */
void lum_time_sleep_until(int64_t monotonic_ns);

#ifdef __cplusplus
}
#endif

#endif
