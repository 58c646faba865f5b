#include "status.h"

#include <inttypes.h>
#include <stdio.h>

static double rate(uint64_t before, uint64_t now, double seconds)
{
    return seconds > 0.0 ? (double)(now - before) / seconds : 0.0;
}

/* At most four characters, so that the line stays short. */
static const char *brief(uint64_t n, char out[24])
{
    static const char units[] = "kMGTPE";
    if (n < 10000) {
        (void)snprintf(out, 24, "%" PRIu64, n);
        return out;
    }
    size_t unit = 0;
    for (n /= 1000; n >= 1000; n /= 1000) {
        unit++;
    }
    (void)snprintf(out, 24, "%" PRIu64 "%c", n, units[unit]);
    return out;
}

/* The most important comes first: a narrow terminal cuts the rest. */
void status_format(const struct status_totals *before,
                   const struct status_totals *now, int64_t began_ns,
                   const char *laser, char *out, size_t room)
{
    const double seconds = (double)(now->time_ns - before->time_ns) * 1e-9;
    const double elapsed = (double)(now->time_ns - began_ns) * 1e-9;
    char n[5][24];
    (void)snprintf(
        out, room,
        "%.2f Mpt/s  lost: wire %sw %sl, kernel %s, ring %s, bad %s  laser %s  "
        "buf %u%%  %.1f s  %.0f packets/s %.1f Mbit/s",
        rate(before->points, now->points, seconds) * 1e-6,
        brief(now->lost_words, n[0]), brief(now->lost_lines, n[1]),
        brief(now->kernel_drops, n[2]), brief(now->ring_drops, n[3]),
        brief(now->refused, n[4]), laser, now->buffer_used, elapsed,
        rate(before->datagrams, now->datagrams, seconds),
        rate(before->bytes, now->bytes, seconds) * 8e-6);
}
