/* The log of --log: one JSON object a line, each line flushed. */
#ifndef LUMSIM_JOURNAL_H
#define LUMSIM_JOURNAL_H

#include "../common/json.h"
#include "lum/base/error.h"

#include <stdint.h>
#include <stdio.h>

struct journal_file;

struct journal {
    FILE *out; /* NULL: there is none, or it cannot be written */
    struct journal_file *file; /* NULL: standard output */
    struct json json;
    int reason; /* errno of the write that failed; 0: none did */
};

/* path: "-" is standard output; NULL: no log. A file exists from its first line
 * on, and only one run can write it. 0, or -1 with the reason in error. */
int journal_open(struct journal *out, const char *path, lum_error *error);

/* Begin a line with "t" and "event". Returns the object for the rest of the
 * line. */
struct json *journal_begin(struct journal *journal, int64_t t_ns,
                           const char *event);

/* The line's end. */
void journal_end(struct journal *journal);

/* 0, or the errno of what could not be written. */
int journal_close(struct journal *journal);

#endif
