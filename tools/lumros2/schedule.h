/* When messages are due: their recorded times against this host's clock. */
#ifndef LUMROS2_SCHEDULE_H
#define LUMROS2_SCHEDULE_H

#include <stdbool.h>
#include <stdint.h>

struct schedule {
    double rate; /* 0.001 or more */
    bool has_begun;
    int64_t host_ns; /* of the first message */
    uint64_t log_ns; /* likewise */
    uint64_t last_ns;
};

/* From here on times begin again: the first message is due then. */
void schedule_begin(struct schedule *schedule, double rate, int64_t host_ns);

/* When a message is due, by the host's monotonic clock. Times that go backwards
 * are due at once. */
int64_t schedule_due(struct schedule *schedule, uint64_t log_ns);

#endif
