/* Profile and calibration from files, where the config library is there. */
#ifndef LUMCTL_CONFIG_FILES_H
#define LUMCTL_CONFIG_FILES_H

#include "../common/set_keys.h"
#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/profile.h"

/* path NULL: the default. set: on top of it. 0, or -1 with the reason in error.
 */
int files_load_layout(const char *path, const struct set_keys *set,
                      lum_layout *out, lum_error *error);
int files_load_calibration(const char *path, const struct set_keys *set,
                           lum_calibration *out, lum_error *error);

#endif
