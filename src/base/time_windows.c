/* The clocks of the host, on Windows. */
#include "lum/base/time.h"

#include <windows.h>

#define NS_PER_S INT64_C(1000000000)

/* From 1601, where Windows counts from, to 1970, in units of 100 ns. */
#define EPOCH INT64_C(116444736000000000)

int64_t lum_time_monotonic_ns(void)
{
    LARGE_INTEGER count;
    LARGE_INTEGER rate;
    (void)QueryPerformanceCounter(&count);
    (void)QueryPerformanceFrequency(&rate);
    const int64_t seconds = count.QuadPart / rate.QuadPart;
    const int64_t rest = count.QuadPart % rate.QuadPart;
    return seconds * NS_PER_S + rest * NS_PER_S / rate.QuadPart;
}

int64_t lum_time_utc_ns(void)
{
    FILETIME now;
    GetSystemTimeAsFileTime(&now);
    const int64_t ticks =
        (int64_t)(((uint64_t)now.dwHighDateTime << 32) | now.dwLowDateTime);
    return (ticks - EPOCH) * 100;
}

void lum_time_sleep_until(int64_t monotonic_ns)
{
    const int64_t left = monotonic_ns - lum_time_monotonic_ns();
    if (left > 0) {
        Sleep((DWORD)(left / 1000000));
    }
}
