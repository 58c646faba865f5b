/* A thread that reads a capture to its end to find its first and last frame,
 * and passes them to the stage. */
#ifndef LUMVIEW_SCAN_H
#define LUMVIEW_SCAN_H

#include "decoder.h"

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct scan;

/* source: a file. 0, or -1 with the reason in error. */
int scan_start(const char *source, const struct decoder_options *decoder,
               struct scan **out, lum_error *error);

/* Ends early when the stage is closing. NULL is allowed. */
void scan_end(struct scan *scan);

/* Any thread. False: not known yet. */
bool scan_range(struct scan *scan, int64_t *first, int64_t *last);

#endif
