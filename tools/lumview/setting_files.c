#include "setting_files.h"

#include "../common/input_files.h"

#include "base/text.h"
#include "lum/config/config.h"

#include <stdio.h>
#include <string.h>

/* Of all that is read standard input is one at most. */
static int check_stdin(const struct options *o, lum_error *error)
{
    const struct input_file inputs[] = {
        {o->calibration, "--calibration"},
        {o->profile, o->second != NULL ? "the first --profile" : "--profile"},
        {o->second, "the second --profile"},
        {o->rig_path, "--rig"},
        {o->beside.poses_path, "--poses"},
        {o->beside.truth, "--truth"},
        {sources_find_stdin(&o->sources), "the source"}};
    return input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                                  error);
}

static int load_second(const struct options *o, struct files *out,
                       lum_error *error)
{
    struct geometry tried = out->geometry;
    lum_profile_default(&out->second);
    if (lum_profile_load(o->second, &out->second, error) != 0) {
        return -1;
    }
    tried.profile = out->second;
    return geometry_set(&tried, &o->set, error);
}

static int refuse_name(const struct options *o, const lum_rig *rig,
                       lum_error *error)
{
    char names[LUM_RIG_SENSORS_MAX * (LUM_RIG_NAME_BYTES + 2u)] = "";
    for (size_t i = 0; i < rig->count; i++) {
        lum_text_list(names, sizeof names, ", ", rig->sensor[i].name);
    }
    return lum_error_set(error,
                         "--sensor: '%s' is not a sensor of %s, which "
                         "has %s",
                         o->sensor.text, o->rig_path, names);
}

/* The sensor of --sensor becomes the first, and the only one that is shown. */
static int choose_sensor(struct options *o, lum_rig_files *files,
                         lum_error *error)
{
    lum_rig *rig = &files->rig;
    size_t i = 0;
    while (i < rig->count && strcmp(rig->sensor[i].name, o->sensor.text) != 0) {
        i++;
    }
    if (i == rig->count) {
        return refuse_name(o, rig, error);
    }
    const lum_rig_sensor first = rig->sensor[0];
    const lum_rig_sensor_files its = files->sensor[0];
    rig->sensor[0] = rig->sensor[i];
    files->sensor[0] = files->sensor[i];
    rig->sensor[i] = first;
    files->sensor[i] = its;
    o->shown = 1;
    return 0;
}

static int load_rig(struct options *o, lum_rig_files *out, lum_error *error)
{
    if (o->rig_path == NULL) {
        return 0;
    }
    if (lum_rig_load(o->rig_path, out, error) != 0) {
        return -1;
    }
    o->shown = out->rig.count;
    if (o->sensor.is_given && choose_sensor(o, out, error) != 0) {
        return -1;
    }
    o->rig = out;
    return 0;
}

static int load_poses(struct beside_options *o, lum_poses **out,
                      lum_error *error)
{
    if (o->poses_path == NULL) {
        return 0;
    }
    const int failed = lum_poses_read(o->poses_path, NULL, NULL, out, error);
    o->poses = *out;
    return failed;
}

/* What a source says of itself comes under the keys that are set: they are only
 * tried here, which separates a bad configuration from a bad source. */
int files_load(struct options *o, struct files *out, lum_error *error)
{
    const struct input_file inputs[] = {{o->calibration, "the calibration"},
                                        {o->profile, "the profile"},
                                        {o->rig_path, "the rig"},
                                        {o->second, "the second profile"}};
    if (o->json &&
        sources_check(&o->sources, inputs, sizeof inputs / sizeof inputs[0],
                      "-", error) != 0) {
        return -1;
    }
    if (check_stdin(o, error) != 0 || load_rig(o, &out->rig, error) != 0 ||
        load_poses(&o->beside, &out->poses, error) != 0 ||
        geometry_load(o->calibration, o->profile, &o->sources, &out->geometry,
                      error) != 0) {
        return -1;
    }
    struct geometry tried = out->geometry;
    if (geometry_set(&tried, &o->set, error) != 0) {
        return -1;
    }
    return o->second != NULL ? load_second(o, out, error) : 0;
}
