/* Several threads for one output of a capture. The caller reads and assembles;
 * the others, and the caller when they are behind, make rows of lines. Who has
 * made the oldest rows writes them, and what is made behind them, so the file
 * is byte for byte what one thread writes.
 *
 * They have a fixed number of batches of lines, so memory does not grow. They
 * print nothing and get no signals. While they are there, the outputs are their
 * own. */
#ifndef LUMDUMP_ROW_THREADS_H
#define LUMDUMP_ROW_THREADS_H

#include "options.h"
#include "outputs.h"

#include "lum/frame/framer.h"

/* Most threads. */
#define ROW_THREADS_MAX 64

struct row_threads;

/* Threads as the options want them.
 * *out: NULL if one thread does everything.
 * 0, or -1 with the reason in error. */
int row_threads_new(const struct options *options, struct outputs *outputs,
                    struct row_threads **out, lum_error *error);

/* Stop the threads; what is not written is dropped. NULL is allowed. */
void row_threads_free(struct row_threads *rows);

/* Take the framer's line, as the selection needs it: with its points, or
 * without. projector: of its sensor, kept; points: all but these. What fails
 * may be due to an earlier line. 0, or -1 with the reason in error and in
 * errno. */
int row_threads_add(struct row_threads *rows, lum_framer *framer,
                    const lum_projector *projector, lum_line_samples *points,
                    lum_error *error);

/* As END_FRAME of outputs_act(), behind the lines so far. */
int row_threads_end_frame(struct row_threads *rows, int64_t frame,
                          lum_error *error);

/* Have all lines so far written to the outputs. */
int row_threads_finish(struct row_threads *rows, lum_error *error);

#endif
