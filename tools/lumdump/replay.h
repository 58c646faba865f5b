/* A pass over a capture, or two if an output has to know the number of points
 * in advance. */
#ifndef LUMDUMP_REPLAY_H
#define LUMDUMP_REPLAY_H

#include "convert.h"

/* Opens the options' source. */
enum pass_result replay_open(const struct options *options, lum_capture **out,
                             lum_error *error);

/* Records that were read of all its captures. */
uint64_t replay_records(const lum_capture *capture);

/* Opens the outputs and reads the capture to its end. The results are in pass,
 * also on failure; the outputs are still open. pass->source.about is
 * set. */
enum pass_result replay(struct pass *pass, lum_error *error);

#endif
