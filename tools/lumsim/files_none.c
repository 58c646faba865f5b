#include "files.h"

#include "layout.h"
#include "moving.h"
#include "rig.h"

#include <stdio.h>

static bool refuse(const char *option, const char *kind)
{
    (void)fprintf(
        stderr,
        "lumsim: %s: this build has no %s files; use a build that has "
        "them\n",
        option, kind);
    return false;
}

bool files_check(const struct options *o)
{
    if (o->capture.output != NULL) {
        return refuse("--output", "capture");
    }
    if (o->replay.path != NULL) {
        return refuse("--replay", "capture");
    }
    if (o->calibration != NULL) {
        return refuse("--calibration", "YAML");
    }
    return o->profile == NULL || refuse("--profile", "YAML");
}

bool files_load(struct options *o)
{
    lum_error error = {""};
    lum_profile profile;
    lum_profile_default(&profile);
    if (set_keys_calibration(&o->set, true, &o->render.calibration, &error) !=
            0 ||
        set_keys_profile(&o->set, true, &profile, &error) != 0) {
        (void)fprintf(stderr, "lumsim: %s\n", error.text);
        return false;
    }
    return layout_take(o, &profile);
}

bool moving_load(struct options *o)
{
    return o->render.place.path.kind != LUM_PATH_POSES ||
           refuse("--path", "pose");
}

bool rig_check(struct options *o)
{
    return o->rig.path == NULL || refuse("--rig", "capture");
}

bool rig_load(struct options *o)
{
    (void)o;
    return false;
}

bool rig_spread(struct options *o)
{
    (void)o;
    return false;
}

void rig_free(struct options *o)
{
    (void)o;
}

int offline_run(const struct options *o)
{
    return refuse(o->capture.output, "capture") ? 0 : 1;
}

int recording_open(const char *path, const lum_layout *layout,
                   const struct replayed_sensor *sensor, struct recording **out,
                   struct recording_facts *facts, lum_error *error)
{
    (void)layout;
    (void)sensor;
    *out = NULL;
    *facts = (struct recording_facts){0};
    return lum_error_set(error, "%s: this build reads no captures", path);
}

bool recording_remark(const struct recording *recording, size_t i,
                      lum_error *out)
{
    (void)recording;
    (void)i;
    (void)out;
    return false;
}

int recording_next(struct recording *recording, struct recorded *out,
                   lum_error *error)
{
    (void)recording;
    *out = (struct recorded){0};
    return lum_error_set(error, "this build reads no captures");
}

int recording_rewind(struct recording *recording, lum_error *error)
{
    (void)recording;
    return lum_error_set(error, "this build reads no captures");
}

void recording_close(struct recording *recording)
{
    (void)recording;
}
