#include "progress.h"

#include "../common/terminal.h"
#include "lum/base/time.h"

#include <inttypes.h>
#include <stdio.h>

#define INTERVAL_NS INT64_C(200000000)

void progress_update(struct progress *progress, uint64_t done, uint64_t total,
                     uint64_t points)
{
    if (!progress->is_on) {
        return;
    }
    const int64_t now = lum_time_monotonic_ns();
    if (now < progress->next_ns) {
        return;
    }
    progress->next_ns = now + INTERVAL_NS;
    if (!terminal_is_foreground(stderr)) {
        progress->is_shown = false;
        return;
    }
    progress->is_shown = true;
    if (total > 0) {
        (void)fprintf(stderr, "\r\033[K%3" PRIu64 " %%  ", done * 100 / total);
    } else {
        (void)fputs("\r\033[K", stderr);
    }
    (void)fprintf(stderr, "%" PRIu64 " MB read, %" PRIu64 " points",
                  done / 1000000, points);
}

void progress_clear(struct progress *progress)
{
    if (progress->is_shown && terminal_is_foreground(stderr)) {
        (void)fputs("\r\033[K", stderr);
    }
    progress->is_shown = false;
}
