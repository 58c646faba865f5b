/* Refuses outputs by their names before they are opened: one that is read,
 * one that is written twice, one that cannot do what is asked. */
#include "targets.h"

#include "../common/file_look.h"
#include "../common/input_files.h"
#include "base/system.h"
#include "numbered.h"
#include "rig_run.h"

#include <string.h>

#define INPUTS_MAX (5u + 2u * LUM_RIG_SENSORS_MAX)

/* What the run reads beside its sources; a path may be NULL. */
static size_t list_inputs(const struct options *o,
                          struct input_file out[INPUTS_MAX])
{
    const struct input_file inputs[] = {
        {o->config.calibration, "the calibration"},
        {o->config.profile, "the profile"},
        {o->points.motion.poses, "the file of poses"},
        {o->points.motion.times, "the file of the poses' times"},
        {o->config.rig, "the rig"}};
    size_t n = sizeof inputs / sizeof inputs[0];
    memcpy(out, inputs, sizeof inputs);
    for (size_t i = 0; o->rig != NULL && i < o->rig->files.rig.count; i++) {
        const lum_rig_sensor_files *of = &o->rig->files.sensor[i];
        if (of->calibration_path[0] != '\0') {
            out[n++] = (struct input_file){of->calibration_path,
                                           "a calibration of the rig"};
        }
        if (of->profile_path[0] != '\0') {
            out[n++] =
                (struct input_file){of->profile_path, "a profile of the rig"};
        }
    }
    return n;
}

int targets_check_inputs(const struct options *options, const char *name,
                         lum_error *error)
{
    struct input_file inputs[INPUTS_MAX];
    const size_t count = list_inputs(options, inputs);
    return sources_check(&options->sources, inputs, count, name, error);
}

/* Once more with the poses. */
static int check_standard_input(const struct options *o, lum_error *error)
{
    const struct input_file inputs[] = {
        {o->config.calibration, "--calibration"},
        {o->config.profile, "--profile"},
        {o->points.motion.poses, "--poses"},
        {o->points.motion.times, "--pose-times"},
        {sources_find_stdin(&o->sources), "the source"}};
    return input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                                  error);
}

/* A name without a file yet will be a file that can seek; for a directory the
 * opening reports the error. */
static bool can_seek(const char *output)
{
    struct file_look look;
    return file_look(output, &look)
               ? look.kind == FILE_REGULAR || look.kind == FILE_DIRECTORY
               : strcmp(output, "-") != 0;
}

bool targets_needs_rehearsal(const struct options *options, size_t i)
{
    const struct output_options *o = &options->outputs[i];
    return !options_is_recording(options, i) &&
           !options_is_organized(options, i) &&
           lum_format_needs_count((lum_format)o->format) && !can_seek(o->name);
}

static int check_pattern(const struct options *options, size_t i,
                         lum_error *error)
{
    const struct output_options *o = &options->outputs[i];
    const int pattern = options_pattern(o->name);
    if (pattern < 0) {
        return lum_error_set(error,
                             "%s: a %% in the name stands for the frame "
                             "number: write %%d or %%04d, once",
                             o->name);
    }
    if (o->is_folder && (pattern == 1 || strcmp(o->name, "-") == 0)) {
        return lum_error_set(error, "%s: rosbag2 is a folder: name one",
                             o->name);
    }
    if (pattern == 1 && options_takes_packets(options, i)) {
        return lum_error_set(error,
                             "%s: packets are not of one frame: name "
                             "one file",
                             o->name);
    }
    return 0;
}

/* Rows are those of one frame. */
static int check_organized(const struct options *options, size_t i,
                           lum_error *error)
{
    const char *name = options->outputs[i].name;
    return !options_is_organized(options, i) || options_pattern(name) == 1 ||
                   options->choice.frame_first == options->choice.frame_last ||
                   options->choice.whole == 1
               ? 0
               : lum_error_set(error,
                               "%s: --organized makes a file of each frame: "
                               "put %%04d into the name, or choose one frame "
                               "by --frames N:N or whole:1",
                               name);
}

/* The directory that a file is in. */
static bool find_directory(const char *path, struct file_look *out)
{
    char directory[4096];
    const size_t len = (size_t)(lum_system_base(path) - path);
    if (len == 0) {
        return file_look(".", out);
    }
    if (len >= sizeof directory) {
        return false;
    }
    (void)memcpy(directory, path, len);
    directory[len] = '\0';
    return file_look(directory, out);
}

/* Whether two outputs are one file, by any names. Two outputs may name one
 * device. */
static bool is_same_output(const char *a, const char *b)
{
    struct file_look s;
    struct file_look t;
    const bool has_a = file_look(a, &s);
    const bool has_b = file_look(b, &t);
    if (strcmp(a, b) == 0) {
        return true;
    }
    if (has_a || has_b) {
        return has_a && has_b && s.kind != FILE_DEVICE &&
               file_look_is_same(&s, &t);
    }
    return strcmp(lum_system_base(a), lum_system_base(b)) == 0 &&
           find_directory(a, &s) && find_directory(b, &t) &&
           file_look_is_same(&s, &t);
}

/* What the names of a run's files may come to is refused before the first is
 * made. */
static int check_numbered(const struct options *options, size_t i,
                          const char *input, lum_error *error)
{
    struct file_look s;
    struct file_look t;
    const char *name = options->outputs[i].name;
    const bool has_pattern = strchr(lum_system_base(name), '%') != NULL;
    if (input == NULL || (!has_pattern && !options_rotates(options, i))) {
        return 0;
    }
    const struct numbered n = numbered_of(lum_system_base(name));
    if (!numbered_has(&n, lum_system_base(input)) ||
        !find_directory(name, &s) || !find_directory(input, &t) ||
        !file_look_is_same(&s, &t)) {
        return 0;
    }
    return lum_error_set(error,
                         "%s, which this run reads, has one of the names of "
                         "%s: name another output",
                         input, name);
}

static int check_all_numbered(const struct options *options, size_t i,
                              lum_error *error)
{
    for (size_t k = 0; k < options->sources.count; k++) {
        if (check_numbered(options, i, options->sources.paths[k], error) != 0) {
            return -1;
        }
    }
    struct input_file inputs[INPUTS_MAX];
    const size_t count = list_inputs(options, inputs);
    for (size_t k = 0; k < count; k++) {
        if (check_numbered(options, i, inputs[k].path, error) != 0) {
            return -1;
        }
    }
    return 0;
}

static int check_others(const struct options *options, size_t i,
                        lum_error *error)
{
    const char *name = options->outputs[i].name;
    if (options->output_count > 1 && file_look_is_dangling(name)) {
        return lum_error_set(
            error, "%s is a link to a missing file: name a file", name);
    }
    for (size_t k = 0; k < i; k++) {
        const char *other = options->outputs[k].name;
        if (is_same_output(other, name)) {
            return lum_error_set(error,
                                 "%s: named twice as output, before as %s: "
                                 "each needs its own file",
                                 name, other);
        }
    }
    return 0;
}

static int check_rotation(const struct options *options, lum_error *error)
{
    return !options_is_rotation(&options->files.rotation) ||
                   options_any(options, options_rotates)
               ? 0
               : lum_error_set(
                     error,
                     "--rotate: no output can continue in a new file: standard "
                     "output and outputs with a file for each frame cannot");
}

static bool has_more(const struct options *options, size_t i)
{
    return !options_is_recording(options, i);
}

/* The first option that chooses among the points of a line; NULL: none does. */
static const char *find_point_option(const lum_selection *s)
{
    if (s->has_range) {
        return "--range";
    }
    if (s->has_box) {
        return "--box";
    }
    if (s->returns != LUM_RETURNS_ALL) {
        return "--return";
    }
    return s->edges != LUM_EDGES_RISING ? "--edge" : NULL;
}

/* The first that chooses among lines. */
static const char *find_line_option(const struct options *o)
{
    if (o->choice.eyes != 3u) {
        return "--eye";
    }
    if (options_has_frames(o)) {
        return "--frames";
    }
    return o->choice.drop_incomplete ? "--incomplete drop" : NULL;
}

/* A recording holds all packets; the options of selection apply to the other
 * outputs of the run. */
static int check_recording(const struct options *o, lum_error *error)
{
    const char *points = find_point_option(&o->choice.points);
    const char *option = points != NULL ? points : find_line_option(o);
    if (o->choice.has_packets) {
        return lum_error_set(error, "--packets goes with a capture that is "
                                    "cut: a recording holds all packets");
    }
    return option == NULL || o->output_count == 0 || options_any(o, has_more)
               ? 0
               : lum_error_set(error,
                               "%s: a recording holds all packets: record it, "
                               "and cut the file by lumdump FILE %s ...",
                               option, option);
}

/* An output that cannot be cut by these options is refused. */
static int check_cut(const struct options *o, lum_error *error)
{
    const char *points = find_point_option(&o->choice.points);
    if (o->is_live) {
        return check_recording(o, error);
    }
    if (options_any(o, options_is_recording) && points != NULL) {
        return lum_error_set(error,
                             "%s: a packet holds many points, so a capture "
                             "cannot be cut by it; it can by --frames, --eye, "
                             "--incomplete, --duration and --sensor",
                             points);
    }
    return !o->choice.has_packets || (options_any(o, options_takes_packets) &&
                                      find_line_option(o) != NULL)
               ? 0
               : lum_error_set(error,
                               "--packets goes with a capture that "
                               "--frames, --eye or --incomplete drop cuts");
}

/* The number of voxels is known at their end alone. */
static int check_voxels(const struct options *options, size_t i,
                        lum_error *error)
{
    return options->cloud.voxel == 0 || !targets_needs_rehearsal(options, i)
               ? 0
               : lum_error_set(error,
                               "%s: the format's header holds the number of "
                               "voxels, and this output cannot seek: use -o "
                               "FILE, or csv",
                               options->outputs[i].name);
}

int targets_check(const struct options *options, lum_error *error)
{
    if (check_standard_input(options, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < options->output_count; i++) {
        const struct output_options *o = &options->outputs[i];
        if (check_pattern(options, i, error) != 0 ||
            check_organized(options, i, error) != 0 ||
            check_voxels(options, i, error) != 0 ||
            check_others(options, i, error) != 0 ||
            targets_check_inputs(options, o->name, error) != 0 ||
            check_all_numbered(options, i, error) != 0) {
            return -1;
        }
        if (options->is_live && targets_needs_rehearsal(options, i)) {
            return lum_error_set(error,
                                 "%s: the format's header holds the number of "
                                 "points, and this output cannot seek: use -o "
                                 "FILE, or csv",
                                 o->name);
        }
    }
    if ((options->output_count == 0 || options->json) &&
        targets_check_inputs(options, "-", error) != 0) {
        return -1;
    }
    return check_cut(options, error) == 0 ? check_rotation(options, error) : -1;
}
