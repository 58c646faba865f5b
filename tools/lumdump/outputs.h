/* All outputs of a run, filled by one pass. A failure of one of them is a
 * failure of all. If the reader of an output leaves, only that output ends,
 * with a note; if it was the last one, all fail with EPIPE in errno. */
#ifndef LUMDUMP_OUTPUTS_H
#define LUMDUMP_OUTPUTS_H

#include "output.h"

struct outputs;

/* Notes about outputs that did not fail: a reader has left, older files remain,
 * what --keep found. Each output gives at most one of each kind. */
struct outputs_notes {
    lum_error list[(2u + RETENTION_NOTES) * OUTPUTS_MAX];
    size_t count;
    size_t told;                       /* as many of them were printed */
    struct retention_counts retention; /* of all that have ended */
};

/* Open all outputs of the options.
 * rehearsal: NULL, or outputs that took the lines to come.
 * notes: added to, by this and what follows; kept. NULL: it is a rehearsal, of
 * those that need one. */
int outputs_open(const struct options *options, const struct outputs *rehearsal,
                 struct outputs_notes *notes, struct outputs **out,
                 lum_error *error);

/* As output_finish_by(), for all. */
void outputs_finish_by(struct outputs *outputs, struct closer *closer);

/* Whether the answer is yes for any of them. NULL is allowed: none. */
bool outputs_any(const struct outputs *outputs, output_question *is_so);

/* As output_find_lost(), of all. */
bool outputs_find_lost(struct outputs *outputs, lum_error *out);

/* As output_act(), for all. */
int outputs_act(struct outputs *outputs, const struct action *action,
                lum_error *error);

/* As output_open_part(), for the one that there is. */
int outputs_open_part(const struct outputs *outputs, lum_writer **out,
                      lum_error *error);

/* Finish all, free them. When one has failed, now or before, it is aborted and
 * the others are finished all the same. */
int outputs_close(struct outputs *outputs, lum_error *error);

/* Add the counts of other outputs. */
void outputs_add_retention(struct retention_counts *sum,
                           const struct retention_counts *more);

/* Abort all, free them. NULL is allowed. */
void outputs_abort(struct outputs *outputs);

/* What those that are still there lack. of_frames: points that are in no frame,
 * added to each that takes frames. */
size_t outputs_left_out(const struct outputs *outputs,
                        const struct left_out *of_frames,
                        struct left_out out[OUTPUTS_MAX]);

/* What those that are pictures show. */
size_t outputs_drawn(const struct outputs *outputs,
                     struct drawn out[OUTPUTS_MAX]);

#endif
