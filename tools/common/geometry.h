/* Calibration and wire profile of a command line, made ready for use. */
#ifndef LUM_TOOLS_GEOMETRY_H
#define LUM_TOOLS_GEOMETRY_H

#include "lum/base/error.h"
#include "lum/points.h"
#include "lum/profile.h"

/* Files of YAML into what holds the defaults. Names may be NULL: that one stays
 * as it is. Where this build has no YAML, names are refused. 0, or -1 with the
 * reason in error. */
int geometry_read(const char *calibration_name, const char *profile_name,
                  lum_calibration *calibration, lum_profile *profile,
                  lum_error *error);

/* Files' names; NULL: the default. 0, or -1 with the reason in error. */
int geometry_load(const char *calibration, const char *profile,
                  lum_layout *layout, lum_projector *projector,
                  lum_error *error);

#endif
