/* Which options go together, with a source and with outputs: all else is
 * refused, with a message. */
#include "rules.h"

#include "../common/host.h"

#include <stdio.h>
#include <string.h>

bool rules_refuse(const char *why)
{
    (void)fprintf(stderr, "lumdump: %s\n", why);
    return false;
}

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

static bool is_rotation(const struct rotation *r)
{
    return r->bytes != 0 || r->ns != 0;
}

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
    if (!is_rotation(&o->files.keep)) {
        return true;
    }
    if (!is_rotation(&o->files.rotation)) {
        return rules_refuse("--keep removes the oldest files of --rotate: give "
                            "that too, such as --rotate 10min");
    }
    if (options_any(o, is_folder)) {
        return rules_refuse("--keep does not go with rosbag2, whose folder is "
                            "new in each run: record .mcap files");
    }
    return !keep_is_small(o) ||
           rules_refuse(
               "--keep has to be at least the time of a file of --rotate, or "
               "twice its size: the newest whole file is never removed");
}

/* --- The source --- */

static bool laser_goes_with_source(const struct options *o)
{
    if (o->live.laser && o->live.guards) {
        return rules_refuse("--guard does not go with --laser, which does the "
                            "same and switches the laser on");
    }
    if (!o->is_live && (o->live.laser || o->live.guards)) {
        return rules_refuse("--laser and --guard go with a sensor, "
                            "udp://ADDRESS: a capture has no laser");
    }
    return true;
}

static bool goes_with_source(const struct options *o)
{
    if (!o->is_live && (o->live.interface != NULL || o->live.buffer != 0 ||
                        o->live.receive_buffer != 0)) {
        return rules_refuse("--interface, --buffer and --receive-buffer go "
                            "with a sensor, udp://ADDRESS");
    }
    lum_error why = {""};
    if (o->live.interface != NULL &&
        !host_has_interface(o->live.interface, &why)) {
        (void)fprintf(stderr, "lumdump: --interface: %s\n", why.text);
        return false;
    }
    if (o->is_live && o->points.threads != 0) {
        return rules_refuse("--threads goes with captures: of a sensor each "
                            "output has a thread of its own");
    }
    if (o->is_live && o->sensor.port != 0) {
        return rules_refuse("--port is of the sensors in a capture: for a "
                            "sensor name it in udp://ADDRESS:PORT");
    }
    if (!o->is_live && o->choice.whole != 0 &&
        (o->output_count == 0 || options_any(o, options_takes_packets))) {
        return rules_refuse(
            "--frames whole:N goes with an output of points: a frame is known "
            "to be whole only at its end, too late to cut a capture; choose by "
            "numbers, such as 2:2");
    }
    if (o->is_live && o->sensor.is_chosen) {
        return rules_refuse("--sensor chooses among the sensors of a capture: "
                            "udp://ADDRESS already names one");
    }
    return laser_goes_with_source(o);
}

/* --- What outputs hold --- */

static bool can_preset(const struct options *o)
{
    if (o->cloud.columns != NULL) {
        return rules_refuse(
            "--preset and --columns both choose the columns: give one of them");
    }
    return options_any(o, options_has_preset) ||
           rules_refuse(
               "--preset goes with csv, ply, pcd and mcap output only");
}

static bool can_choose_messages(const struct options *o)
{
    if (!writes(o, LUM_FORMAT_MCAP)) {
        return rules_refuse("--mcap goes with mcap output only");
    }
    return o->cloud.preset == NULL ||
           (o->mcap.contents & LUM_MCAP_OF_LINES) == 0 ||
           rules_refuse(
               "--mcap lines: the fields of --preset are of whole frames");
}

static bool can_organize(const struct options *o)
{
    if (!writes(o, LUM_FORMAT_PCD)) {
        return rules_refuse("--organized goes with pcd output only");
    }
    if (o->choice.points.returns == LUM_RETURNS_ALL) {
        return rules_refuse(
            "--organized has room for one point of a pixel: choose it by "
            "--return first, last, strongest or a number");
    }
    return o->choice.points.edges != LUM_EDGES_BOTH ||
           rules_refuse("--organized has room for one point of a pixel: say "
                        "--edge rising or falling, not both");
}

static bool can_compress(const struct options *o)
{
    if (!writes(o, LUM_FORMAT_MCAP)) {
        return rules_refuse("--compression goes with mcap output only");
    }
    return o->mcap.is_plain || lum_mcap_can_compress() ||
           rules_refuse("--compression zstd: this lumdump was built without a "
                        "libzstd that compresses; leave it out, or say none");
}

static bool goes_with_messages(const struct options *o)
{
    return (!o->mcap.has_compression || can_compress(o)) &&
           (o->mcap.contents == 0 || can_choose_messages(o)) &&
           (o->mcap.frame_id == NULL || writes(o, LUM_FORMAT_MCAP) ||
            rules_refuse("--frame-id goes with mcap output only")) &&
           (o->mcap.lines == 0 || writes(o, LUM_FORMAT_MCAP) ||
            rules_refuse("--lines goes with mcap output only"));
}

/* --- All of a run --- */

bool rules_allow(const struct options *o)
{
    if (o->cloud.columns != NULL && !options_any(o, has_columns)) {
        return rules_refuse("--columns goes with csv, ply and pcd output only");
    }
    if (o->cloud.preset != NULL && !can_preset(o)) {
        return false;
    }
    if (o->cloud.organized && !can_organize(o)) {
        return false;
    }
    if (o->cloud.ascii && o->output_count > 0 && !writes(o, LUM_FORMAT_PLY) &&
        !writes(o, LUM_FORMAT_PCD)) {
        return rules_refuse("--ascii goes with ply and pcd output only");
    }
    if (!goes_with_messages(o)) {
        return false;
    }
    if (o->cloud.comments && !writes(o, LUM_FORMAT_CSV) &&
        !writes(o, LUM_FORMAT_XYZ)) {
        return rules_refuse("--comments goes with csv and xyz output only: "
                            "ply, pcd, las and pcapng always have them");
    }
    if (o->json && options_any(o, options_is_standard_output)) {
        return rules_refuse(
            "--json and -o - would both write to standard output: name a file");
    }
    return keep_goes_with_rotation(o) && goes_with_source(o);
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
        (void)fprintf(stderr,
                      "lumdump: '%s': --infer writes a profile, which is YAML: "
                      "use a name such as profile.yaml\n",
                      o->outputs[0].name);
        return false;
    }
    return !o->json || !options_any(o, options_is_standard_output) ||
           rules_refuse("--json and -o - would both write to standard output: "
                        "name a file");
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
        (void)fprintf(stderr,
                      "lumdump: --infer looks at a capture: record one by "
                      "lumdump %s --laser --duration 3 -o look.pcap, then use "
                      "lumdump look.pcap --infer\n",
                      o->source);
        return false;
    }
    if (other != NULL) {
        (void)fprintf(stderr,
                      "lumdump: --%s does not go with --infer, which looks at "
                      "packets and makes no points: it goes with --output, "
                      "--sensor, --port, --json and --quiet\n",
                      other);
        return false;
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
        (void)fprintf(stderr,
                      "lumdump: --%s does not go with --check-preset, which "
                      "only looks at the fields of a cloud\n",
                      other);
        return false;
    }
    return given->count == 1 ||
           rules_refuse("--check-preset looks at one cloud: name one FILE");
}
