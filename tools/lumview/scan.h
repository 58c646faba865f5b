/* Reads captures to their end, without points, to find the first and the last
 * frame, where a recording is missing, and what later parts say of themselves,
 * and tells the stage. A thread does it, or who works in steps. */
#ifndef LUMVIEW_SCAN_H
#define LUMVIEW_SCAN_H

#include "captures.h"
#include "decoder.h"

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct scan;

/* captures and said, which is of them: kept; they are files. 0, or -1 with the
 * reason in error. */
int scan_start(const struct captures *captures,
               const struct provenance_source *said,
               const struct decoder_options *decoder, struct scan **out,
               lum_error *error);

/* Ends early when the stage is closing. NULL is allowed. */
void scan_end(struct scan *scan);

/* Read some records, where there are no threads. False: nothing is left to do.
 * NULL is allowed. */
bool scan_step(struct scan *scan);

/* Any thread. False: not known yet. */
bool scan_range(struct scan *scan, int64_t *first, int64_t *last);

/* A reading of captures from their beginning, without points. */
struct sweep;

/* Of the first span_ns of files, or all: INT64_MAX. NULL: they cannot be read,
 * which is told when they are read again. captures: kept. */
struct sweep *sweep_new(const struct captures *captures,
                        const struct decoder_options *options, int64_t span_ns);

/* Read some records. False: there are no more, or none that are wanted. */
bool sweep_step(struct sweep *sweep);

/* End. Returns its decoder, to be freed by decoder_free(). NULL is allowed, and
 * gives NULL. */
struct decoder *sweep_end(struct sweep *sweep);

#endif
