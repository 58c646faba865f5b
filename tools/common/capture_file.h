/* The capture being written: a regular file stands under its name only when it
 * is whole. */
#ifndef LUM_TOOLS_CAPTURE_FILE_H
#define LUM_TOOLS_CAPTURE_FILE_H

#include "lum/io/capture.h"
#include "lum/io/error.h"

#include <stdbool.h>

struct capture_file {
    lum_capture_writer *writer;
    char *path; /* NULL: written in place */
    char *part; /* NULL: written in place */
};

/* Whether a path is written as it is: standard output, a pipe, a device. */
bool capture_file_is_in_place(const char *path);

/* 0, or -1 with the reason in error. A link is followed. */
int capture_file_open(const char *path, struct capture_file *out,
                      lum_error *error);

/* 0, or -1 with the reason in error and errno. */
int capture_file_add(struct capture_file *file, const lum_datagram *datagram,
                     lum_error *error);

/* Give the file its name. 0, or -1 with the reason in error and errno; then
 * nothing is left behind. */
int capture_file_close(struct capture_file *file, lum_error *error);

/* Remove what was written. */
void capture_file_abort(struct capture_file *file);

/* As capture_file_abort(), for a process about to die: does not wait for
 * whoever reads. */
void capture_file_abandon(struct capture_file *file);

#endif
