/* Several threads for one output of a capture. The caller reads and assembles;
 * the others, and the caller when they are behind, make rows of lines. Who has
 * made the oldest rows writes them, and what is made behind them, so the file
 * is byte for byte what one thread writes.
 *
 * A crew has a fixed number of batches of lines, so its memory does not grow.
 * Its threads print nothing and get no signals. While there is a crew, the
 * outputs are its own. */
#ifndef LUMDUMP_CREW_H
#define LUMDUMP_CREW_H

#include "batch.h"
#include "options.h"
#include "outputs.h"

#include "lum/frame/framer.h"

/* Most threads. */
#define CREW_MAX 64

struct crew;

/* A crew as the options want it.
 * *out: NULL if one thread does everything.
 * 0, or -1 with the reason in error. */
int crew_new(const struct options *options, struct outputs *outputs,
             struct crew **out, lum_error *error);

/* Stop the threads; what is not written is dropped. NULL is allowed. */
void crew_free(struct crew *crew);

/* Take the framer's line, as the selection needs it: with its points, or
 * without. projector: of its sensor, kept; points: all but these. What fails
 * may be due to an earlier line. 0, or -1 with the reason in error and in
 * errno. */
int crew_add(struct crew *crew, lum_framer *framer,
             const lum_projector *projector, lum_line_samples *points,
             lum_error *error);

/* As END_FRAME of outputs_act(), behind the lines so far. */
int crew_end_frame(struct crew *crew, int64_t frame, lum_error *error);

/* Have all lines so far written to the outputs. */
int crew_finish(struct crew *crew, lum_error *error);

#endif
