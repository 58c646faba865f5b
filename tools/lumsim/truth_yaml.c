#include "truth.h"

#include "lum/host/keys.h"
#include "standing.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define TEXT_BYTES 4096

/* What the recording was made of stands above the values. */
static size_t make_text(const struct options *o, char out[TEXT_BYTES])
{
    const lum_place_options *place = &o->render.place;
    lum_keys keys;
    int n = snprintf(out, TEXT_BYTES,
                     "# The true calibration of a simulated sensor, written by "
                     "lumsim.\n# Scene: %s, seed %" PRIu64 "\n",
                     standing_scene(o), o->render.seed);
    if (place->path.kind != LUM_PATH_NONE) {
        n += snprintf(out + n, TEXT_BYTES - (size_t)n, "# Path: %.200s\n",
                      o->moving.path);
    } else if (place->has_pose || place->kind != LUM_PLACE_STREET) {
        const lum_stance pose = place->has_pose || place->is_on_vehicle
                                    ? place->pose
                                    : lum_place_usual_pose(place->kind);
        n += snprintf(out + n, TEXT_BYTES - (size_t)n,
                      "# Pose%s: %.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                      place->is_on_vehicle ? " of its vehicle" : "", pose.at[0],
                      pose.at[1], pose.at[2], pose.roll_deg, pose.pitch_deg,
                      pose.yaw_deg);
    }
    lum_keys_of_calibration(&keys, &o->render.calibration);
    (void)lum_keys_write(&keys, out + n, TEXT_BYTES - (size_t)n);
    return strlen(out);
}

int truth_yaml_begin(const struct options *o, lum_outfile *out,
                     lum_error *error)
{
    char text[TEXT_BYTES];
    lum_outfile file;
    const size_t len = make_text(o, text);
    if (lum_outfile_begin(o->truth.calibration, text, len, &file, error) != 0) {
        return -1;
    }
    *out = file;
    return 0;
}
