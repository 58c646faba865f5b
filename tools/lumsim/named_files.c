#define _POSIX_C_SOURCE 200809L
#include "named_files.h"

#include "../common/geometry.h"
#include "../common/input_files.h"
#include "../common/provenance.h"
#include "rig_capture.h"
#include "sim/packets.h"

#include <string.h>
#include <unistd.h>

/* --- No file is two things --- */

/* What the rig names, also for other sensors than the one of these options; an
 * empty path is that of no file. */
static size_t add_rig(const struct options *o,
                      struct input_file out[2 * LUM_RIG_SENSORS_MAX])
{
    size_t count = 0;
    for (size_t i = 0; i < o->rig.count; i++) {
        const lum_rig_sensor_files *of = &o->rig.files->of.sensor[i];
        out[count++] =
            (struct input_file){of->calibration_path, "the calibration"};
        out[count++] = (struct input_file){of->profile_path, "the profile"};
    }
    return count;
}

#define ALONE 5

static bool check_inputs(const struct options *o, const char *option,
                         const char *output)
{
    struct input_file inputs[ALONE + 2 * LUM_RIG_SENSORS_MAX] = {
        {o->calibration, "the calibration"},
        {o->profile, "the profile"},
        {o->rig.path, "the rig"},
        {o->replay.path, "the capture to be replayed"},
        {o->render.place.path.kind == LUM_PATH_POSES ? o->moving.path : NULL,
         "the path"}};
    const size_t count = ALONE + add_rig(o, inputs + ALONE);
    lum_error error = {""};
    return output == NULL ||
           input_files_check(inputs, count, output, &error) == 0 ||
           complain("%s: %s", option, error.text);
}

static bool is_same(const char *a, const char *b)
{
    return strcmp(a, b) == 0 || input_files_is_same(a, b);
}

/* No file gets two things. The true calibration's name differs from that of the
 * exact points, but one can be a link. */
static bool check_truth(const struct options *o, const char *path)
{
    const bool is_output = path != NULL && is_same(o->capture.output, path);
    const bool is_points = path != NULL && path == o->truth.calibration &&
                           o->truth.points != NULL &&
                           is_same(o->truth.points, path);
    return (!is_output && !is_points) ||
           complain("--truth: '%s' is the %s too; give them different names",
                    path, is_output ? "capture's output" : "other --truth");
}

/* Nor do the poses or the labels of something else. */
static bool check_beside(const struct options *o)
{
    const struct {
        const char *option;
        const char *path;
    } outputs[] = {{"--output", o->capture.output},
                   {"--truth", o->truth.points},
                   {"--truth", o->truth.calibration},
                   {"--poses", o->moving.poses},
                   {"--labels", o->moving.labels}};
    for (size_t i = 3; i < sizeof outputs / sizeof outputs[0]; i++) {
        for (size_t k = 0; k < i && outputs[i].path != NULL; k++) {
            if (outputs[k].path != NULL &&
                is_same(outputs[k].path, outputs[i].path)) {
                return complain("%s: '%s' is the file of %s too; give them "
                                "different names",
                                outputs[i].option, outputs[i].path,
                                outputs[k].option);
            }
        }
    }
    return check_inputs(o, "--poses", o->moving.poses) &&
           check_inputs(o, "--labels", o->moving.labels);
}

bool files_check(const struct options *o)
{
    if (!check_inputs(o, "--output", o->capture.output) ||
        !check_inputs(o, "--truth", o->truth.points) ||
        !check_inputs(o, "--truth", o->truth.calibration) ||
        !check_inputs(o, "--log", o->live.log) ||
        !check_truth(o, o->truth.points) ||
        !check_truth(o, o->truth.calibration) || !check_beside(o)) {
        return false;
    }
    return o->capture.output == NULL || strcmp(o->capture.output, "-") != 0 ||
           !isatty(STDOUT_FILENO) ||
           complain("-o -: a capture is binary and standard output is a "
                    "terminal; redirect it, or give a file's name");
}

/* --- Calibration and profile --- */

const char *layout_source(const struct options *o)
{
    if (set_keys_first(&o->set, true) != NULL) {
        return "--set";
    }
    return o->profile != NULL ? o->profile : o->replay.path;
}

/* The first field that is too narrow, by the bits that its numbers need. */
static bool refuse_field(const struct options *o, unsigned field)
{
    static const char *const names[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = "tag",
        [LUM_FIELD_EYE] = "eye",
        [LUM_FIELD_LINE] = "line",
        [LUM_FIELD_NUM_SAMPLES] = "num_samples",
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = "first_sample_index",
        [LUM_FIELD_TIMESTAMP] = "timestamp"};
    const lum_field *f = &o->render.layout.profile.group[field];
    return complain(
        "%s: group.%s is too narrow for what it has to hold: it "
        "has %u bit%s and needs %u",
        layout_source(o), names[field], f->bits > 0 ? f->bits : 8u * f->bytes,
        f->bits == 1 ? "" : "s", lum_packets_bits(field, o->render.lines));
}

bool layout_take(struct options *o, const lum_profile *profile)
{
    lum_render_options *r = &o->render;
    if (lum_layout_init(&r->layout, profile, NULL, NULL) != LUM_OK) {
        return complain("%s: this layout cannot be", layout_source(o));
    }
    const unsigned narrow = lum_packets_narrow(&r->layout, r->lines);
    return narrow == LUM_GROUP_FIELDS || refuse_field(o, narrow);
}

bool files_load(struct options *o)
{
    static struct provenance_source said;
    const struct sources replayed = {.paths = &o->replay.path, .count = 1};
    const struct sources *sources = o->mode == MODE_REPLAY ? &replayed : NULL;
    struct geometry geometry;
    lum_error error = {""};
    const int result =
        geometry_load(o->calibration, o->profile, sources, &geometry, &error);
    if (result == 0 && sources != NULL) {
        provenance_ask("lumsim", sources, o->quiet, &geometry, &said);
    }
    if (result != 0 || geometry_set(&geometry, &o->set, &error) != 0) {
        return complain("%s", error.text);
    }
    o->render.calibration = geometry.calibration;
    return layout_take(o, &geometry.profile);
}
