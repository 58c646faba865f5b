/* lumdump: captures and sensors to clouds. */
#include "../common/geometry.h"
#include "../common/interrupt.h"
#include "conclude.h"
#include "pose_motion.h"
#include "replay.h"
#include "rig_run.h"
#include "runs.h"
#include "targets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* All that a run works with, once its source is open. */
struct job {
    struct options *options;
    struct geometry geometry;
    struct provenance_source source;
    struct motion *motion;
    struct provenance about_points;
    struct provenance about_packets;
    lum_layout layout;
    lum_projector projector;
    struct pass pass;
};

/* --- Where x, y and z of points in the world are 0 --- */

static bool is_bare(const struct options *o, size_t i)
{
    return !options_has_comment(o, o->outputs[i].format);
}

static bool has_offset(const struct options *o, size_t i)
{
    return o->outputs[i].format == (unsigned)LUM_FORMAT_LAS;
}

static bool has_only_comment(const struct options *o, size_t i)
{
    return !options_is_recording(o, i) && !has_offset(o, i);
}

/* How an output says what the origin is. */
static const char *name_places(const struct options *o)
{
    return !options_any(o, has_offset) ? "a comment of the file gives it"
           : options_any(o, has_only_comment)
               ? "las has it as its offset, other files in a comment"
               : "the file has it as its offset, so that readers add it";
}

static int refuse_bare(const struct options *o, const double origin[3],
                       lum_error *error)
{
    size_t i = 0;
    while (!is_bare(o, i)) {
        i++;
    }
    return lum_error_set(error,
                         "%s: the poses are farther than 5 km from 0, so x, y "
                         "and z are relative to the origin %.0f %.0f %.0f, and "
                         "nothing in the file would say so: give --comments, "
                         "or write .las, .ply or .pcd",
                         o->outputs[i].name, origin[0], origin[1], origin[2]);
}

/* Even a good origin is far from the ends of a long way. */
static void warn_of_width(const struct options *o, const struct motion *motion)
{
    const double far_m = motion_farthest(motion);
    if (far_m > LUM_POSES_FAR_M) {
        const float at = (float)far_m;
        conclude_warn(o,
                      "%s: poses are up to %.1f km from the origin: there x, y "
                      "and z, which are floats, have steps of %.2g mm; poses "
                      "of a shorter part of the drive give smaller ones",
                      motion_name(motion), far_m * 1e-3,
                      1e3 * ((double)nextafterf(at, INFINITY) - (double)at));
    }
}

/* Note the origin of the world for the outputs, and say it. -1: an output would
 * not name it. */
static int world_begin(struct options *o, const struct motion *motion,
                       lum_error *error)
{
    double *origin = o->about.origin;
    if (!motion_origin(motion, origin)) {
        return 0;
    }
    if (fabs(origin[0]) + fabs(origin[1]) + fabs(origin[2]) > 0.0) {
        if (options_any(o, is_bare)) {
            return refuse_bare(o, origin, error);
        }
        struct filter *f = &o->filters.list[o->filters.count++];
        (void)snprintf(f->text, sizeof f->text, "origin=%.0f,%.0f,%.0f",
                       origin[0], origin[1], origin[2]);
        conclude_warn(o,
                      "the poses are farther than 5 km from 0: x, y and z are "
                      "relative to the origin %.0f %.0f %.0f; %s",
                      origin[0], origin[1], origin[2], name_places(o));
    }
    warn_of_width(o, motion);
    return 0;
}

/* --- Preparing --- */

static struct provenance_run run_of(const struct options *o, bool of_packets,
                                    const char *texts[FILTERS_MAX])
{
    struct provenance_run run = {
        .program = "lumdump", .source = o->source, .options = texts};
    for (size_t i = 0; i < o->filters.count; i++) {
        const struct filter *f = &o->filters.list[i];
        if (f->is_of_packets || !of_packets) {
            texts[run.option_count++] = f->text;
        }
    }
    return run;
}

static void say_about(const struct job *job, bool of_packets,
                      struct provenance *out)
{
    const char *texts[FILTERS_MAX];
    const char *lines[LUM_RIG_SENSORS_MAX];
    const struct rig *rig = job->options->rig;
    struct provenance_run run = run_of(job->options, of_packets, texts);
    run.sensors = lines;
    for (; rig != NULL && run.sensor_count < rig->count; run.sensor_count++) {
        lines[run.sensor_count] = rig->sensors[run.sensor_count].line;
    }
    provenance_make(&run, &job->geometry, &job->source, out);
}

/* Layouts and projectors: the rig's, of which the first serves where only one
 * can, or those of the command line. */
static int prepare_geometry(struct job *job, lum_error *error)
{
    const char *points[FILTERS_MAX];
    const char *packets[FILTERS_MAX];
    struct options *o = job->options;
    if (o->rig == NULL) {
        return geometry_set(&job->geometry, &o->config.set, error) == 0
                   ? geometry_make(&job->geometry, &job->layout,
                                   &job->projector, error)
                   : -1;
    }
    const struct provenance_run of_points = run_of(o, false, points);
    const struct provenance_run of_packets = run_of(o, true, packets);
    if (rig_prepare(o->rig, o, &of_points, &of_packets, error) != 0) {
        return -1;
    }
    job->layout = o->rig->sensors[0].layout;
    job->projector = o->rig->sensors[0].projector;
    return 0;
}

/* For a message; not the built-in one. */
static const char *name_profile(const struct options *o)
{
    if (set_keys_first(&o->config.set, true) != NULL) {
        return "of --set";
    }
    return o->config.profile != NULL ? o->config.profile : "of the capture";
}

/* The profile of packets without timestamps; NULL: all have them. */
static const char *find_clockless(const struct job *job)
{
    const struct rig *rig = job->options->rig;
    const size_t count = rig != NULL ? rig->count : 1u;
    for (size_t i = 0; i < count; i++) {
        const lum_layout *layout =
            rig != NULL ? &rig->sensors[i].layout : &job->layout;
        if (layout->profile.group[LUM_FIELD_TIMESTAMP].bytes == 0) {
            return rig != NULL
                       ? rig->files.sensor[rig->sensors[i].place].profile_path
                       : name_profile(job->options);
        }
    }
    return NULL;
}

static int prepare_motion(struct job *job, lum_error *error)
{
    struct options *o = job->options;
    const char *clockless = find_clockless(job);
    if (o->points.motion.poses != NULL && clockless != NULL) {
        return lum_error_set(
            error,
            "--poses: the profile %s gives packets no timestamp, so points "
            "have no times to find their poses by; leave --poses out",
            clockless);
    }
    if (motion_new(o, &job->motion, error) != 0) {
        return -1;
    }
    if (o->rig != NULL && o->rig->count > 1 && job->motion != NULL &&
        !motion_is_utc(job->motion)) {
        return lum_error_set(error,
                             "--poses: %s has times of a sensor's clock, and "
                             "each sensor of %s has another: give poses with "
                             "times of UTC, or choose one sensor by --sensor "
                             "NAME",
                             o->points.motion.poses, o->rig->path);
    }
    return world_begin(o, job->motion, error);
}

/* What outputs say names what the run uses. */
static int prepare(struct job *job, lum_error *error)
{
    struct options *o = job->options;
    if (prepare_geometry(job, error) != 0) {
        return -1;
    }
    const char *clockless = find_clockless(job);
    if (prepare_motion(job, error) != 0) {
        return -1;
    }
    if (o->points.time == TIME_UTC && clockless != NULL) {
        return lum_error_set(error,
                             "%s: the profile %s gives packets no timestamp to "
                             "fit; use --time arrival",
                             o->points.has_time
                                 ? "--time utc"
                                 : "points of several sensors have UTC",
                             clockless);
    }
    say_about(job, false, &job->about_points);
    say_about(job, true, &job->about_packets);
    o->about.points = &job->about_points;
    o->about.packets = &job->about_packets;
    o->about.calibration = &job->geometry.calibration;
    job->pass = (struct pass){
        .options = o,
        .source = {.capture = job->pass.source.capture, .about = &job->source},
        .layout = &job->layout,
        .projector = &job->projector,
        .motion = job->motion};
    return 0;
}

/* --- Running --- */

static unsigned flags_of(bool has_calibration, bool has_profile)
{
    return (has_calibration ? 1u : 0u) + (has_profile ? 2u : 0u);
}

/* What packets of an output are read by: 1 a calibration, 2 a profile, 3 both,
 * of one of the sensors at least.
 * sensor: as output_options.sensor. */
static unsigned find_used(const struct job *job, unsigned sensor)
{
    const struct geometry *g = &job->geometry;
    const struct rig *rig = job->options->rig;
    unsigned what = flags_of(g->has_calibration, g->has_profile);
    for (size_t i = 0; rig != NULL && i < rig->count; i++) {
        if (sensor == 0 || sensor == i + 1u) {
            g = &rig->sensors[i].geometry;
            what |= flags_of(g->has_calibration, g->has_profile);
        }
    }
    return what;
}

/* Who has the packets alone would read them by the built-in ones. */
static void warn_of_pcap(const struct job *job)
{
    static const char *const lost[] = {
        "the calibration that is used: write pcapng to keep it",
        "the profile that is used: write pcapng to keep it",
        ("the calibration and the profile that are used: write pcapng to keep "
         "them")};
    const struct options *o = job->options;
    for (size_t i = 0; i < o->output_count; i++) {
        const unsigned what = find_used(job, o->outputs[i].sensor);
        const bool is_pcap = o->outputs[i].format == FORMAT_PCAP;
        if (what > 0 && o->rig != NULL && o->rig->count > 1 &&
            o->outputs[i].sensor == 0 && options_is_recording(o, i)) {
            conclude_warn(o,
                          "%s: a capture of several sensors has no room for "
                          "the calibrations and profiles of %s: read it with "
                          "that again, or put %%s into its name",
                          o->outputs[i].name, o->rig->path);
        } else if (what > 0 && is_pcap) {
            conclude_warn(o, "%s: pcap has no room for %s", o->outputs[i].name,
                          lost[what - 1u]);
        }
    }
}

static enum exit_status run_live(struct job *job)
{
    lum_error error = {""};
    if (prepare(job, &error) != 0) {
        return conclude_error(&error, EXIT_BAD);
    }
    warn_of_pcap(job);
    return live_run(&job->pass);
}

/* What the rig names not for every sensor, as in find_used(). */
static unsigned find_left_out(const struct rig *rig)
{
    unsigned what = 0;
    for (size_t i = 0; i < rig->count; i++) {
        const lum_rig_sensor_files *files =
            &rig->files.sensor[rig->sensors[i].place];
        what |= flags_of(files->calibration_path[0] == '\0',
                         files->profile_path[0] == '\0');
    }
    return what;
}

/* A rig says which calibration each sensor has: that of the capture, which
 * could be any one's, is not taken. */
static void take_about(struct job *job)
{
    static const char *const kinds[] = {"calibration", "profile",
                                        "calibration and a profile"};
    const lum_capture *capture = job->pass.source.capture;
    const struct rig *rig = job->options->rig;
    if (rig == NULL) {
        provenance_take(capture, &job->geometry, &job->source);
        conclude_about(job->options, &job->source);
        return;
    }
    struct geometry its = job->geometry;
    provenance_take(capture, &its, &job->source);
    job->source.takes_calibration = false;
    job->source.takes_profile = false;
    const unsigned lacks =
        flags_of(its.has_calibration, its.has_profile) & find_left_out(rig);
    if (lacks > 0) {
        conclude_warn(job->options,
                      "%s: it has a %s of its own, which is not used: a sensor "
                      "without one in %s is read by the built-in one",
                      job->options->source, kinds[lacks - 1u], rig->path);
    }
}

static enum exit_status read_capture(struct job *job)
{
    lum_error error = {""};
    struct pass *pass = &job->pass;
    enum pass_result result =
        replay_open(job->options, &pass->source.capture, &error);
    if (result == PASS_DONE) {
        take_about(job);
        if (prepare(job, &error) != 0) {
            return conclude_error(&error, EXIT_BAD);
        }
        warn_of_pcap(job);
        result = replay(pass, &error);
    }
    const enum exit_status status = conclude(pass, result, &error);
    conclude_notes(pass);
    return status;
}

static enum exit_status run_capture(struct job *job)
{
    const enum exit_status status = read_capture(job);
    outputs_abort(job->pass.outputs);
    pass_free(&job->pass);
    if (interrupt_signal() != 0) {
        interrupt_die();
    }
    return status;
}

static enum exit_status run(struct options *o)
{
    lum_error error = {""};
    struct job *job = calloc(1, sizeof *job);
    if (job == NULL) {
        (void)lum_error_set(&error, "out of memory");
        return conclude_error(&error, EXIT_FAILED);
    }
    job->options = o;
    enum exit_status status = EXIT_BAD;
    if (geometry_load(o->config.calibration, o->config.profile, &o->sources,
                      &job->geometry, &error) != 0 ||
        targets_check(o, &error) != 0) {
        status = conclude_error(&error, EXIT_BAD);
    } else {
        status = o->is_live ? run_live(job) : run_capture(job);
    }
    motion_free(job->motion);
    free(job);
    return status;
}

static enum exit_status act(enum option_end end, struct options *options)
{
    switch (end) {
    case OPTIONS_SHOWN:
        return conclude_stdout();
    case OPTIONS_REFUSED:
        return EXIT_BAD;
    case OPTIONS_READ:
    default:
        if (options->instead.check_preset != NULL) {
            return check_preset_run(options);
        }
        return options->instead.infer ? infer_run(options) : run(options);
    }
}

int main(int argc, char **argv)
{
    struct options options;
    interrupt_catch();
    const enum exit_status status =
        act(command_line_read(argc, argv, &options), &options);
    command_line_free(&options);
    return (int)status;
}
