/* Checks of outputs by their names, before they are opened. */
#ifndef LUMDUMP_TARGETS_H
#define LUMDUMP_TARGETS_H

#include "options.h"

#include "lum/base/error.h"

#include <stdbool.h>

/* Whether a name may be written to: -1 with which file that is read would be
 * harmed in error, else 0. */
int targets_check_inputs(const struct options *options, const char *name,
                         lum_error *error);

/* Whether the i-th output's header has to be known before it can begin. */
bool targets_needs_rehearsal(const struct options *options, size_t i);

/* 0, or -1 with the reason why the outputs are refused in error. */
int targets_check(const struct options *options, lum_error *error);

#endif
