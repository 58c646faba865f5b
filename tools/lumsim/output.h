/* The capture being written: a regular file stands under its name only when it
 * is whole. */
#ifndef LUMSIM_OUTPUT_H
#define LUMSIM_OUTPUT_H

#include "lum/io/capture.h"
#include "lum/io/error.h"

#include <stdbool.h>

struct output {
    lum_capture_writer *writer;
    const char *path;
    char *part; /* NULL: written in place */
};

/* Whether a path is written as it is: standard output, a pipe, a device. */
bool output_is_in_place(const char *path);

/* 0, or -1 with the reason in error. path is kept. */
int output_open(const char *path, struct output *out, lum_error *error);

/* 0, or -1 with the reason in error and errno. */
int output_add(struct output *output, const lum_datagram *datagram,
               lum_error *error);

/* Give the file its name. 0, or -1 with the reason in error and errno; then
 * nothing is left behind. */
int output_close(struct output *output, lum_error *error);

/* Remove what was written. */
void output_abort(struct output *output);

/* As output_abort(), for a process about to die: does not wait for whoever
 * reads. */
void output_abandon(struct output *output);

#endif
