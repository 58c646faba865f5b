#include "files.h"

#include <stddef.h>

static int refuse(const char *path, lum_error *error)
{
    return lum_error_set(error,
                         "%s: this lumctl was built without libyaml and reads "
                         "no YAML; build it with the config library",
                         path);
}

int files_load_layout(const char *path, lum_layout *out, lum_error *error)
{
    lum_layout_default(out);
    return path != NULL ? refuse(path, error) : 0;
}

int files_load_calibration(const char *path, lum_calibration *out,
                           lum_error *error)
{
    lum_calibration_default(out);
    return path != NULL ? refuse(path, error) : 0;
}
