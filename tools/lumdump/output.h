/* Where the points go: one cloud, one cloud a frame, or a capture. */
#ifndef LUMDUMP_OUTPUT_H
#define LUMDUMP_OUTPUT_H

#include "options.h"

#include "lum/io/capture.h"
#include "lum/io/error.h"

struct output;

/* Whether a name asks for one file a frame. 0 no, 1 yes, -1: it has a % that
 * cannot be a frame number. */
int output_name_pattern(const char *name);

/* rehearsal: NULL, or an output that took the lines to come. */
int output_open(const struct options *options, const lum_projector *projector,
                const struct output *rehearsal, struct output **out,
                lum_error *error);

/* An output that takes lines and writes nothing: the first of two passes, for a
 * header that an output which cannot seek has to begin with. */
int output_rehearse(const struct options *options,
                    const lum_projector *projector, struct output **out,
                    lum_error *error);

int output_add_line(struct output *output, const lum_line_samples *line,
                    lum_error *error);

/* Datagrams matter to captures alone. */
int output_add_datagram(struct output *output, const lum_record *record,
                        lum_error *error);

/* No line of this frame or of one before it is to be expected. */
int output_end_frame(struct output *output, int64_t frame, lum_error *error);

/* Give the files their names, free the output. Nothing is left of files that
 * could not be finished. */
int output_close(struct output *output, lum_error *error);

/* Remove what is not finished, free the output. NULL is allowed. */
void output_abort(struct output *output);

/* Points that came after the file of their frame had been finished. */
uint64_t output_left_out(const struct output *output);

#endif
