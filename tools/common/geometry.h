/* Calibration and wire profile, made ready for use. */
#ifndef LUM_TOOLS_GEOMETRY_H
#define LUM_TOOLS_GEOMETRY_H

#include "set_keys.h"
#include "sources.h"

#include "lum/base/error.h"
#include "lum/config/rig.h"
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

/* Whether this build reads YAML. */
bool geometry_has_yaml(void);

/* Files of YAML into what holds the defaults. Names may be NULL: that one stays
 * as it is. Where this build has no YAML, names are refused. 0, or -1 with the
 * reason in error. */
int geometry_read(const char *calibration_name, const char *profile_name,
                  lum_calibration *calibration, lum_profile *profile,
                  lum_error *error);

/* A rig from a file of YAML. 0, or -1 with the reason in error, also where this
 * build has no YAML. */
int geometry_read_rig(const char *name, lum_rig_files *out, lum_error *error);

/* Texts of YAML, called by a name in messages, into what holds the defaults. 0,
 * or -1 with the reason in error: it is wrong, or this build has no YAML. */
int geometry_parse_calibration(const char *text, size_t len, const char *name,
                               lum_calibration *calibration, lum_error *error);
int geometry_parse_profile(const char *text, size_t len, const char *name,
                           lum_profile *profile, lum_error *error);

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
