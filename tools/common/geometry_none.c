#include "geometry.h"

#include <stddef.h>

bool geometry_has_yaml(void)
{
    return false;
}

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

static int refuse(const char *name, lum_error *error)
{
    return lum_error_set(error, "%s cannot be read: this build reads no YAML",
                         name);
}

int geometry_read_rig(const char *name, lum_rig_files *out, lum_error *error)
{
    (void)out;
    return refuse(name, error);
}

int geometry_parse_calibration(const char *text, size_t len, const char *name,
                               lum_calibration *calibration, lum_error *error)
{
    (void)text;
    (void)len;
    (void)calibration;
    return refuse(name, error);
}

int geometry_parse_profile(const char *text, size_t len, const char *name,
                           lum_profile *profile, lum_error *error)
{
    (void)text;
    (void)len;
    (void)profile;
    return refuse(name, error);
}
