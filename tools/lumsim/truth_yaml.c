#include "truth_yaml.h"

#include "../common/text_file.h"

#include "base/outfile.h"
#include "lum/host/keys.h"
#include "standing.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_BYTES 4096

struct truth_yaml {
    lum_outfile file;
};

/* What the recording was made of stands above the values. */
static size_t make_text(const struct options *o, char out[TEXT_BYTES])
{
    const lum_place_options *place = &o->render.place;
    lum_keys keys;
    int n = snprintf(out, TEXT_BYTES,
                     "# The true calibration of a simulated sensor, written by "
                     "lumsim.\n# Scene: %s, seed %" PRIu64 "\n",
                     standing_scene(o), o->render.seed);
    if (place->has_pose || place->kind != LUM_PLACE_STREET) {
        const lum_pose pose =
            place->has_pose ? place->pose : lum_place_usual_pose(place->kind);
        n += snprintf(out + n, TEXT_BYTES - (size_t)n,
                      "# Pose: %.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", pose.at[0],
                      pose.at[1], pose.at[2], pose.roll_deg, pose.pitch_deg,
                      pose.yaw_deg);
    }
    lum_keys_of_calibration(&keys, &o->render.calibration);
    (void)lum_keys_write(&keys, out + n, TEXT_BYTES - (size_t)n);
    return strlen(out);
}

int truth_yaml_open(const char *path, const struct options *o,
                    struct truth_yaml **out, lum_error *error)
{
    char text[TEXT_BYTES];
    struct truth_yaml *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    const size_t len = make_text(o, text);
    if (text_file_begin(path, text, len, &t->file, error) != 0) {
        free(t);
        return -1;
    }
    *out = t;
    return 0;
}

int truth_yaml_close(struct truth_yaml *truth, lum_error *error)
{
    const int result = lum_outfile_finish(&truth->file, error);
    truth_yaml_abort(truth);
    return result;
}

void truth_yaml_abort(struct truth_yaml *truth)
{
    if (truth != NULL) {
        lum_outfile_discard(&truth->file);
        free(truth);
    }
}
