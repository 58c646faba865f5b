/* Where the points go: one cloud, one cloud a frame, or a capture; each may go
 * on in new files. */
#ifndef LUMDUMP_OUTPUT_H
#define LUMDUMP_OUTPUT_H

#include "closer.h"
#include "frame_lines.h"
#include "options.h"
#include "retention.h"

#include "lum/base/error.h"
#include "lum/capture/capture.h"

struct output;

/* Points that an output was to have and has not. */
struct left_out {
    const char *name;  /* the output's; "-" is standard output */
    uint64_t late;     /* they came after their frame had been written */
    uint64_t cut;      /* beyond the most points or lines of a frame */
    uint64_t no_place; /* in an organised cloud */
};

/* What a picture shows, or those of a rotation. */
struct drawn {
    const char *name;
    uint64_t frames; /* that it shows */
    int64_t first;   /* number of the first of them; unset without one */
    int64_t last;
    uint64_t files;  /* pictures that show any */
    unsigned file;   /* the number of the last one */
    bool is_whole;   /* the one, and nothing is known to be missing in it */
    uint64_t points; /* that it shows */
    uint64_t others; /* frames with points that it does not show */
};

/* What there is to say of an output that has ended: whether files of an
 * earlier, longer run follow those that were written, and what --keep found. */
struct output_end {
    struct retention_counts retention;
    lum_error notes[1u + RETENTION_NOTES];
    size_t note_count;
};

/* The i-th output of the options. A capture of a live run has its final name
 * from the start. rehearses: it takes lines and writes nothing, as the first of
 * two passes, for a header that an output which cannot seek has to begin with.
 * rehearsal: NULL, or an output that did so with the lines to come. 0, or -1
 * with the reason in error and errno; if *out is not NULL, it is to be ended
 * whatever is returned. */
int output_open(const struct options *options, size_t i, bool rehearses,
                const struct output *rehearsal, struct output **out,
                lum_error *error);

/* Have its files finished by another thread. Then the next call reports what
 * fails there, and a file continues past its limit while others wait for a slow
 * disk. Kept until the output is closed. */
void output_finish_by(struct output *output, struct closer *closer);

/* As the option gives it; "-" is standard output. */
const char *output_name(const struct output *output);

/* The name of an output as a person reads it: "-" is standard output. */
const char *output_title(const char *name);

/* A question about an output. */
typedef bool output_question(const struct output *output);

/* Whether it is made of lines as they come, of whole frames. */
output_question output_wants_lines;
output_question output_wants_frames;

/* Whether it needs the points of lines; else their number will do: it rehearses
 * for a header that tells only this. */
output_question output_wants_points;

/* Whether it is a picture of one frame, as none was chosen. */
output_question output_draws_one;

/* What is done to an output. It takes what it has a place for, and ignores the
 * rest. */
struct action {
    enum {
        SET_TIME, /* number: ns since 1970. Data that is added from now
                     on may belong to a new file, which begins with the
                     next frame */
        ADD_LINE,
        ADD_ROWS,  /* of part, which output_open_part() gave; number: of
                      their frame, the same for all if each has a file */
        ADD_FRAME, /* in rising order, before the end of each is told */
        ADD_STATUS,
        ADD_DATAGRAM, /* record; number: not 0 if a new file may begin
                         here, since a frame does */
        END_FRAME,    /* number: no line of this frame or of one before
                         it is to be expected */
        FLUSH         /* show what was added to a reader of standard output or a
                         pipe; number: not 0 to show it also to readers of
                         recordings */
    } kind;
    int64_t number;
    unsigned sensor; /* of a rig: 1 + whose it is; 0: there is none, or it is of
                        all */
    const void *const *extra; /* of a frame: as of its lines */
    const lum_line_samples *line;
    lum_writer *part;
    struct frame_lines *frame;
    const lum_record *record;
    const lum_writer_status *status;
};

/* 0, or -1 with the reason in error and errno; it cannot go on then. */
int output_act(struct output *output, const struct action *action,
               lum_error *error);

/* A part of a file of it. */
int output_open_part(const struct output *output, lum_writer **out,
                     lum_error *error);

/* Whether a file that is being written was removed or renamed by others, or
 * --keep cannot remove one, and was not yet found: out says what became of it.
 */
bool output_find_lost(struct output *output, lum_error *out);

/* Give the files their names, free the output. end: filled in any case. Files
 * that could not be finished are removed, except recordings. */
int output_close(struct output *output, struct output_end *end,
                 lum_error *error);

/* Remove unfinished files, except recordings; free the output. NULL is
 * allowed. */
void output_abort(struct output *output);

/* As far as it knows itself: not what is in none of the frames it got. */
void output_left_out(const struct output *output, struct left_out *out);

/* False: it is no picture. */
bool output_drawn(const struct output *output, struct drawn *out);

#endif
