/* What lumtable was asked to do. */
#ifndef LUMTABLE_OPTIONS_H
#define LUMTABLE_OPTIONS_H

#include "../common/option_table.h"
#include "../common/set_keys.h"

#include <stdbool.h>

#define NAME_MAX_LENGTH 40

struct options {
    struct set_keys set;     /* on top of files */
    const char *profile;     /* NULL: the built-in one */
    const char *calibration; /* NULL: typical values */
    const char *name;        /* of the constants; NULL: the usual one */
    const char *output;      /* "-": standard output */
    bool is_layout;          /* code instead of constants */
};

enum option_end options_parse(int argc, char **argv, struct options *out);

#endif
