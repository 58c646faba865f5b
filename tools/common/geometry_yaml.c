#include "geometry.h"

#include "lum/config/config.h"

int geometry_read(const char *calibration_name, const char *profile_name,
                  lum_calibration *calibration, lum_profile *profile,
                  lum_error *error)
{
    if (calibration_name != NULL &&
        lum_calibration_load(calibration_name, calibration, error) != 0) {
        return -1;
    }
    return profile_name == NULL
               ? 0
               : lum_profile_load(profile_name, profile, error);
}
