/* A line on a terminal that says how far the work has come. */
#ifndef LUMDUMP_PROGRESS_H
#define LUMDUMP_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

/* Begun with whether it is on. */
struct progress {
    bool is_on;
    bool is_shown;
    int64_t next_ns;
};

/* Redraws five times a second, where standard error is a terminal in whose
 * foreground the run is; total 0: unknown. Cheap to call often. */
void progress_update(struct progress *progress, uint64_t done, uint64_t total,
                     uint64_t points);

/* Removes the line. */
void progress_clear(struct progress *progress);

#endif
