/* In place of the room config, which needs libyaml: files and texts of YAML are
 * refused. */
#include "lum/config/config.h"
#include "lum/config/rig.h"

static int refuse_file(const char *path, lum_error *error)
{
    return lum_error_set(
        error, "%s: this build reads no YAML files; use a build that does",
        path);
}

static int refuse_text(const char *name, lum_error *error)
{
    return lum_error_set(error, "%s cannot be read: this build reads no YAML",
                         name);
}

int lum_calibration_load(const char *path, lum_calibration *out,
                         lum_error *error)
{
    (void)out;
    return refuse_file(path, error);
}

int lum_profile_load(const char *path, lum_profile *out, lum_error *error)
{
    (void)out;
    return refuse_file(path, error);
}

int lum_calibration_parse(const char *text, size_t len, const char *name,
                          lum_calibration *out, lum_error *error)
{
    (void)text;
    (void)len;
    (void)out;
    return refuse_text(name, error);
}

int lum_profile_parse(const char *text, size_t len, const char *name,
                      lum_profile *out, lum_error *error)
{
    (void)text;
    (void)len;
    (void)out;
    return refuse_text(name, error);
}

int lum_rig_load(const char *path, lum_rig_files *out, lum_error *error)
{
    (void)out;
    return refuse_text(path, error);
}
