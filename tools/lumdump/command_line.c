/* The command line of lumdump: the table of its options, read into a struct
 * options. */
#include "options.h"

#include "../common/host.h"
#include "../common/ring.h"
#include "../common/source_url.h"

#include "lum/map/map.h"
#include "lum/net/socket.h"
#include "lum/picture/picture.h"
#include "rig_run.h"
#include "row_threads.h"
#include "rules.h"
#include "values.h"

#include <stdio.h>
#include <string.h>

/* --- The table --- */

static const struct option_word formats[] = {
    {"csv", LUM_FORMAT_CSV},
    {"ply", LUM_FORMAT_PLY},
    {"pcd", LUM_FORMAT_PCD},
    {"las", LUM_FORMAT_LAS},
    {"xyz", LUM_FORMAT_XYZ},
    {"png", LUM_FORMAT_PNG},
    {"mcap", LUM_FORMAT_MCAP},
    {"pcap", FORMAT_PCAP},
    {"pcapng", FORMAT_PCAPNG},
    {"rosbag2", FORMAT_ROSBAG2},
    {NULL, 0},
};
static const struct option_word compressions[] = {
    {"zstd", 0}, {"none", 1}, {NULL, 0}};
static const struct option_word clocks[] = {{"sensor", TIME_SENSOR},
                                            {"utc", TIME_UTC},
                                            {"arrival", TIME_ARRIVAL},
                                            {NULL, 0}};
static const struct option_word places[] = {{"start", LUM_MOVE_TO_START},
                                            {"middle", LUM_MOVE_TO_MIDDLE},
                                            {"world", LUM_MOVE_TO_WORLD},
                                            {NULL, 0}};
static const struct option_word colours[] = {
    {"range", LUM_PICTURE_RANGE},
    {"height", LUM_PICTURE_HEIGHT},
    {"pulse_width", LUM_PICTURE_PULSE_WIDTH},
    {NULL, 0}};
static const struct option_word keeps[] = {{"keep", 0}, {"drop", 1}, {NULL, 0}};
static const struct option_word packets[] = {
    {"lines", 0}, {"all", 1}, {NULL, 0}};
static const struct option_word eyes[] = {{"blue", 1u << LUM_EYE_BLUE},
                                          {"green", 1u << LUM_EYE_GREEN},
                                          {"both", 3},
                                          {NULL, 0}};
static const struct option_word edges[] = {{"rising", LUM_EDGES_RISING},
                                           {"falling", LUM_EDGES_FALLING},
                                           {"both", LUM_EDGES_BOTH},
                                           {NULL, 0}};

static bool take_output(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    if (o->output_count == OUTPUTS_MAX) {
        (void)lum_error_set(why, "more than 16 outputs");
        return false;
    }
    o->outputs[o->output_count++].name = text;
    return true;
}

#define SENSOR_ALLOWED "an address such as 10.42.0.37, or 10.42.0.37%eth1"

#define INTO(field)       OPTION_INTO(struct options, field)
#define HAS(field)        .has = offsetof(struct options, field)
#define FLAG(field)       .kind = OPTION_FLAG, INTO(field)
#define TEXT(field)       .kind = OPTION_TEXT, INTO(field)
#define CALL(called)      .kind = OPTION_CALL, .call = (called)
#define WORD(list, field) .kind = OPTION_WORD, INTO(field), .words = (list)

static const struct option_spec specs[] = {
    {"output", .letter = 'o', CALL(take_output)},
    {"quiet", .letter = 'q', FLAG(quiet)},
    {"format", WORD(formats, format)},
    {"rotate", CALL(values_take_limit), INTO(files.rotation),
     .allowed = "a size of 10kB or more, such as 100MB or 1GB, or a time of 1s "
                "or more, such as 60s or 10min"},
    {"keep", CALL(values_take_limit), INTO(files.keep),
     .allowed =
         "a size of 10kB or more, such as 50GB, or a time of 1s or more, "
         "such as 2h or 7d"},
    {"ascii", FLAG(cloud.ascii)},
    {"comments", FLAG(cloud.comments)},
    {"columns", CALL(values_take_columns), INTO(cloud)},
    {"preset", CALL(values_take_preset), INTO(cloud.preset)},
    {"check-preset", CALL(values_take_preset), INTO(instead.check_preset)},
    {"voxel", .kind = OPTION_REAL, INTO(cloud.voxel), .low = LUM_MAP_VOXEL_MIN,
     .high = LUM_MAP_VOXEL_MAX},
    {"organized", FLAG(cloud.organized)},
    {"colour", WORD(colours, cloud.picture.colour),
     HAS(cloud.picture.has_colour)},
    {"size", CALL(values_take_size), INTO(cloud.picture),
     .allowed = "WIDTHxHEIGHT in pixels, each from 640 to 8000, such as "
                "3200x2400"},
    {"mcap", CALL(values_take_mcap), INTO(mcap.contents),
     .allowed = "frames, lines or packets, or packets with one of the others, "
                "such as frames,packets"},
    {"frame-id", CALL(values_take_frame_id), INTO(mcap.frame_id),
     .allowed = "a name of 1 to 200 bytes, such as luminar"},
    {"lines", .kind = OPTION_WHOLE, INTO(mcap.lines), .min = 1,
     .max = LUM_MCAP_LINES_MAX},
    {"compression", WORD(compressions, mcap.is_plain),
     HAS(mcap.has_compression)},
    {"time", WORD(clocks, points.time), HAS(points.has_time)},
    {"json", FLAG(json)},
    {"infer", FLAG(instead.infer)},
    {"laser", FLAG(live.laser)},
    {"guard", FLAG(live.guards)},
    {"interface", TEXT(live.interface), .allowed = "the name of an interface"},
    {"threads", .kind = OPTION_WHOLE, INTO(points.threads), .min = 1,
     .max = ROW_THREADS_MAX},
    {"buffer", .kind = OPTION_SIZE, INTO(live.buffer), .low = RING_BYTES_MIN,
     .high = 64e9, .allowed = "a size from 128KiB to 64GB, such as 256MB"},
    {"receive-buffer", .kind = OPTION_SIZE, INTO(live.receive_buffer),
     .low = 65536, .high = 1e9,
     .allowed = "a size from 64KiB to 1GB, such as 256MiB"},
    {"sensor", TEXT(sensor.text), HAS(sensor.is_chosen),
     .allowed = SENSOR_ALLOWED ", or the name of a rig's sensor"},
    {"port", .kind = OPTION_WHOLE, INTO(sensor.port), .min = 1,
     .max = UINT16_MAX},
    {"eye", WORD(eyes, choice.eyes)},
    {"edge", WORD(edges, choice.points.edges)},
    {"return", CALL(values_take_return), INTO(choice.points),
     .allowed = "all, first, last, strongest or a number from 1"},
    {"frames", CALL(values_take_frames), INTO(choice),
     .allowed = "FIRST:LAST, numbers from 1 such as 10:20 or 10:, or whole:N"},
    {"range", CALL(values_take_range), INTO(choice.points),
     .allowed = "MIN:MAX in metres, such as 2:80"},
    {"box", CALL(values_take_box), INTO(choice.points),
     .allowed = "XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX in metres, such as "
                "0:50,-10:10,:4"},
    {"incomplete", WORD(keeps, choice.drop_incomplete)},
    {"packets", WORD(packets, choice.all_packets), HAS(choice.has_packets)},
    {"duration", CALL(values_take_duration), INTO(choice.duration_ns),
     .allowed = "a number of seconds above 0"},
    {"calibration", TEXT(config.calibration)},
    {"profile", TEXT(config.profile)},
    {"rig", TEXT(config.rig), .allowed = "the name of a file of a rig"},
    {"set", CALL(set_keys_add), INTO(config.set), .allowed = SET_KEYS_ALLOWED},
    {"smooth", CALL(values_take_smooth), INTO(points),
     .allowed = "0 for off, an odd number of pixels up to 63, such as 31, or "
                "WINDOW:ORDER, the order from 0 to 5 and below the window, "
                "such as 31:2"},
    {"poses", TEXT(points.motion.poses),
     .allowed = "the name of a file of poses"},
    {"pose-times", TEXT(points.motion.times),
     .allowed = "the name of a file with a time a line"},
    {"to", WORD(places, points.motion.to), HAS(points.motion.has_to)},
    OPTION_HELP,
    OPTION_VERSION("lumdump"),
};

/* --- Formats and sources --- */

static bool find_format(const struct options *o, struct output_options *output)
{
    const bool is_told = options_find_format(output->name, &output->format);
    if (o->format != FORMAT_BY_NAME && (!is_told || o->output_count == 1)) {
        output->is_folder = o->format == FORMAT_ROSBAG2;
        output->format = output->is_folder ? LUM_FORMAT_MCAP : o->format;
        return true;
    }
    if (is_told) {
        return true;
    }
    if (strcmp(output->name, "-") == 0) {
        return rules_refuse(
            "standard output has no ending that shows a format: give --format "
            "csv, ply, pcd, las, xyz, png, mcap, pcap or pcapng");
    }
    return rules_refuse(
        "'%s' has no ending that shows a format: use .csv .ply .pcd .las .xyz "
        ".png .mcap .pcap or .pcapng, or give --format",
        output->name);
}

static bool can_write(const struct output_options *output)
{
    if (output->format != (unsigned)LUM_FORMAT_PNG ||
        lum_picture_format() != NULL) {
        return true;
    }
    return rules_refuse(
        "'%s': this lumdump was built without cairo and draws no pictures; use "
        ".csv .ply .pcd .las .xyz .mcap .pcap or .pcapng",
        output->name);
}

static bool find_formats(struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (!find_format(o, &o->outputs[i]) || !can_write(&o->outputs[i])) {
            return false;
        }
    }
    return true;
}

static bool take_sources(int count, char **words, struct options *out)
{
    lum_error why = {""};
    if (count == 0) {
        return rules_refuse("no SOURCE: name captures, - for standard input, "
                            "or udp://ADDRESS; see lumdump --help");
    }
    out->source = words[0];
    out->is_live = count == 1 && source_url_is_sensor(out->source);
    if (out->is_live) {
        return source_url_parse(out->source, &out->live.address, &why) ||
               rules_refuse("%s", why.text);
    }
    if (sources_init(&out->sources, (const char *const *)words, (size_t)count,
                     &why) != 0) {
        return rules_refuse("%s", why.text);
    }
    out->source = out->sources.name;
    return true;
}

/* Of a rig it is a name, which the rig finds. */
static bool take_sensor(struct options *o)
{
    lum_error why = {""};
    if (!o->sensor.is_chosen || o->config.rig != NULL ||
        host_parse_sensor(o->sensor.text, &o->sensor.address,
                          o->sensor.interface, &why)) {
        return true;
    }
    return why.text[0] != '\0' ? rules_refuse("--sensor: %s", why.text)
                               : rules_refuse("--sensor: '%s' is not %s",
                                              o->sensor.text, SENSOR_ALLOWED);
}

static bool take_rig(struct options *o)
{
    lum_error why = {""};
    return rig_open(o, &o->rig, &why) == 0 || rules_refuse("%s", why.text);
}

/* --- What outputs say of them --- */

static void add_filter(struct options *o, const char *name, const char *text,
                       bool is_of_packets)
{
    struct filter *f = &o->filters.list[o->filters.count++];
    (void)snprintf(f->text, sizeof f->text, "--%s=%s", name, text);
    f->is_of_packets = is_of_packets;
}

/* --smooth 0 is as if it were not there. */
static bool is_off(const struct options *o, const char *name)
{
    return strcmp(name, "smooth") == 0 && o->points.smooth_window == 0;
}

/* A recording is cut by its end alone. */
static bool cuts_captures(const struct options *o, const char *name)
{
    return !o->is_live || strcmp(name, "duration") == 0;
}

static void note_filters(const struct option_result *given, struct options *o)
{
    static const struct {
        const char *name;
        bool is_of_packets;
    } filters[] = {{"sensor", true},  {"port", true},     {"eye", true},
                   {"edge", false},   {"return", false},  {"frames", true},
                   {"range", false},  {"box", false},     {"incomplete", true},
                   {"packets", true}, {"duration", true}, {"smooth", false},
                   {"time", false},   {"poses", false},   {"pose-times", false},
                   {"to", false},     {"voxel", false}};
    for (size_t i = 0; i < sizeof filters / sizeof filters[0]; i++) {
        for (size_t k = 0; k < sizeof specs / sizeof specs[0]; k++) {
            if (option_table_has(given, k) && !is_off(o, specs[k].name) &&
                strcmp(specs[k].name, filters[i].name) == 0) {
                add_filter(o, filters[i].name, given->text[k],
                           filters[i].is_of_packets &&
                               cuts_captures(o, filters[i].name));
            }
        }
    }
    if (!o->points.has_time && o->points.time == TIME_UTC) {
        add_filter(o, "time", "utc", false);
    }
}

/* --- Reading --- */

static void choose_live(struct options *o)
{
    if (o->live.receive_buffer == 0) {
        o->live.receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    }
    o->sensor.is_chosen = true;
    o->sensor.address = o->live.address.address;
}

enum option_end command_line_read(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumdump", "lumdump --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){.format = FORMAT_BY_NAME,
                            .points = {.motion = {.to = LUM_MOVE_TO_WORLD}},
                            .choice = {.eyes = 3,
                                       .frame_first = INT64_MIN,
                                       .frame_last = INT64_MAX}};
    lum_selection_default(&out->choice.points);
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    if (end != OPTIONS_READ) {
        return end;
    }
    if (!take_sources(result.count, argv + 1, out)) {
        return OPTIONS_REFUSED;
    }
    if (!take_sensor(out)) {
        return OPTIONS_REFUSED;
    }
    if (out->instead.check_preset != NULL) {
        return rules_allow_check(&table, &result) ? OPTIONS_READ
                                                  : OPTIONS_REFUSED;
    }
    if (out->instead.infer) {
        return rules_allow_infer(out, &table, &result) ? OPTIONS_READ
                                                       : OPTIONS_REFUSED;
    }
    if (!take_rig(out) || !find_formats(out)) {
        return OPTIONS_REFUSED;
    }
    rig_choose_time(out);
    if (!rules_allow(out)) {
        return OPTIONS_REFUSED;
    }
    if (out->is_live) {
        choose_live(out);
    }
    note_filters(&result, out);
    return OPTIONS_READ;
}

void command_line_free(struct options *options)
{
    rig_free(options->rig);
    sources_free(&options->sources);
}
