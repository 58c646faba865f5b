/* Refuses options that do not go together, or not with a source or an output,
 * with a message. By an output's name: targets.c. */
#include "rules.h"

#include "../common/host.h"
#include "rig_run.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* In one write. */
bool rules_refuse(const char *format, ...)
{
    char text[6000];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    (void)fprintf(stderr, "lumdump: %s\n", text);
    return false;
}

/* A rule for options, and what is said where it is broken. */
struct rule {
    bool is_broken;
    const char *why;
};

/* The first that is broken is refused. */
static bool keep_to(const struct rule *rules, size_t count)
{
    size_t i = 0;
    while (i < count && !rules[i].is_broken) {
        i++;
    }
    return i == count || rules_refuse("%s", rules[i].why);
}

#define KEEP_TO(rules) keep_to(rules, sizeof(rules) / sizeof(rules)[0])

static const char both_print[] =
    "--json and -o - would both write to standard output: name a file";

/* Whether an output has this format. */
static bool writes(const struct options *o, unsigned format)
{
    size_t i = 0;
    while (i < o->output_count && o->outputs[i].format != format) {
        i++;
    }
    return i < o->output_count;
}

static bool is_folder(const struct options *o, size_t i)
{
    return o->outputs[i].is_folder;
}

static bool has_columns(const struct options *o, size_t i)
{
    return !options_is_capture(o->outputs[i].format) &&
           lum_format_has_columns((lum_format)o->outputs[i].format);
}

/* --- Files that follow each other --- */

/* What it would keep is no more than is never removed. */
static bool keep_is_small(const struct options *o)
{
    const struct rotation *r = &o->files.rotation;
    const struct rotation *k = &o->files.keep;
    return (r->bytes != 0 && k->bytes != 0 && k->bytes < 2u * r->bytes) ||
           (r->ns != 0 && k->ns != 0 && k->ns < r->ns);
}

static bool keep_goes_with_rotation(const struct options *o)
{
    const struct rule rules[] = {
        {!options_is_rotation(&o->files.rotation),
         "--keep removes the oldest files of --rotate: give that too, such as "
         "--rotate 10min"},
        {options_any(o, is_folder),
         "--keep does not go with rosbag2, whose folder is new in each run: "
         "record .mcap files"},
        {keep_is_small(o),
         "--keep has to be at least the time of a file of --rotate, or twice "
         "its size: the newest whole file is never removed"}};
    return !options_is_rotation(&o->files.keep) || KEEP_TO(rules);
}

/* --- The source --- */

static bool live_goes_with_source(const struct options *o)
{
    const struct live_options *l = &o->live;
    const struct rule rules[] = {
        {o->is_live && o->points.threads != 0,
         "--threads goes with captures: of a sensor each output has a thread "
         "of its own"},
        {o->is_live && o->sensor.port != 0,
         "--port goes with captures: for a sensor give it in "
         "udp://ADDRESS:PORT"},
        {!o->is_live && o->choice.whole != 0 &&
             (o->output_count == 0 || options_any(o, options_takes_packets)),
         "--frames whole:N goes with an output of points: a frame is known to "
         "be whole only at its end, too late to cut a capture; choose by "
         "numbers, such as 2:2"},
        {o->is_live && o->sensor.is_chosen,
         "--sensor chooses among the sensors of a capture: udp://ADDRESS "
         "already names one"},
        {l->laser && l->guards, "--guard does not go with --laser, which does "
                                "the same and switches the laser on"},
        {!o->is_live && (l->laser || l->guards),
         "--laser and --guard go with a sensor, udp://ADDRESS: a capture has "
         "no laser"}};
    return KEEP_TO(rules);
}

static bool goes_with_source(const struct options *o)
{
    const struct live_options *l = &o->live;
    lum_error why = {""};
    if (!o->is_live &&
        (l->interface != NULL || l->buffer != 0 || l->receive_buffer != 0)) {
        return rules_refuse("--interface, --buffer and --receive-buffer go "
                            "with a sensor, udp://ADDRESS");
    }
    if (l->interface != NULL && !host_has_interface(l->interface, &why)) {
        return rules_refuse("--interface: %s", why.text);
    }
    return live_goes_with_source(o);
}

/* --- What outputs hold --- */

static bool goes_with_clouds(const struct options *o)
{
    const struct cloud_options *c = &o->cloud;
    const struct rule rules[] = {
        {c->columns != NULL && !options_any(o, has_columns),
         "--columns goes with csv, ply and pcd output only"},
        {c->preset != NULL && c->columns != NULL,
         "--preset and --columns both choose the columns: give one of them"},
        {c->preset != NULL && !options_any(o, options_has_preset),
         "--preset goes with csv, ply, pcd and mcap output only"},
        {c->organized && !writes(o, LUM_FORMAT_PCD),
         "--organized goes with pcd output only"},
        {c->organized && o->choice.points.returns == LUM_RETURNS_ALL,
         "--organized has room for one point of a pixel: choose it by --return "
         "first, last, strongest or a number"},
        {c->organized && o->choice.points.edges == LUM_EDGES_BOTH,
         "--organized has room for one point of a pixel: say --edge rising or "
         "falling, not both"},
        {c->picture.has_colour && !writes(o, LUM_FORMAT_PNG),
         "--colour goes with png output only"},
        {c->picture.width != 0 && !writes(o, LUM_FORMAT_PNG),
         "--size goes with png output only"},
        {c->ascii && o->output_count > 0 && !writes(o, LUM_FORMAT_PLY) &&
             !writes(o, LUM_FORMAT_PCD),
         "--ascii goes with ply and pcd output only"}};
    return KEEP_TO(rules);
}

static bool has_no_voxels(const struct options *o, size_t i)
{
    return options_is_capture(o->outputs[i].format) ||
           !lum_format_has_voxels((lum_format)o->outputs[i].format);
}

static bool is_pattern(const struct options *o, size_t i)
{
    return options_pattern(o->outputs[i].name) == 1;
}

static bool goes_with_voxels(const struct options *o)
{
    const struct cloud_options *c = &o->cloud;
    const struct rule rules[] = {
        {o->is_live, "--voxel goes with captures: record the sensor first, by "
                     "-o drive.pcapng"},
        {o->output_count == 0, "--voxel goes with an output: give -o, such as "
                               "-o map.las"},
        {options_any(o, has_no_voxels),
         "--voxel goes with csv, ply, pcd and las output only: others have no "
         "room for a voxel's number of points"},
        {c->columns != NULL || c->preset != NULL || c->organized,
         "--voxel has columns of its own: --columns, --preset and --organized "
         "do not go with it"},
        {options_is_rotation(&o->files.rotation),
         "--rotate does not go with --voxel: leave it out; a name such as "
         "thin-%04d.ply gives a file a frame"},
        {options_makes_map(o) && options_any(o, is_pattern),
         "--voxel makes one map of all frames in the world: name one file, or "
         "give --to start, which leaves each frame on its own"}};
    return o->cloud.voxel == 0 || KEEP_TO(rules);
}

static bool goes_with_messages(const struct options *o)
{
    const struct mcap_options *m = &o->mcap;
    const bool has_none = !writes(o, LUM_FORMAT_MCAP);
    const struct rule rules[] = {
        {m->has_compression && has_none,
         "--compression goes with mcap output only"},
        {m->has_compression && !m->is_plain && !lum_mcap_can_compress(),
         "--compression zstd: this lumdump was built without a libzstd that "
         "compresses; leave it out, or say none"},
        {m->contents != 0 && has_none, "--mcap goes with mcap output only"},
        {o->cloud.preset != NULL && (m->contents & LUM_MCAP_OF_LINES) != 0,
         "--mcap lines: the fields of --preset are of whole frames"},
        {m->frame_id != NULL && has_none,
         "--frame-id goes with mcap output only"},
        {m->lines != 0 && has_none, "--lines goes with mcap output only"}};
    return KEEP_TO(rules);
}

static bool has_points(const struct options *o, size_t i)
{
    return !options_is_recording(o, i);
}

static bool goes_with_motion(const struct options *o)
{
    const struct motion_options *m = &o->points.motion;
    const struct rule rules[] = {
        {m->poses == NULL && m->has_to,
         "--to says where points are moved to by poses: give --poses FILE too"},
        {m->poses == NULL && m->times != NULL,
         "--pose-times has the times of the poses of --poses: give that too"},
        {m->poses != NULL && o->is_live,
         "--poses goes with captures: where a live sensor was is known only "
         "afterwards; record a .pcap, then turn that into a cloud"},
        {m->poses != NULL && !options_any(o, has_points),
         "--poses moves points, and no output has any: name a cloud, such as "
         "-o map.las"},
        {m->poses != NULL && writes(o, LUM_FORMAT_PNG),
         "--poses does not go with png: a picture shows frames as the sensor "
         "sees them; name a cloud, such as -o map.ply"}};
    return KEEP_TO(rules);
}

static bool goes_with_rig(const struct options *o)
{
    lum_error why = {""};
    if (o->cloud.wants_sensor && o->rig == NULL) {
        return rules_refuse("--columns: the column " RIG_COLUMN " is of a "
                            "rig's sensors: give --rig FILE too");
    }
    return rig_check(o, &why) == 0 || rules_refuse("%s", why.text);
}

/* --- All of a run --- */

bool rules_allow(const struct options *o)
{
    const struct rule rules[] = {
        {o->cloud.comments && !writes(o, LUM_FORMAT_CSV) &&
             !writes(o, LUM_FORMAT_XYZ),
         "--comments goes with csv and xyz output only: ply, pcd, las and "
         "pcapng always have them"},
        {o->json && options_any(o, options_is_standard_output), both_print}};
    return goes_with_rig(o) && goes_with_clouds(o) && goes_with_voxels(o) &&
           goes_with_messages(o) && goes_with_motion(o) && KEEP_TO(rules) &&
           keep_goes_with_rotation(o) && goes_with_source(o);
}

/* --- Finding a layout --- */

/* The first option that is not one of these names; NULL: none. */
static const char *find_other(const struct option_table *table,
                              const struct option_result *given,
                              const char *const names[], size_t count)
{
    for (size_t i = 0; i < table->count; i++) {
        size_t k = 0;
        while (k < count && strcmp(table->specs[i].name, names[k]) != 0) {
            k++;
        }
        if (k == count && option_table_has(given, i)) {
            return table->specs[i].name;
        }
    }
    return NULL;
}

static bool can_write_profile(const struct options *o)
{
    unsigned format = 0;
    if (o->output_count > 1) {
        return rules_refuse("--infer writes one profile: name one output");
    }
    if (o->output_count == 1 &&
        options_find_format(o->outputs[0].name, &format)) {
        return rules_refuse("'%s': --infer writes a profile, which is YAML: "
                            "use a name such as profile.yaml",
                            o->outputs[0].name);
    }
    return !o->json || !options_any(o, options_is_standard_output) ||
           rules_refuse("%s", both_print);
}

bool rules_allow_infer(const struct options *o,
                       const struct option_table *table,
                       const struct option_result *given)
{
    static const char *const names[] = {"infer", "output", "sensor",
                                        "port",  "json",   "quiet"};
    const char *other =
        find_other(table, given, names, sizeof names / sizeof names[0]);
    if (o->is_live) {
        return rules_refuse(
            "--infer looks at a capture: record one by lumdump %s --laser "
            "--duration 3 -o look.pcap, then use lumdump look.pcap --infer",
            o->source);
    }
    if (other != NULL) {
        return rules_refuse("--%s does not go with --infer, which looks at "
                            "packets and makes no points: it goes with "
                            "--output, --sensor, --port, --json and --quiet",
                            other);
    }
    return can_write_profile(o);
}

/* --- Checking a cloud --- */

bool rules_allow_check(const struct option_table *table,
                       const struct option_result *given)
{
    static const char *const names[] = {"check-preset"};
    const char *other = find_other(table, given, names, 1);
    if (other != NULL) {
        return rules_refuse("--%s does not go with --check-preset, which only "
                            "looks at the fields of a cloud",
                            other);
    }
    return given->count == 1 ||
           rules_refuse("--check-preset looks at one cloud: name one FILE");
}
