/* A layout and a projector as C. */
#ifndef LUMTABLE_SOURCE_H
#define LUMTABLE_SOURCE_H

#include "../common/set_keys.h"
#include "lum/points_fixed.h"
#include "lum/profile.h"

#include <stddef.h>

#define SOURCE_BYTES 16384u

/* Text that is written; cut where there is no room, and is_cut says so. */
struct source {
    char text[SOURCE_BYTES];
    size_t len;
    int is_cut;
};

/* Where the values come from, for the comment; NULL: built in. */
struct origin {
    const char *name; /* of the constants */
    const char *profile;
    const char *calibration;
    const struct set_keys *set; /* on top of these */
};

void source_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout,
                  const lum_fixed_projector *projector);

#endif
