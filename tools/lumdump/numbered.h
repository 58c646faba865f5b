/* Names of files that differ only in a number. */
#ifndef LUMDUMP_NUMBERED_H
#define LUMDUMP_NUMBERED_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The text before the number, the separator, and the text after it. */
struct numbered {
    const char *head;
    size_t head_len;
    const char *divider;
    const char *tail;
};

/* How the files of an output are named. path: its name or the last part of it,
 * with %d for the number as options_pattern() wants it, else it is
 * NAME-0001.EXT; kept. */
struct numbered numbered_of(const char *path);

/* Whether base, the last part of a path, is one of them. */
bool numbered_has(const struct numbered *n, const char *base);

/* The name with this number. 0, or -1 with the reason in error: the name or
 * the number is too long. */
int numbered_name(const char *name, int64_t number, char *out, size_t room,
                  lum_error *error);

#endif
