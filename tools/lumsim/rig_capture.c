#include "rig_capture.h"

#include "../common/capture_file.h"
#include "../common/geometry.h"
#include "../common/rig_sensors.h"
#include "named_files.h"
#include "sim/random.h"

#include <stdlib.h>
#include <string.h>

/* Sensors boot at different times, and their clocks are those of usual quartz.
 */
#define BOOT_MAX_US  60000000u
#define SLOW_MAX_PPM 20.0f

/* Where in a frame of the first sensor the frames of others begin. */
#define PHASE_MIN 0.05f
#define PHASE_MAX 0.95f

#define RIG_STREAM 8u

/* --- What goes together --- */

/* Each sensor gets a file of its own. */
static bool check_name(const char *option, const char *path)
{
    const char *at = path != NULL ? strstr(path, "%s") : NULL;
    if (path == NULL || (at != NULL && strstr(at + 2, "%s") == NULL)) {
        return true;
    }
    return complain("--%s: '%s': with --rig each sensor has a file of its own, "
                    "so the name has %%s once, where the sensor's name goes",
                    option, path);
}

static bool check_choice(const struct options *o)
{
    if (o->mode != MODE_FILE) {
        return complain(
            "--rig works only with -o FILE; on the network, run one "
            "lumsim for each sensor");
    }
    if (o->delivery.joined) {
        return complain(
            "--joined does not go with --rig: a host joins the "
            "packets of one sensor, and those of several alternate");
    }
    if (o->moving.poses != NULL && !o->truth.is_utc) {
        return complain("--rig: the clocks of its sensors differ, and --poses "
                        "are the vehicle's; add --time utc");
    }
    return true;
}

bool rig_check(struct options *o)
{
    lum_place_options *place = &o->render.place;
    if (o->rig.path == NULL) {
        return true;
    }
    if (place->kind == LUM_PLACE_STREET && !place->has_pose &&
        o->moving.path == NULL) {
        o->moving.path = "straight";
        place->path.kind = LUM_PATH_STRAIGHT;
    }
    return check_choice(o) && check_name("truth", o->truth.points) &&
           check_name("truth", o->truth.calibration) &&
           check_name("labels", o->moving.labels);
}

/* --- Reading --- */

static bool check_interfaces(const struct options *o)
{
    const lum_rig *rig = &o->rig.files->of.rig;
    for (size_t i = 0; i < rig->count; i++) {
        if (rig->sensor[i].interface[0] != '\0' &&
            !capture_file_is_pcapng(o->capture.output)) {
            return complain("--rig: the sensor '%s' has an interface, and a "
                            "pcap file has no names of interfaces; use an "
                            "--output whose name ends in .pcapng",
                            rig->sensor[i].name);
        }
    }
    return true;
}

bool rig_load(struct options *o)
{
    lum_error error = {""};
    o->rig.files = calloc(1, sizeof *o->rig.files);
    if (o->rig.files == NULL) {
        return complain("--rig: not enough memory");
    }
    if (lum_rig_load(o->rig.path, &o->rig.files->of, &error) != 0) {
        return complain("--rig: %s", error.text);
    }
    o->rig.count = o->rig.files->of.rig.count;
    return check_interfaces(o);
}

/* --- The options of each --- */

double rig_late_s(const struct options *o, int64_t frames)
{
    const double frame_s = 1.0 / o->render.rate_hz;
    return o->rig.count > 1
               ? (double)PHASE_MAX * frame_s +
                     (double)frames * frame_s * (double)SLOW_MAX_PPM * 1e-6
               : 0.0;
}

/* The first is as one alone. */
static lum_render_start start_of(const struct options *o, uint32_t i)
{
    lum_random random;
    lum_render_start start = o->render.start;
    if (i == 0) {
        return start;
    }
    lum_random_init(&random, o->render.seed, ((uint64_t)i << 8) | RIG_STREAM);
    start.clock_us += (int64_t)lum_random_below(&random, BOOT_MAX_US);
    start.late_us =
        (int64_t)((double)lum_random_between(&random, PHASE_MIN, PHASE_MAX) *
                  1e6 / o->render.rate_hz);
    start.slow_ppm =
        (double)lum_random_between(&random, -SLOW_MAX_PPM, SLOW_MAX_PPM);
    start.number = i;
    return start;
}

static const char *path_or_none(const char *path)
{
    return path[0] != '\0' ? path : NULL;
}

/* False: there is no memory. */
static bool set_names(struct options *one, char *names[RIG_NAMES])
{
    const char **all[RIG_NAMES] = {&one->truth.points, &one->truth.calibration,
                                   &one->moving.labels};
    for (int i = 0; i < RIG_NAMES; i++) {
        if (*all[i] != NULL) {
            names[i] = rig_file_name(*all[i], one->rig.name);
            *all[i] = names[i];
            if (names[i] == NULL) {
                return complain("--rig: not enough memory");
            }
        }
    }
    return true;
}

static bool spread_one(struct options *o, uint32_t i)
{
    const lum_rig_files *files = &o->rig.files->of;
    const lum_rig_sensor *sensor = &files->rig.sensor[i];
    struct options *one = &o->rig.sensors[i];
    *one = *o;
    one->rig.name = sensor->name;
    one->rig.interface = sensor->interface;
    one->sensor = sensor->address;
    one->calibration = path_or_none(files->sensor[i].calibration_path);
    one->profile = path_or_none(files->sensor[i].profile_path);
    one->render.calibration = files->sensor[i].calibration;
    one->render.start = start_of(o, i);
    one->render.place.is_on_vehicle = true;
    one->render.place.on_vehicle = rig_pose(sensor);
    return set_names(one, o->rig.files->names[i]) && files_check(one) &&
           layout_take(one, &files->sensor[i].profile);
}

bool rig_spread(struct options *o)
{
    o->rig.sensors = calloc(o->rig.count, sizeof *o->rig.sensors);
    if (o->rig.sensors == NULL) {
        return complain("--rig: not enough memory");
    }
    for (uint32_t i = 0; i < o->rig.count; i++) {
        if (!spread_one(o, i)) {
            return false;
        }
    }
    return true;
}

void rig_free(struct options *o)
{
    for (size_t i = 0; i < o->rig.count; i++) {
        for (int n = 0; n < RIG_NAMES; n++) {
            free(o->rig.files->names[i][n]);
        }
    }
    free(o->rig.sensors);
    free(o->rig.files);
}
