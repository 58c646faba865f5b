/* Reads captures once, without points, while they are played: how their
 * sensors' clocks run, from the beginning; then the first and the last frame,
 * where each is, where a recording is missing, and what later parts say of
 * themselves. It tells the stage. A thread does it, or who works in steps. */
#ifndef LUMVIEW_CAPTURE_SCAN_H
#define LUMVIEW_CAPTURE_SCAN_H

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

/* What follows is for another thread, or the one that takes the steps. */

/* Wait a little for what the beginning tells, or read a little of it. True: out
 * has what decoder_learn() takes, the scan's; NULL: nothing is known. */
bool scan_learn(struct scan *scan, const struct decoder **out);

/* False: not known yet. */
bool scan_range(struct scan *scan, int64_t *first, int64_t *last);

/* Whether scan_go() leads to a frame, and by reading from which one on. */
bool scan_leads(struct scan *scan, int64_t frame, int64_t *begin);

/* Go to where a reading gives a frame and all behind it, with a capture and a
 * decoder that were just opened, with the options of those that are scanned.
 * False: they are at their start, as before. */
bool scan_go(struct scan *scan, lum_capture *capture, struct decoder *decoder,
             int64_t frame);

/* Where frames are is of no use: nothing leads anywhere from here on. */
void scan_drop_places(struct scan *scan);

#endif
