/* Standard error of a live run: warnings with their time, and a status line on
 * a terminal. Its reader may stop reading without delaying the run, because
 * nothing is written that would have to wait. */
#ifndef LUMDUMP_SAY_H
#define LUMDUMP_SAY_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SAY_PENDING_BYTES 8192u

struct say {
    bool is_quiet;
    bool shows_status;
    bool left_out; /* a warning did not fit */
    size_t pending_bytes;
    char pending[SAY_PENDING_BYTES]; /* what could not be written yet */
};

/* How many of something were told; all zero: none so far. */
struct say_count {
    uint64_t told;
    int64_t told_ns;
};

void say_init(struct say *say, bool quiet);

/* Whether a count that grows is to be told now: there are more, and they were
 * not told for a while. Then it is noted as told. */
bool say_is_due(struct say_count *count, uint64_t now, int64_t now_ns);

/* Warn, unless the run is quiet; the text ends without a newline. */
LUM_PRINTF(2, 3)
void say_warn(struct say *say, const char *format, ...);

/* Say what a run that is quiet says too. */
LUM_PRINTF(2, 3)
void say_error(struct say *say, const char *format, ...);

/* Whether there is to be a status line now. */
bool say_has_status(const struct say *say);

/* Show a status line, in place of the one before. */
void say_status(struct say *say, const char *text);

/* Write what could not be written before; to be called now and then. */
void say_flush(struct say *say);

/* Remove the status line and write the rest, waiting if necessary. */
void say_end(struct say *say);

#endif
