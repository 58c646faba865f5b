/* The files that a run reads. It must not overwrite them, by any of their
 * names, and only one of them can be standard input. */
#ifndef LUM_TOOLS_INPUT_FILES_H
#define LUM_TOOLS_INPUT_FILES_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>

struct input_file {
    const char *path; /* "-" is standard input; NULL: none */
    const char *what; /* such as "the calibration" */
};

/* Whether two names are of one file, through links and hard links too; "-" is
 * standard input, and standard output. Only for regular files: other files
 * cannot be overwritten. */
bool input_files_is_same(const char *input, const char *output);

/* Look at one output; "-" is standard output. 0, or -1 with which input it
 * would spoil in error. */
int input_files_check(const struct input_file *inputs, size_t count,
                      const char *output, lum_error *error);

/* Whether it is standard input, by this name or another, such as /dev/stdin
 * where that is a pipe. */
bool input_files_is_stdin(const char *path);

/* Standard input is one of them at most. what: such as "--calibration". 0, or
 * -1 with two that it is in error. */
int input_files_check_once(const struct input_file *inputs, size_t count,
                           lum_error *error);

#endif
