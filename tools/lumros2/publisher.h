/* The messages of a source to topics, at their times. */
#ifndef LUMROS2_PUBLISHER_H
#define LUMROS2_PUBLISHER_H

#include "bus.h"
#include "options.h"

/* Plays the source to its end, or again and again, until a signal comes. *bus,
 * the caller's to close, is joined when the source has shown what it is; NULL
 * before.
 * Returns 0; -1 with the reason in error. */
int publisher_run(const struct options *options, struct bus **bus,
                  lum_error *error);

#endif
