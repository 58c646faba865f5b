#include "geometry.h"

int geometry_load(const char *calibration, const char *profile,
                  struct geometry *out, lum_error *error)
{
    *out = (struct geometry){.has_calibration = calibration != NULL,
                             .has_profile = profile != NULL};
    lum_calibration_default(&out->calibration);
    lum_profile_default(&out->profile);
    return geometry_read(calibration, profile, &out->calibration, &out->profile,
                         error);
}

int geometry_make(const struct geometry *geometry, lum_layout *layout,
                  lum_projector *projector, lum_error *error)
{
    if (lum_layout_init(layout, &geometry->profile, NULL, NULL) != LUM_OK ||
        lum_projector_init(projector, &geometry->calibration, layout) !=
            LUM_OK) {
        return lum_error_set(error, "the calibration or the profile is out of "
                                    "range; see docs/formats.md");
    }
    return 0;
}
