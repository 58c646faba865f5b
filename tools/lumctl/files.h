/* Profile and calibration from files, where the config library is there. */
#ifndef LUMCTL_FILES_H
#define LUMCTL_FILES_H

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/profile.h"

/* path NULL: the default. 0, or -1 with the reason in error. */
int files_load_layout(const char *path, lum_layout *out, lum_error *error);
int files_load_calibration(const char *path, lum_calibration *out,
                           lum_error *error);

#endif
