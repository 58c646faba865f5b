/* A source that can be read once, such as standard input, handed on through a
 * pipe by a thread: so that reading it ends when it is told to, though nothing
 * comes. */
#ifndef LUMVIEW_PUMP_H
#define LUMVIEW_PUMP_H

#include "lum/base/error.h"

struct pump;

/* source: "-", or a path. 0, or -1 with the reason in error. */
int pump_start(const char *source, struct pump **out, lum_error *error);

/* What to read instead of it, once. */
const char *pump_path(const struct pump *pump);

/* Whoever reads comes to the end. NULL is allowed. */
void pump_stop(struct pump *pump);

/* Nobody reads any more. NULL is allowed. */
void pump_end(struct pump *pump);

#endif
