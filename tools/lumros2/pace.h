/* When messages are due: their recorded times against this host's clock. */
#ifndef LUMROS2_PACE_H
#define LUMROS2_PACE_H

#include <stdbool.h>
#include <stdint.h>

struct pace {
    double rate; /* 0.001 or more */
    bool has_begun;
    int64_t host_ns; /* of the first message */
    uint64_t log_ns; /* likewise */
    uint64_t last_ns;
};

/* From here on times begin again: the first message is due then. */
void pace_begin(struct pace *pace, double rate, int64_t host_ns);

/* When a message is due, by the host's monotonic clock. Times that go backwards
 * are due at once. */
int64_t pace_due(struct pace *pace, uint64_t log_ns);

#endif
