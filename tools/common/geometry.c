#include "geometry.h"

int geometry_load(const char *calibration, const char *profile,
                  lum_layout *layout, lum_projector *projector,
                  lum_error *error)
{
    lum_calibration c;
    lum_profile p;
    lum_calibration_default(&c);
    lum_profile_default(&p);
    if (geometry_read(calibration, profile, &c, &p, error) != 0) {
        return -1;
    }
    if (lum_layout_init(layout, &p, NULL, NULL) != LUM_OK ||
        lum_projector_init(projector, &c, layout) != LUM_OK) {
        return lum_error_set(error, "the calibration or the profile is out of "
                                    "range; see docs/formats.md");
    }
    return 0;
}
