/* A pass over a capture, or two where an output has to know beforehand how many
 * points will come. */
#ifndef LUMDUMP_REPLAY_H
#define LUMDUMP_REPLAY_H

#include "convert.h"

/* Opens the outputs and reads the capture to its end. What was found out is in
 * pass, whatever the result; the outputs are still open. */
enum pass_result replay(struct pass *pass, lum_error *error);

#endif
