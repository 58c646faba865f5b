/* What the page hands to the engine, file by file, and how texts go between
 * them. Files are found by their names, which the page makes unique. */
#ifndef LUMVIEW_WASM_INPUTS_H
#define LUMVIEW_WASM_INPUTS_H

#include "lum/base/error.h"

#include <stddef.h>

/* A function that the page calls by its own name. */
#define EXPORTED(name) __attribute__((export_name(#name)))

#define INPUTS_CAPTURES_MAX 256u

/* What files are, in the order in which the page counts them. */
enum input {
    INPUT_CALIBRATION,
    INPUT_PROFILE,
    INPUT_SECOND, /* a profile to show beside */
    INPUT_RIG,
    INPUT_POSES,
    INPUTS
};

struct inputs {
    char *captures[INPUTS_CAPTURES_MAX];
    size_t capture_count;
    char *names[INPUTS]; /* NULL: none */
};

/* All that was handed over so far. */
const struct inputs *inputs_look(void);

/* The error that the page reads when a function says that it failed. */
lum_error *inputs_error(void);

/* The text that the page has written, as the argument of what it calls. It
 * lives until the next one is written. */
const char *inputs_text(void);

#endif
