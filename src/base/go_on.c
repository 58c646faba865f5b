#include "base/go_on.h"

#include "lum/base/time.h"

#include <stddef.h>

/* A function of a script takes some microseconds. */
#define BETWEEN_NS INT64_C(5000000)

bool lum_go_on_ask(lum_go_on *go_on)
{
    if (go_on == NULL || go_on->function == NULL || go_on->has_stopped) {
        return go_on == NULL || !go_on->has_stopped;
    }
    if (lum_time_monotonic_ns() >= go_on->next_ns) {
        go_on->has_stopped = !go_on->function(go_on->context);
        go_on->next_ns = lum_time_monotonic_ns() + BETWEEN_NS;
    }
    return !go_on->has_stopped;
}

int lum_go_on_fail(lum_error *error)
{
    return lum_error_set(error, "stopped by the caller");
}
