/* A second capture whose points are true, beside those that are shown: as an
 * array of NumPy, so that the page has one kind of them. */
#ifndef LUMVIEW_TRUE_POINTS_H
#define LUMVIEW_TRUE_POINTS_H

#include "../common/geometry.h"
#include "options.h"

#include "lum/base/error.h"

#include <stddef.h>

/* Of a capture: a page keeps all of them. */
#define TRUTH_POINTS_MAX 10000000u

struct truth {
    char *bytes; /* to be freed by free() */
    size_t len;
};

/* Read captures as one: columns frame, x, y, z of their rising returns.
 * options: of what is shown; geometry: what its command line names, which the
 * captures' own completes. 0, or -1 with the reason in error; then there is
 * nothing to free. */
int truth_read(const struct options *options, const struct geometry *geometry,
               const char *const *paths, size_t count, struct truth *out,
               lum_error *error);

#endif
