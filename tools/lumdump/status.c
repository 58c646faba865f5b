#include "status.h"

#include <inttypes.h>
#include <stdio.h>

static double rate(uint64_t before, uint64_t now, double seconds)
{
    return seconds > 0.0 ? (double)(now - before) / seconds : 0.0;
}

void status_format(const struct status_totals *before,
                   const struct status_totals *now, int64_t began_ns,
                   const char *laser, char *out, size_t room)
{
    const double seconds = (double)(now->time_ns - before->time_ns) * 1e-9;
    const double elapsed = (double)(now->time_ns - began_ns) * 1e-9;
    (void)snprintf(
        out, room,
        "%.1f s  %s  %.0f packets/s %.1f Mbit/s %.2f Mpoints/s  buffer %u %%  "
        "lost: wire %" PRIu64 " words %" PRIu64 " lines, kernel %" PRIu64
        ", ring %" PRIu64 ", reassembly %" PRIu64,
        elapsed, laser, rate(before->datagrams, now->datagrams, seconds),
        rate(before->bytes, now->bytes, seconds) * 8e-6,
        rate(before->points, now->points, seconds) * 1e-6, now->buffer_used,
        now->lost_words, now->lost_lines, now->kernel_drops, now->ring_drops,
        now->refused);
}
