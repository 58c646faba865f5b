/* Calibration and wire profile, made ready for use. */
#ifndef LUM_TOOLS_GEOMETRY_H
#define LUM_TOOLS_GEOMETRY_H

#include "set_keys.h"
#include "sources.h"

#include "lum/base/error.h"
#include "lum/points.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>

struct geometry {
    lum_calibration calibration;
    lum_profile profile;
    bool has_calibration; /* not the built-in one */
    bool has_profile;     /* likewise */
};

/* Read those of a command line. Files' names; NULL: the built-in one. sources:
 * what the run reads too; NULL: nothing. 0, or -1 with the reason in error: one
 * cannot be read, or standard input is more than one of all. */
int geometry_load(const char *calibration, const char *profile,
                  const struct sources *sources, struct geometry *out,
                  lum_error *error);

/* Set keys on top of that. 0, or -1 with the reason in error. */
int geometry_set(struct geometry *geometry, const struct set_keys *keys,
                 lum_error *error);

/* 0, or -1 with the reason in error. */
int geometry_make(const struct geometry *geometry, lum_layout *layout,
                  lum_projector *projector, lum_error *error);

#endif
