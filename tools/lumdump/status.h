/* The line that says how a live run goes. */
#ifndef LUMDUMP_STATUS_H
#define LUMDUMP_STATUS_H

#include <stddef.h>
#include <stdint.h>

/* Totals at a moment. */
struct status_totals {
    int64_t time_ns; /* monotonic */
    uint64_t datagrams;
    uint64_t bytes;
    uint64_t points;
    uint64_t lost_words; /* on the wire, as reassembly saw it */
    uint64_t lost_lines;
    uint64_t kernel_drops;
    uint64_t ring_drops;
    uint64_t refused;     /* by reassembly */
    unsigned buffer_used; /* percent */
};

/* The line: rates between two moments, totals of the later.
 * began_ns: when data began to come. */
void status_format(const struct status_totals *before,
                   const struct status_totals *now, int64_t began_ns,
                   const char *laser, char *out, size_t room);

#endif
