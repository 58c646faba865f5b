/* What needs YAML, in builds without it: refusals. */
#include "config_files.h"
#include "ctl.h"

#include <stddef.h>

static int refuse(const char *path, lum_error *error)
{
    return lum_error_set(error,
                         "%s: this lumctl was built without libyaml and reads "
                         "no YAML; build it with the config library",
                         path);
}

int files_load_layout(const char *path, const struct set_keys *set,
                      lum_layout *out, lum_error *error)
{
    lum_profile profile;
    lum_profile_default(&profile);
    if (path != NULL) {
        return refuse(path, error);
    }
    if (set_keys_profile(set, true, &profile, error) != 0) {
        return -1;
    }
    return lum_layout_init(out, &profile, NULL, NULL) == LUM_OK
               ? 0
               : lum_error_set(error, "this layout cannot be");
}

int files_load_calibration(const char *path, const struct set_keys *set,
                           lum_calibration *out, lum_error *error)
{
    lum_calibration_default(out);
    return path != NULL ? refuse(path, error)
                        : set_keys_calibration(set, true, out, error);
}

enum exit_status command_apply(struct ctl *ctl, int count, char **words)
{
    (void)ctl;
    return ctl_complain(EXIT_BAD,
                        "apply: this lumctl was built without libyaml and does "
                        "not read '%.40s'; give the settings one by one, or "
                        "build it with the config library",
                        count > 1 ? words[1] : "files");
}
