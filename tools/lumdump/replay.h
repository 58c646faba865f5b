/* A pass over a capture, or two where an output has to know beforehand how many
 * points will come. */
#ifndef LUMDUMP_REPLAY_H
#define LUMDUMP_REPLAY_H

#include "convert.h"

/* Opens the options' source. */
enum pass_result replay_open(const struct options *options, lum_capture **out,
                             lum_error *error);

/* Opens the outputs and reads the capture to its end. What was found out is in
 * pass, whatever the result; the outputs are still open. pass->about is set. */
enum pass_result replay(struct pass *pass, lum_error *error);

#endif
