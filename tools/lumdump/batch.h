/* Some lines of one pass, and their rows in a cloud: what one thread hands to
 * another. Lines are copied, since those of a framer live until its next
 * call. */
#ifndef LUMDUMP_BATCH_H
#define LUMDUMP_BATCH_H

#include "cloud/part.h"
#include "lum/base/error.h"
#include "lum/points.h"
#include "lum/smooth.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How lines become points; only read. */
struct batch_view {
    lum_selection selection;
    unsigned leaves; /* what nobody reads: options_leaves() */
    bool smooths;
    lum_smooth smooth;
};

struct batch;

/* NULL without memory. part: makes the rows; the batch's from now on, also
 * without memory. */
struct batch *batch_new(lum_writer *part);

/* NULL is allowed. */
void batch_free(struct batch *batch);

bool batch_is_empty(const struct batch *batch);

/* Whether it is time to make its rows. */
bool batch_is_full(const struct batch *batch);

/* The frame of its lines; it is not empty. */
int64_t batch_frame(const struct batch *batch);

/* Add a line whose points are not known. projector: makes them; about: its
 * timestamp and its extra columns. Kept: the projector, and what extra points
 * to. 0; -1 without memory. */
int batch_add_line(struct batch *batch, const lum_line *line,
                   const lum_projector *projector,
                   const lum_line_samples *about);

/* Add a line's points. 0; -1 without memory. */
int batch_add_samples(struct batch *batch, const lum_line_samples *line);

/* What batch_make() works with, one for each thread. NULL without memory. */
struct batch_tools;
struct batch_tools *batch_tools_new(void);
void batch_tools_free(struct batch_tools *tools);

/* Make the rows of its lines. A failure waits for batch_rows(). */
void batch_make(struct batch *batch, const struct batch_view *view,
                struct batch_tools *tools);

/* Its rows, after batch_make(); NULL with the reason in error if they could not
 * be made. */
lum_writer *batch_rows(struct batch *batch, lum_error *error);

/* Make it ready for other lines. */
void batch_clear(struct batch *batch);

#endif
