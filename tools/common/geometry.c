#include "geometry.h"

#include "lum/config/config.h"

int geometry_load(const char *calibration, const char *profile,
                  const struct sources *sources, struct geometry *out,
                  lum_error *error)
{
    const struct input_file inputs[] = {
        {calibration, "--calibration"},
        {profile, "--profile"},
        {sources != NULL ? sources_find_stdin(sources) : NULL, "the source"}};
    if (input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                               error) != 0) {
        return -1;
    }
    *out = (struct geometry){.has_calibration = calibration != NULL,
                             .has_profile = profile != NULL};
    lum_calibration_default(&out->calibration);
    lum_profile_default(&out->profile);
    if (calibration != NULL &&
        lum_calibration_load(calibration, &out->calibration, error) != 0) {
        return -1;
    }
    return profile != NULL ? lum_profile_load(profile, &out->profile, error)
                           : 0;
}

int geometry_set(struct geometry *geometry, const struct set_keys *keys,
                 lum_error *error)
{
    struct geometry *g = geometry;
    if (set_keys_calibration(keys, !g->has_calibration, &g->calibration,
                             error) != 0 ||
        set_keys_profile(keys, !g->has_profile, &g->profile, error) != 0) {
        return -1;
    }
    g->has_calibration =
        g->has_calibration || set_keys_first(keys, false) != NULL;
    g->has_profile = g->has_profile || set_keys_first(keys, true) != NULL;
    return 0;
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
