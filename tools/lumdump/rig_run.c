#include "rig_run.h"

#include "../common/input_files.h"
#include "../common/number.h"
#include "../common/rig_sensors.h"
#include "base/system.h"
#include "base/text.h"
#include "cut.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- Names of outputs --- */

static int check_percent(const char *name, lum_error *error)
{
    return strstr(strstr(name, "%s") + 2, "%s") == NULL
               ? 0
               : lum_error_set(error,
                               "%s: %%s stands for the sensor's name, and has "
                               "to be there once",
                               name);
}

static int add_output(struct options *o, const struct output_options *output,
                      lum_error *error)
{
    if (o->output_count == OUTPUTS_MAX) {
        return lum_error_set(error,
                             "with one for each sensor there are more than %u "
                             "outputs: leave some out",
                             OUTPUTS_MAX);
    }
    o->outputs[o->output_count++] = *output;
    return 0;
}

static int spread(struct options *o, struct rig *rig,
                  const struct output_options *output, lum_error *error)
{
    if (check_percent(output->name, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < rig->count; i++) {
        struct output_options one = *output;
        char *name = rig_file_name(output->name, rig->sensors[i].of->name);
        one.name = name;
        one.sensor = (unsigned)i + 1u;
        if (name == NULL) {
            return lum_error_set(error, "out of memory");
        }
        if (add_output(o, &one, error) != 0) {
            free(name);
            return -1;
        }
        rig->names[o->output_count - 1u] = name;
    }
    return 0;
}

static int spread_all(struct options *o, struct rig *rig, lum_error *error)
{
    const struct options given = *o;
    o->output_count = 0;
    for (size_t i = 0; i < given.output_count; i++) {
        const struct output_options *output = &given.outputs[i];
        if ((strstr(output->name, "%s") != NULL
                 ? spread(o, rig, output, error)
                 : add_output(o, output, error)) != 0) {
            return -1;
        }
    }
    return 0;
}

static int refuse_percent(const struct options *o, lum_error *error)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (strstr(o->outputs[i].name, "%s") != NULL) {
            return lum_error_set(error,
                                 "%s: %%s stands for the name of a rig's "
                                 "sensor: give --rig FILE too",
                                 o->outputs[i].name);
        }
    }
    return 0;
}

/* --- Reading --- */

static void list_names(const lum_rig *rig, char *out, size_t room)
{
    out[0] = '\0';
    for (size_t i = 0; i < rig->count; i++) {
        lum_text_add(out, room, "%s%s", i > 0 ? ", " : "", rig->sensor[i].name);
    }
}

static void set_place(struct rig *rig, size_t i, size_t place)
{
    rig->sensors[i].of = &rig->files.rig.sensor[place];
    rig->sensors[i].place = place;
}

/* Of all sensors, by their places, only one is read. */
static void choose_only(struct rig *rig, size_t place)
{
    set_place(rig, place, 0);
    set_place(rig, 0, place);
    rig->count = 1;
    rig->is_one = true;
}

/* Those that are read: one, or all. */
static int choose(struct rig *rig, const char *name, lum_error *error)
{
    const lum_rig *all = &rig->files.rig;
    char names[LUM_RIG_SENSORS_MAX * (LUM_RIG_NAME_BYTES + 2u)];
    size_t chosen = 0;
    for (size_t i = 0; i < all->count; i++) {
        set_place(rig, i, i);
    }
    rig->count = all->count;
    if (name == NULL) {
        return 0;
    }
    while (chosen < all->count && strcmp(all->sensor[chosen].name, name) != 0) {
        chosen++;
    }
    if (chosen < all->count) {
        choose_only(rig, chosen);
        return 0;
    }
    list_names(all, names, sizeof names);
    return lum_error_set(error,
                         "--sensor: '%s' is not a sensor of %s, which has %s",
                         name, rig->path, names);
}

/* The sensor of a live run, by its address; of several by --sensor too. The
 * rig names its interface, which the session uses. */
static int choose_live(struct rig *rig, struct options *o, lum_error *error)
{
    const lum_rig *all = &rig->files.rig;
    const uint32_t address = o->live.address.address;
    size_t kept = 0;
    size_t found = 0;
    for (size_t i = 0; i < rig->count; i++) {
        if (rig->sensors[i].of->address == address) {
            found = rig->sensors[i].place;
            kept++;
        }
    }
    if (kept != 1u) {
        char names[LUM_RIG_SENSORS_MAX * (LUM_RIG_NAME_BYTES + 2u)];
        list_names(all, names, sizeof names);
        return lum_error_set(
            error,
            "%s: %s of %s %s this address, and a live run reads one: run one "
            "lumdump for each, with its address, and --sensor NAME where two "
            "share one; the rig has %s",
            o->source, kept == 0 ? "no sensor" : "several sensors", rig->path,
            kept == 0 ? "has" : "have", names);
    }
    if (!rig->is_one) {
        choose_only(rig, found);
    }
    rig->is_live = true;
    if (o->live.interface == NULL && rig->sensors[0].of->interface[0] != '\0') {
        o->live.interface = rig->sensors[0].of->interface;
    }
    return 0;
}

/* It is read before the others. */
static int check_standard_input(const struct options *o, lum_error *error)
{
    const struct input_file inputs[] = {
        {o->config.rig, "--rig"},
        {o->points.motion.poses, "--poses"},
        {o->points.motion.times, "--pose-times"},
        {sources_find_stdin(&o->sources), "the source"}};
    return input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                                  error);
}

int rig_open(struct options *o, struct rig **out, lum_error *error)
{
    *out = NULL;
    if (o->config.rig == NULL) {
        return refuse_percent(o, error);
    }
    struct rig *rig = calloc(1, sizeof *rig);
    if (rig == NULL) {
        return lum_error_set(error, "out of memory");
    }
    *out = rig;
    rig->path = o->config.rig;
    if (check_standard_input(o, error) != 0 ||
        lum_rig_load(rig->path, &rig->files, error) != 0 ||
        choose(rig, o->sensor.is_chosen ? o->sensor.text : NULL, error) != 0 ||
        (o->is_live && choose_live(rig, o, error) != 0)) {
        return -1;
    }
    o->sensor.is_chosen = false; /* by an address */
    return spread_all(o, rig, error);
}

void rig_free(struct rig *rig)
{
    if (rig != NULL) {
        for (size_t i = 0; i < OUTPUTS_MAX; i++) {
            free(rig->names[i]);
        }
        free(rig);
    }
}

/* --- What does not go with it --- */

static bool shares_address(const struct rig *rig)
{
    for (size_t i = 0; i < rig->count; i++) {
        for (size_t k = 0; k < i; k++) {
            if (rig->sensors[i].of->address == rig->sensors[k].of->address) {
                return true;
            }
        }
    }
    return false;
}

static bool is_of_all(const struct options *o, size_t i)
{
    return o->outputs[i].sensor == 0 && o->rig->count > 1;
}

static bool has_points(const struct options *o, size_t i)
{
    return !options_is_recording(o, i) && !options_has_messages(o, i);
}

void rig_choose_time(struct options *o)
{
    for (size_t i = 0; o->rig != NULL && i < o->output_count; i++) {
        if (!o->points.has_time && is_of_all(o, i) && has_points(o, i)) {
            o->points.time = TIME_UTC;
        }
    }
}

/* What an output of all sensors cannot be; NULL: it can. */
static const char *find_fault(const struct options *o, size_t i)
{
    const struct output_options *output = &o->outputs[i];
    if (output->format == (unsigned)LUM_FORMAT_PNG) {
        return "a picture shows one sensor";
    }
    if (has_points(o, i) && o->points.time == TIME_SENSOR) {
        return "--time sensor: each sensor has a clock of its own";
    }
    if (options_is_organized(o, i)) {
        return "the rows of --organized are of one sensor";
    }
    if (options_pattern(output->name) == 1) {
        return "frames of several sensors have no common numbers";
    }
    if (options_is_capture(output->format) && shares_address(o->rig)) {
        return "two sensors of the rig have one address, and a capture would "
               "not tell them apart";
    }
    return NULL;
}

static int check_map(const struct options *o, size_t i, lum_error *error)
{
    return !options_makes_map(o) || o->outputs[i].sensor == 0
               ? 0
               : lum_error_set(
                     error,
                     "%s: --voxel makes one map of all sensors: leave "
                     "%%s out of the name, or choose one sensor by "
                     "--sensor NAME",
                     o->outputs[i].name);
}

static int check_output(const struct options *o, size_t i, lum_error *error)
{
    const char *fault = is_of_all(o, i) ? find_fault(o, i) : NULL;
    return fault == NULL
               ? 0
               : lum_error_set(error,
                               "%s: %s: put %%s into the name, which makes an "
                               "output for each, or choose one by --sensor "
                               "NAME",
                               o->outputs[i].name, fault);
}

/* Messages without poses are in each sensor's own frame. */
static int check_messages(const struct options *o, lum_error *error)
{
    if (o->points.motion.poses != NULL ||
        !options_any(o, options_has_messages)) {
        return 0;
    }
    if (options_any(o, has_points)) {
        return lum_error_set(error,
                             "mcap has points in each sensor's own frame, and "
                             "other clouds in the vehicle's: make them by two "
                             "runs");
    }
    return !o->choice.points.has_box
               ? 0
               : lum_error_set(error, "--box is in the vehicle's frame, and "
                                      "mcap has points in each sensor's own: "
                                      "leave it out, or write another format");
}

static int check_choice(const struct options *o, lum_error *error)
{
    const struct rig *rig = o->rig;
    if (rig->count == 1) {
        return 0;
    }
    if (o->choice.whole != 0) {
        return lum_error_set(error, "--frames whole:N is of one sensor: choose "
                                    "it by --sensor NAME, or frames by their "
                                    "numbers, such as 2:2");
    }
    return !cut_is_asked(o)
               ? 0
               : lum_error_set(error,
                               "--frames, --eye and --incomplete cut the "
                               "capture of one sensor: choose it by --sensor "
                               "NAME");
}

/* An option that the rig's file has the place of. */
static const char *find_rival(const struct options *o)
{
    const struct config_options *c = &o->config;
    return c->calibration != NULL ? "--calibration"
           : c->profile != NULL   ? "--profile"
           : set_keys_first(&c->set, true) != NULL ||
                   set_keys_first(&c->set, false) != NULL
               ? "--set"
           : o->mcap.frame_id != NULL ? "--frame-id"
                                      : NULL;
}

int rig_check(const struct options *o, lum_error *error)
{
    const char *rival = o->rig != NULL ? find_rival(o) : NULL;
    int result = 0;
    if (o->rig == NULL) {
        return 0;
    }
    if (rival != NULL) {
        return lum_error_set(error,
                             "%s does not go with --rig, whose file has it for "
                             "each sensor: change %s",
                             rival, o->rig->path);
    }
    for (size_t i = 0; i < o->output_count && result == 0; i++) {
        result = check_output(o, i, error) == 0 ? check_map(o, i, error) : -1;
    }
    if (result == 0) {
        result = check_messages(o, error);
    }
    return result == 0 ? check_choice(o, error) : -1;
}

/* --- Making it ready --- */

static void describe(struct rig_sensor *s, const lum_rig_sensor_files *files)
{
    const lum_rig_sensor *of = s->of;
    (void)snprintf(
        s->line, sizeof s->line,
        "%zu: %s, %s%s%s, calibration %s, profile %s, at %.6f %.6f %.6f m, "
        "roll %.6f pitch %.6f yaw %.6f deg",
        s->place, of->name, number_address(of->address).text,
        of->interface[0] != '\0' ? "%" : "", of->interface,
        files->calibration_path[0] != '\0'
            ? lum_system_base(files->calibration_path)
            : "built-in",
        files->profile_path[0] != '\0' ? lum_system_base(files->profile_path)
                                       : "built-in",
        of->at_um[0] * 1e-6, of->at_um[1] * 1e-6, of->at_um[2] * 1e-6,
        of->roll_udeg * 1e-6, of->pitch_udeg * 1e-6, of->yaw_udeg * 1e-6);
}

static int prepare_sensor(struct rig *rig, size_t i, lum_error *error)
{
    struct rig_sensor *s = &rig->sensors[i];
    const lum_rig_sensor_files *files = &rig->files.sensor[s->place];
    s->geometry =
        (struct geometry){.calibration = files->calibration,
                          .profile = files->profile,
                          .has_calibration = files->calibration_path[0] != '\0',
                          .has_profile = files->profile_path[0] != '\0'};
    s->pose = rig_pose(s->of);
    if (geometry_make(&s->geometry, &s->layout, &s->projector, error) != 0) {
        return -1;
    }
    if (rig->is_placed) {
        lum_projector_place(&s->projector, &s->pose);
    }
    memset(s->places, (int)s->place, sizeof s->places);
    s->column = s->places;
    (void)snprintf(s->topic, sizeof s->topic, "/%s/points", s->of->name);
    describe(s, files);
    rig->members[i] = (lum_rig_member){
        .address = s->of->address,
        .interface = s->of->interface[0] != '\0' ? s->of->interface : NULL,
        .layout = &s->layout,
        .calibration = &s->geometry.calibration,
        .pose = rig->is_placed ? &s->pose : NULL,
        .is_left_out = i >= rig->count};
    return 0;
}

static void say_about(struct rig *rig, size_t i,
                      const struct provenance_run *points,
                      const struct provenance_run *packets)
{
    struct rig_sensor *s = &rig->sensors[i];
    const char *lines[] = {s->line};
    struct provenance_run run = *points;
    run.sensors = lines;
    run.sensor_count = 1;
    provenance_make(&run, &s->geometry, NULL, &s->points);
    run = *packets;
    run.sensors = lines;
    run.sensor_count = 1;
    provenance_make(&run, &s->geometry, NULL, &s->packets);
    rig->messages[i] =
        (lum_mcap_sensor){.topic = s->topic,
                          .frame_id = s->of->name,
                          .pose = &s->pose,
                          .calibration = &s->geometry.calibration,
                          .calibration_yaml = s->points.calibration,
                          .profile_yaml = s->points.profile};
}

int rig_prepare(struct rig *rig, const struct options *o,
                const struct provenance_run *points,
                const struct provenance_run *packets, lum_error *error)
{
    rig->is_placed =
        o->points.motion.poses != NULL || !options_any(o, options_has_messages);
    for (size_t i = 0; i < rig->files.rig.count; i++) {
        if (prepare_sensor(rig, i, error) != 0) {
            return -1;
        }
        say_about(rig, i, points, packets);
    }
    return 0;
}

/* --- Asking --- */

/* The sensor of the file that an address on an interface is: the one that
 * names it, or else one that names none. interface: NULL: it is not known.
 * Returns NULL if it is none. */
static const lum_rig_sensor *find(const struct rig *rig, uint32_t address,
                                  const char *interface)
{
    const lum_rig *all = &rig->files.rig;
    const lum_rig_sensor *found = NULL;
    for (size_t i = 0; i < all->count; i++) {
        const lum_rig_sensor *of = &all->sensor[i];
        const bool names_it =
            interface != NULL && strcmp(of->interface, interface) == 0;
        if (of->address == address && (names_it || of->interface[0] == '\0') &&
            (found == NULL || names_it)) {
            found = of;
        }
    }
    return found;
}

int rig_member(const struct rig *rig, const lum_demux *demux,
               const lum_record *record, const char *interface)
{
    const lum_rig_sensor *from = find(rig, record->source, interface);
    const lum_rig_sensor *of =
        from != NULL ? from : find(rig, record->destination, interface);
    const bool is_certain = of != NULL && of->interface[0] != '\0';
    for (size_t i = 0; i < rig->count; i++) {
        if (rig->sensors[i].of == of) {
            return is_certain || lum_demux_is_wanted(demux) ? (int)i : -1;
        }
    }
    return -1;
}

int rig_member_of(const struct rig *rig, const lum_framer *framer, size_t i)
{
    const int member = rig->is_live ? 0 : lum_framer_member(framer, i);
    return member < (int)rig->count ? member : -1;
}

bool rig_has_column(const struct options *o, size_t i)
{
    const unsigned format = o->outputs[i].format;
    const bool can = !options_is_capture(format) && !options_has_preset(o, i) &&
                     o->cloud.voxel == 0 &&
                     (lum_format_has_columns((lum_format)format) ||
                      format == (unsigned)LUM_FORMAT_LAS);
    return o->rig != NULL && can &&
           (o->cloud.wants_sensor ||
            (o->outputs[i].sensor == 0 && !o->rig->is_one));
}
