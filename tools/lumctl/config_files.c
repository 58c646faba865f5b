#include "config_files.h"

#include "../common/input_files.h"
#include "lum/config/config.h"

/* What is printed may go to a file. */
static int check_input(const char *path, const char *what, lum_error *error)
{
    return input_files_check(&(struct input_file){path, what}, 1, "-", error);
}

int files_load_layout(const char *path, const struct set_keys *set,
                      lum_layout *out, lum_error *error)
{
    lum_profile profile;
    lum_profile_default(&profile);
    if (path != NULL && (check_input(path, "the profile", error) != 0 ||
                         lum_profile_load(path, &profile, error) != 0)) {
        return -1;
    }
    if (set_keys_profile(set, path == NULL, &profile, error) != 0) {
        return -1;
    }
    if (lum_layout_init(out, &profile, NULL, NULL) != LUM_OK) {
        return lum_error_set(error, "%s: this layout cannot be",
                             path != NULL ? path : "--set");
    }
    return 0;
}

int files_load_calibration(const char *path, const struct set_keys *set,
                           lum_calibration *out, lum_error *error)
{
    lum_calibration_default(out);
    if (path != NULL && (check_input(path, "the calibration", error) != 0 ||
                         lum_calibration_load(path, out, error) != 0)) {
        return -1;
    }
    return set_keys_calibration(set, path == NULL, out, error);
}
