/* A thread that reads captures to their end to find the first and the last
 * frame, where a recording is missing, and what later parts say of themselves,
 * and tells the stage. */
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

/* Any thread. False: not known yet. */
bool scan_range(struct scan *scan, int64_t *first, int64_t *last);

/* Read the beginning of files, in this thread. Returns what decoder_learn()
 * takes, to be freed by decoder_free(); NULL: nothing is known. What cannot be
 * read is told when it is read again. */
struct decoder *scan_learn(const struct captures *captures,
                           const struct decoder_options *options);

#endif
