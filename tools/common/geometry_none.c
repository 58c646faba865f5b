#include "geometry.h"

#include <stddef.h>

int geometry_read(const char *calibration_name, const char *profile_name,
                  lum_calibration *calibration, lum_profile *profile,
                  lum_error *error)
{
    (void)calibration;
    (void)profile;
    if (calibration_name != NULL || profile_name != NULL) {
        return lum_error_set(
            error, "%s: this build reads no YAML files; use a build that does",
            calibration_name != NULL ? calibration_name : profile_name);
    }
    return 0;
}
