#include "geometry.h"

#include "lum/config/config.h"

bool geometry_has_yaml(void)
{
    return true;
}

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

int geometry_parse_calibration(const char *text, size_t len, const char *name,
                               lum_calibration *calibration, lum_error *error)
{
    return lum_calibration_parse(text, len, name, calibration, error);
}

int geometry_parse_profile(const char *text, size_t len, const char *name,
                           lum_profile *profile, lum_error *error)
{
    return lum_profile_parse(text, len, name, profile, error);
}

int geometry_read_rig(const char *name, lum_rig_files *out, lum_error *error)
{
    return lum_rig_load(name, out, error);
}
