#include "files.h"

#include "lum/io/config.h"

int files_load_layout(const char *path, lum_layout *out, lum_error *error)
{
    lum_profile profile;
    lum_profile_default(&profile);
    if (path != NULL && lum_profile_load(path, &profile, error) != 0) {
        return -1;
    }
    if (lum_layout_init(out, &profile, NULL, NULL) != LUM_OK) {
        return lum_error_set(error, "%s: this layout cannot be", path);
    }
    return 0;
}

int files_load_calibration(const char *path, lum_calibration *out,
                           lum_error *error)
{
    lum_calibration_default(out);
    return path != NULL ? lum_calibration_load(path, out, error) : 0;
}
