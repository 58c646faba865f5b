/* A line on a terminal that says how far the work has come. */
#ifndef LUMDUMP_PROGRESS_H
#define LUMDUMP_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

struct progress {
    bool is_on;
    bool is_shown;
    int64_t next_ns;
};

/* On where the run is not quiet and standard error is a terminal in whose
 * foreground it is. */
void progress_init(struct progress *progress, bool quiet);

/* Redraws five times a second; total 0: unknown. Cheap to call often. */
void progress_update(struct progress *progress, uint64_t done, uint64_t total,
                     uint64_t points);

/* Removes the line. */
void progress_clear(struct progress *progress);

#endif
