#include "options.h"

#include "../common/host.h"
#include "../common/option_table.h"
#include "../common/source_url.h"

#include "crew.h"
#include "help.h"
#include "lum/net/socket.h"
#include "lum/version.h"
#include "picture.h"
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

static bool refuse(const char *why)
{
    (void)fprintf(stderr, "lumdump: %s\n", why);
    return false;
}

static void show_help(void)
{
    (void)fputs(help_output, stdout);
    (void)fputs(help_rest, stdout);
}

static void show_version(void)
{
    (void)puts("lumdump " LUM_VERSION);
}

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

#define INTO(field)       OPTION_INTO(struct options, field)
#define HAS(field)        .has = offsetof(struct options, field)
#define FLAG(field)       .kind = OPTION_FLAG, INTO(field)
#define TEXT(field)       .kind = OPTION_TEXT, INTO(field)
#define CALL(called)      .kind = OPTION_CALL, .call = (called)
#define WORD(list, field) .kind = OPTION_WORD, INTO(field), .words = (list)

static const struct option_spec specs[] = {
    {"output", .letter = 'o', CALL(take_output)},
    {"quiet", .letter = 'q', FLAG(quiet)},
    {"format", WORD(formats, format), HAS(has_format)},
    {"rotate", CALL(values_take_rotation),
     .allowed = "a size of 10kB or more, such as 100MB or 1GB, or a time of 1s "
                "or more, such as 60s or 10min"},
    {"keep", CALL(values_take_keep),
     .allowed =
         "a size of 10kB or more, such as 50GB, or a time of 1s or more, "
         "such as 2h or 7d"},
    {"ascii", FLAG(ascii)},
    {"comments", FLAG(comments)},
    {"columns", CALL(values_take_columns)},
    {"preset", CALL(values_take_preset)},
    {"check-preset", CALL(values_take_check_preset)},
    {"organized", FLAG(organized)},
    {"mcap", CALL(values_take_mcap),
     .allowed = "frames, lines or packets, or packets with one of the others, "
                "such as frames,packets"},
    {"frame-id", CALL(values_take_frame_id),
     .allowed = "a name of 1 to 200 bytes, such as luminar"},
    {"lines", .kind = OPTION_WHOLE, INTO(lines), .min = 1,
     .max = LUM_MCAP_LINES_MAX},
    {"compression", WORD(compressions, is_plain), HAS(has_compression)},
    {"time", WORD(clocks, time)},
    {"json", FLAG(json)},
    {"infer", FLAG(infer)},
    {"laser", FLAG(laser)},
    {"guard", FLAG(guards)},
    {"interface", TEXT(interface), .allowed = "the name of an interface"},
    {"threads", .kind = OPTION_WHOLE, INTO(threads), .min = 1, .max = CREW_MAX},
    {"buffer", CALL(values_take_buffer),
     .allowed = "a size from 128KiB to 64GB, such as 256MB"},
    {"receive-buffer", CALL(values_take_receive_buffer),
     .allowed = "a size from 64KiB to 1GB, such as 256MiB"},
    {"sensor", CALL(values_take_sensor), HAS(has_sensor),
     .allowed = "an address such as 10.42.0.37, or 10.42.0.37%eth1"},
    {"port", .kind = OPTION_WHOLE, INTO(port), .min = 1, .max = UINT16_MAX},
    {"eye", WORD(eyes, eyes)},
    {"edge", WORD(edges, selection.edges)},
    {"return", CALL(values_take_return),
     .allowed = "all, first, last, strongest or a number from 1"},
    {"frames", CALL(values_take_frames),
     .allowed = "FIRST:LAST, such as 10:20 or 10:, or whole:N"},
    {"range", CALL(values_take_range),
     .allowed = "MIN:MAX in metres, such as 2:80"},
    {"box", CALL(values_take_box),
     .allowed = "XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX in metres, such as "
                "0:50,-10:10,:4"},
    {"incomplete", WORD(keeps, drop_incomplete)},
    {"packets", WORD(packets, all_packets), HAS(has_packets)},
    {"duration", CALL(values_take_duration),
     .allowed = "a number of seconds above 0"},
    {"calibration", TEXT(calibration)},
    {"profile", TEXT(profile)},
    {"set", CALL(values_take_set), .allowed = SET_KEYS_ALLOWED},
    {"smooth", CALL(values_take_smooth),
     .allowed = "0 for off, an odd number of pixels up to 63, such as 31, or "
                "WINDOW:ORDER, the order from 0 to 5 and below the window, "
                "such as 31:2"},
    {"help", .letter = 'h', .kind = OPTION_SHOW, .show = show_help},
    {"version", .kind = OPTION_SHOW, .show = show_version},
};

/* --- Formats and sources --- */

static bool has_ending(const char *name, const char *ending)
{
    const size_t n = strlen(name);
    const size_t m = strlen(ending);
    return n > m && strcmp(name + n - m, ending) == 0;
}

/* The format by a name's ending. */
static bool tells_format(const char *name, unsigned *out)
{
    lum_format format = LUM_FORMAT_CSV;
    if (has_ending(name, ".pcap") || has_ending(name, ".pcapng")) {
        *out = has_ending(name, ".pcap") ? FORMAT_PCAP : FORMAT_PCAPNG;
        return true;
    }
    if (lum_format_from_name(name, &format) != 0) {
        return false;
    }
    *out = format;
    return true;
}

static bool find_format(const struct options *o, struct output_options *output)
{
    const bool is_told = tells_format(output->name, &output->format);
    if (o->has_format && (!is_told || o->output_count == 1)) {
        output->is_folder = o->format == FORMAT_ROSBAG2;
        output->format = output->is_folder ? LUM_FORMAT_MCAP : o->format;
        return true;
    }
    if (is_told) {
        return true;
    }
    if (strcmp(output->name, "-") == 0) {
        return refuse("standard output has no ending that shows a format: give "
                      "--format csv, ply, pcd, las, xyz, png, mcap, pcap or "
                      "pcapng");
    }
    (void)fprintf(stderr,
                  "lumdump: '%s' has no ending that shows a format: use .csv "
                  ".ply .pcd .las .xyz .png .mcap .pcap or .pcapng, or give "
                  "--format\n",
                  output->name);
    return false;
}

static bool can_write(const struct output_options *output)
{
    if (output->format != (unsigned)LUM_FORMAT_PNG ||
        picture_format() != NULL) {
        return true;
    }
    (void)fprintf(
        stderr,
        "lumdump: '%s': this lumdump was built without cairo and "
        "draws no pictures; use .csv .ply .pcd .las .xyz .mcap .pcap or "
        ".pcapng\n",
        output->name);
    return false;
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
        return refuse("no SOURCE: name captures, - for standard input, or "
                      "udp://ADDRESS; see lumdump --help");
    }
    out->source = words[0];
    out->is_live = count == 1 && source_url_is_sensor(out->source);
    if (out->is_live) {
        return source_url_parse(out->source, &out->address, &why) ||
               refuse(why.text);
    }
    if (sources_init(&out->sources, (const char *const *)words, (size_t)count,
                     &why) != 0) {
        return refuse(why.text);
    }
    out->source = out->sources.name;
    return true;
}

/* --- What goes together --- */

static bool has_either(const struct options *o, unsigned one, unsigned other)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (o->outputs[i].format == one || o->outputs[i].format == other) {
            return true;
        }
    }
    return o->output_count == 0;
}

static bool has_standard_output(const struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (strcmp(o->outputs[i].name, "-") == 0) {
            return true;
        }
    }
    return false;
}

/* Every output does, and there is one. */
static bool makes_points(const struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (options_takes_packets(o, i)) {
            return false;
        }
    }
    return o->output_count > 0;
}

static bool is_rotation(const struct rotation *r)
{
    return r->bytes != 0 || r->ns != 0;
}

/* What it would keep is no more than is never removed. */
static bool keep_is_small(const struct options *o)
{
    const struct rotation *r = &o->rotation;
    const struct rotation *k = &o->keep;
    return (r->bytes != 0 && k->bytes != 0 && k->bytes < 2u * r->bytes) ||
           (r->ns != 0 && k->ns != 0 && k->ns < r->ns);
}

static bool keep_goes_with_rotation(const struct options *o)
{
    if (!is_rotation(&o->keep)) {
        return true;
    }
    if (!is_rotation(&o->rotation)) {
        return refuse("--keep removes the oldest files of --rotate: give that "
                      "too, such as --rotate 10min");
    }
    for (size_t i = 0; i < o->output_count; i++) {
        if (o->outputs[i].is_folder) {
            return refuse("--keep does not go with rosbag2, whose folder is "
                          "new in each run: record .mcap files");
        }
    }
    return !keep_is_small(o) ||
           refuse("--keep has to be at least the time of a file of --rotate, "
                  "or twice its size: the newest whole file is never removed");
}

static bool laser_goes_with_source(const struct options *o)
{
    if (o->laser && o->guards) {
        return refuse("--guard does not go with --laser, which does the same "
                      "and switches the laser on");
    }
    if (!o->is_live && (o->laser || o->guards)) {
        return refuse(
            "--laser and --guard go with a sensor, udp://ADDRESS: a capture "
            "has no laser");
    }
    return true;
}

static bool goes_with_source(const struct options *o)
{
    if (!o->is_live &&
        (o->interface != NULL || o->buffer != 0 || o->receive_buffer != 0)) {
        return refuse("--interface, --buffer and --receive-buffer go with a "
                      "sensor, udp://ADDRESS");
    }
    lum_error why = {""};
    if (o->interface != NULL && !host_has_interface(o->interface, &why)) {
        (void)fprintf(stderr, "lumdump: --interface: %s\n", why.text);
        return false;
    }
    if (o->is_live && o->threads != 0) {
        return refuse("--threads goes with captures: of a sensor each output "
                      "has a thread of its own");
    }
    if (o->is_live && o->port != 0) {
        return refuse("--port is of the sensors in a capture: for a sensor "
                      "name it in udp://ADDRESS:PORT");
    }
    if (!o->is_live && o->whole != 0 && !makes_points(o)) {
        return refuse("--frames whole:N goes with an output of points: a frame "
                      "is known to be whole only at its end, too late to cut "
                      "a capture; choose by numbers, such as 2:2");
    }
    if (o->is_live && o->has_sensor) {
        return refuse("--sensor chooses among the sensors of a capture: "
                      "udp://ADDRESS already names one");
    }
    return laser_goes_with_source(o);
}

static bool has_messages(const struct options *o)
{
    return o->output_count > 0 &&
           has_either(o, LUM_FORMAT_MCAP, LUM_FORMAT_MCAP);
}

static bool has_columns(const struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (!options_is_capture(o->outputs[i].format) &&
            lum_format_has_columns((lum_format)o->outputs[i].format)) {
            return true;
        }
    }
    return false;
}

static bool can_preset(const struct options *o)
{
    bool is_used = false;
    for (size_t i = 0; i < o->output_count; i++) {
        is_used = is_used || options_has_preset(o, i);
    }
    if (o->columns != NULL) {
        return refuse("--preset and --columns both choose the columns: give "
                      "one of them");
    }
    return is_used ||
           refuse("--preset goes with csv, ply, pcd and mcap output only");
}

static bool can_choose_messages(const struct options *o)
{
    if (!has_messages(o)) {
        return refuse("--mcap goes with mcap output only");
    }
    return o->preset == NULL || (o->mcap & LUM_MCAP_OF_LINES) == 0 ||
           refuse("--mcap lines: the fields of --preset are of whole frames");
}

static bool can_organize(const struct options *o)
{
    if (o->output_count == 0 ||
        !has_either(o, LUM_FORMAT_PCD, LUM_FORMAT_PCD)) {
        return refuse("--organized goes with pcd output only");
    }
    if (o->selection.returns == LUM_RETURNS_ALL) {
        return refuse("--organized has room for one point of a pixel: choose "
                      "it by --return first, last, strongest or a number");
    }
    return o->selection.edges != LUM_EDGES_BOTH ||
           refuse("--organized has room for one point of a pixel: say --edge "
                  "rising or falling, not both");
}

static bool can_compress(const struct options *o)
{
    if (!has_messages(o)) {
        return refuse("--compression goes with mcap output only");
    }
    return o->is_plain || lum_mcap_can_compress() ||
           refuse("--compression zstd: this lumdump was built without a "
                  "libzstd that compresses; leave it out, or say none");
}

static bool goes_with_messages(const struct options *o)
{
    return (!o->has_compression || can_compress(o)) &&
           (o->mcap == 0 || can_choose_messages(o)) &&
           (o->frame_id == NULL || has_messages(o) ||
            refuse("--frame-id goes with mcap output only")) &&
           (o->lines == 0 || has_messages(o) ||
            refuse("--lines goes with mcap output only"));
}

static bool is_consistent(const struct options *o)
{
    if (o->columns != NULL && !has_columns(o)) {
        return refuse("--columns goes with csv, ply and pcd output only");
    }
    if (o->preset != NULL && !can_preset(o)) {
        return false;
    }
    if (o->organized && !can_organize(o)) {
        return false;
    }
    if (o->ascii && !has_either(o, LUM_FORMAT_PLY, LUM_FORMAT_PCD)) {
        return refuse("--ascii goes with ply and pcd output only");
    }
    if (!goes_with_messages(o)) {
        return false;
    }
    if (o->comments && (o->output_count == 0 ||
                        !has_either(o, LUM_FORMAT_CSV, LUM_FORMAT_XYZ))) {
        return refuse("--comments goes with csv and xyz output only: ply, pcd, "
                      "las and pcapng always have them");
    }
    if (o->json && has_standard_output(o)) {
        return refuse("--json and -o - would both write to standard output: "
                      "name a file");
    }
    return keep_goes_with_rotation(o) && goes_with_source(o);
}

/* --- Finding a layout --- */

static bool goes_with_infer(const char *name)
{
    static const char *const names[] = {"infer", "output", "sensor",
                                        "port",  "json",   "quiet"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(name, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

static bool has_others(const struct option_result *given)
{
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; i++) {
        if (option_table_has(given, i) && !goes_with_infer(specs[i].name)) {
            (void)fprintf(stderr,
                          "lumdump: --%s does not go with --infer, which looks "
                          "at packets and makes no points: it goes with "
                          "--output, --sensor, --port, --json and --quiet\n",
                          specs[i].name);
            return true;
        }
    }
    return false;
}

static bool can_write_profile(const struct options *o)
{
    unsigned format = 0;
    if (o->output_count > 1) {
        return refuse("--infer writes one profile: name one output");
    }
    if (o->output_count == 1 && tells_format(o->outputs[0].name, &format)) {
        (void)fprintf(stderr,
                      "lumdump: '%s': --infer writes a profile, which is YAML: "
                      "use a name such as profile.yaml\n",
                      o->outputs[0].name);
        return false;
    }
    return !o->json || !has_standard_output(o) ||
           refuse("--json and -o - would both write to standard output: name a "
                  "file");
}

static bool can_infer(const struct options *o,
                      const struct option_result *given)
{
    if (o->is_live) {
        (void)fprintf(stderr,
                      "lumdump: --infer looks at a capture: record one by "
                      "lumdump %s --laser --duration 3 -o look.pcap, then use "
                      "lumdump look.pcap --infer\n",
                      o->source);
        return false;
    }
    return !has_others(given) && can_write_profile(o);
}

/* --- Checking a cloud --- */

static bool can_check(const struct option_result *given)
{
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; i++) {
        if (option_table_has(given, i) &&
            strcmp(specs[i].name, "check-preset") != 0) {
            (void)fprintf(stderr,
                          "lumdump: --%s does not go with --check-preset, "
                          "which only looks at the fields of a cloud\n",
                          specs[i].name);
            return false;
        }
    }
    return given->count == 1 ||
           refuse("--check-preset looks at one cloud: name one FILE");
}

/* --- What is known of them --- */

bool options_is_capture(unsigned format)
{
    return format == FORMAT_PCAP || format == FORMAT_PCAPNG;
}

static bool is_mcap(const struct options *o, size_t i)
{
    return o->outputs[i].format == (unsigned)LUM_FORMAT_MCAP;
}

bool options_takes_packets(const struct options *options, size_t i)
{
    return options_is_capture(options->outputs[i].format) ||
           (is_mcap(options, i) &&
            (options->mcap & LUM_MCAP_OF_DATAGRAMS) != 0);
}

bool options_is_recording(const struct options *options, size_t i)
{
    return options_is_capture(options->outputs[i].format) ||
           (is_mcap(options, i) && options->mcap == LUM_MCAP_OF_DATAGRAMS);
}

bool options_is_organized(const struct options *options, size_t i)
{
    return options->organized &&
           options->outputs[i].format == (unsigned)LUM_FORMAT_PCD;
}

bool options_has_preset(const struct options *options, size_t i)
{
    const unsigned format = options->outputs[i].format;
    return options->preset != NULL && !options_is_recording(options, i) &&
           lum_format_has_presets((lum_format)format);
}

bool options_has_messages(const struct options *options, size_t i)
{
    return !options_is_recording(options, i) &&
           lum_format_has_frames((lum_format)options->outputs[i].format);
}

bool options_writes_messages(const struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (options_has_messages(o, i)) {
            return true;
        }
    }
    return false;
}

int options_pattern(const char *name)
{
    const char *p = strchr(name, '%');
    if (p == NULL) {
        return 0;
    }
    p++;
    p += strspn(p, "0123456789");
    return *p == 'd' && strchr(p, '%') == NULL ? 1 : -1;
}

bool options_rotates(const struct options *options, size_t i)
{
    const char *name = options->outputs[i].name;
    return !options_is_organized(options, i) &&
           (options->rotation.bytes != 0 || options->rotation.ns != 0) &&
           strcmp(name, "-") != 0 && options_pattern(name) == 0;
}

bool options_is_picture(const struct options *options, size_t i)
{
    return options->outputs[i].format == (unsigned)LUM_FORMAT_PNG &&
           options_pattern(options->outputs[i].name) == 0;
}

bool options_has_frames(const struct options *options)
{
    return options->frame_first != INT64_MIN ||
           options->frame_last != INT64_MAX || options->whole != 0;
}

bool options_draws_one(const struct options *options, size_t i)
{
    return options_is_picture(options, i) && !options_rotates(options, i) &&
           !options_has_frames(options);
}

bool options_takes_frames(const struct options *options, size_t i)
{
    const unsigned format = options->outputs[i].format;
    return options_is_organized(options, i) || options_is_picture(options, i) ||
           options_has_messages(options, i) || options_has_preset(options, i) ||
           (options->whole != 0 && !options_is_recording(options, i)) ||
           (options->has_times && !options_is_capture(format) &&
            lum_format_has_columns((lum_format)format));
}

static void add_filter(struct options *o, const char *name, const char *text,
                       bool is_of_packets)
{
    struct filter *f = &o->filters[o->filter_count++];
    (void)snprintf(f->text, sizeof f->text, "--%s=%s", name, text);
    f->is_of_packets = is_of_packets;
}

/* --smooth 0 is as if it were not there. */
static bool is_off(const struct options *o, const char *name)
{
    return strcmp(name, "smooth") == 0 && o->smooth_window == 0;
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
                   {"time", false}};
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
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumdump", "lumdump --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){
        .eyes = 3, .frame_first = INT64_MIN, .frame_last = INT64_MAX};
    lum_selection_default(&out->selection);
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    if (end != OPTIONS_READ) {
        return end == OPTIONS_SHOWN ? PARSED_DONE : PARSED_BAD;
    }
    if (!take_sources(result.count, argv + 1, out)) {
        return PARSED_BAD;
    }
    if (out->check_preset != NULL) {
        return can_check(&result) ? PARSED_RUN : PARSED_BAD;
    }
    if (out->infer) {
        return can_infer(out, &result) ? PARSED_RUN : PARSED_BAD;
    }
    if (!find_formats(out) || !is_consistent(out)) {
        return PARSED_BAD;
    }
    if (out->is_live && out->receive_buffer == 0) {
        out->receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    }
    if (out->is_live) {
        out->has_sensor = true;
        out->sensor = out->address.address;
    }
    note_filters(&result, out);
    return PARSED_RUN;
}

void options_free(struct options *options)
{
    sources_free(&options->sources);
}
