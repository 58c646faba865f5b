/* A source that can be read only once, for example standard input. A thread
 * passes it on through a pipe, so that reading can be ended even if nothing
 * comes. */
#ifndef LUMVIEW_PUMP_H
#define LUMVIEW_PUMP_H

#include "lum/base/error.h"

struct pump;

/* source: "-", or a path. 0, or -1 with the reason in error. */
int pump_start(const char *source, struct pump **out, lum_error *error);

/* What to read instead of it, once. */
const char *pump_path(const struct pump *pump);

/* The reader gets the end. NULL is allowed. */
void pump_stop(struct pump *pump);

/* Nobody reads any more. NULL is allowed. */
void pump_end(struct pump *pump);

#endif
