#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include "../common/host.h"

#include "help.h"
#include "lum/version.h"
#include "picture.h"
#include "values.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

enum {
    OPT_FORMAT = 256,
    OPT_ROTATE,
    OPT_ASCII,
    OPT_TIME,
    OPT_JSON,
    OPT_LASER,
    OPT_INTERFACE,
    OPT_BUFFER,
    OPT_SENSOR,
    OPT_EYE,
    OPT_EDGE,
    OPT_RETURN,
    OPT_FRAMES,
    OPT_RANGE,
    OPT_BOX,
    OPT_INCOMPLETE,
    OPT_PACKETS,
    OPT_DURATION,
    OPT_CALIBRATION,
    OPT_PROFILE,
    OPT_SMOOTH,
    OPT_HELP,
    OPT_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"format", required_argument, NULL, OPT_FORMAT},
    {"rotate", required_argument, NULL, OPT_ROTATE},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"time", required_argument, NULL, OPT_TIME},
    {"json", no_argument, NULL, OPT_JSON},
    {"laser", no_argument, NULL, OPT_LASER},
    {"interface", required_argument, NULL, OPT_INTERFACE},
    {"buffer", required_argument, NULL, OPT_BUFFER},
    {"sensor", required_argument, NULL, OPT_SENSOR},
    {"eye", required_argument, NULL, OPT_EYE},
    {"edge", required_argument, NULL, OPT_EDGE},
    {"return", required_argument, NULL, OPT_RETURN},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"range", required_argument, NULL, OPT_RANGE},
    {"box", required_argument, NULL, OPT_BOX},
    {"incomplete", required_argument, NULL, OPT_INCOMPLETE},
    {"packets", required_argument, NULL, OPT_PACKETS},
    {"duration", required_argument, NULL, OPT_DURATION},
    {"calibration", required_argument, NULL, OPT_CALIBRATION},
    {"profile", required_argument, NULL, OPT_PROFILE},
    {"smooth", required_argument, NULL, OPT_SMOOTH},
    {"help", no_argument, NULL, OPT_HELP},
    {"version", no_argument, NULL, OPT_VERSION},
    {NULL, 0, NULL, 0},
};

static const struct word formats[] = {
    {"csv", LUM_FORMAT_CSV}, {"ply", LUM_FORMAT_PLY},
    {"pcd", LUM_FORMAT_PCD}, {"las", LUM_FORMAT_LAS},
    {"xyz", LUM_FORMAT_XYZ}, {"png", LUM_FORMAT_PNG},
    {"pcap", FORMAT_PCAP},   {NULL, 0},
};
static const struct word clocks[] = {{"sensor", TIME_SENSOR},
                                     {"utc", TIME_UTC},
                                     {"arrival", TIME_ARRIVAL},
                                     {NULL, 0}};
static const struct word keeps[] = {{"keep", 0}, {"drop", 1}, {NULL, 0}};
static const struct word packets[] = {{"lines", 0}, {"all", 1}, {NULL, 0}};
static const struct word eyes[] = {{"blue", 1u << LUM_EYE_BLUE},
                                   {"green", 1u << LUM_EYE_GREEN},
                                   {"both", 3},
                                   {NULL, 0}};
static const struct word edges[] = {{"rising", LUM_EDGES_RISING},
                                    {"falling", LUM_EDGES_FALLING},
                                    {"both", LUM_EDGES_BOTH},
                                    {NULL, 0}};

static bool refuse(const char *why)
{
    (void)fprintf(stderr, "lumdump: %s\n", why);
    return false;
}

/* getopt_long() takes any beginning of a name; a laser is not to be switched on
 * by a slip. The word that was taken stands before optind, or before its value.
 */
static bool is_spelt_out(char **argv, const struct option *option)
{
    const char *word = argv[optind - 1];
    if (option->has_arg == required_argument && optarg == word) {
        word = argv[optind - 2];
    }
    const char *name = word + strspn(word, "-");
    const size_t len = strcspn(name, "=");
    if (len == strlen(option->name)) {
        return true;
    }
    (void)fprintf(stderr,
                  "lumdump: --%.*s: no such option; did you mean --%s? See "
                  "lumdump --help\n",
                  (int)len, name, option->name);
    return false;
}

static bool add_output(const char *name, struct options *out)
{
    if (out->output_count == OUTPUTS_MAX) {
        return refuse("-o: more than 16 outputs");
    }
    out->outputs[out->output_count++].name = name;
    return true;
}

static bool set_choice(int option, const char *text, struct options *out)
{
    unsigned value = 0;
    switch (option) {
    case OPT_FORMAT:
        out->has_format =
            values_choose("--format", formats, text, &out->format);
        return out->has_format;
    case OPT_TIME:
        return values_choose("--time", clocks, text, &value) &&
               ((out->time = (enum time_base)value), true);
    case OPT_INCOMPLETE:
        return values_choose("--incomplete", keeps, text, &value) &&
               ((out->drop_incomplete = value != 0), true);
    case OPT_PACKETS:
        out->has_packets = true;
        return values_choose("--packets", packets, text, &value) &&
               ((out->all_packets = value != 0), true);
    case OPT_EYE:
        return values_choose("--eye", eyes, text, &out->eyes);
    default:
        return values_choose("--edge", edges, text, &value) &&
               ((out->selection.edges = (lum_edges)value), true);
    }
}

static bool set_value(int option, const char *text, struct options *out)
{
    switch (option) {
    case OPT_FRAMES:
        return values_parse_frames(text, out);
    case OPT_RANGE:
        return values_parse_range(text, &out->selection);
    case OPT_BOX:
        return values_parse_box(text, &out->selection);
    case OPT_SENSOR:
        return values_parse_sensor(text, out);
    case OPT_RETURN:
        return values_parse_return(text, &out->selection);
    case OPT_ROTATE:
        return values_parse_rotation(text, &out->rotation);
    case OPT_BUFFER:
        return values_parse_buffer(text, &out->buffer);
    case OPT_DURATION:
        return values_parse_duration(text, out);
    case OPT_SMOOTH:
        return values_parse_smooth(text, out);
    default:
        return set_choice(option, text, out);
    }
}

/* Options that are on, or hold a text as it is. False: it is another. */
static bool set_plain(int option, const char *text, struct options *out)
{
    switch (option) {
    case 'q':
        out->quiet = true;
        return true;
    case OPT_ASCII:
        out->ascii = true;
        return true;
    case OPT_JSON:
        out->json = true;
        return true;
    case OPT_LASER:
        out->laser = true;
        return true;
    case OPT_INTERFACE:
        out->interface = text;
        return true;
    case OPT_CALIBRATION:
        out->calibration = text;
        return true;
    case OPT_PROFILE:
        out->profile = text;
        return true;
    default:
        return false;
    }
}

static bool has_ending(const char *name, const char *ending)
{
    const size_t n = strlen(name);
    const size_t m = strlen(ending);
    return n > m && strcmp(name + n - m, ending) == 0;
}

/* The format that a name's ending tells. */
static bool tells_format(const char *name, unsigned *out)
{
    lum_format format = LUM_FORMAT_CSV;
    if (has_ending(name, ".pcap")) {
        *out = FORMAT_PCAP;
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
        output->format = o->format;
        return true;
    }
    if (is_told) {
        return true;
    }
    if (strcmp(output->name, "-") == 0) {
        return refuse("standard output has no ending to tell a format by: say "
                      "--format csv, ply, pcd, las, xyz, png or pcap");
    }
    (void)fprintf(stderr,
                  "lumdump: '%s' tells no format by its ending: use .csv .ply "
                  ".pcd .las .xyz .png or .pcap, or say --format\n",
                  output->name);
    return false;
}

static bool can_write(const struct output_options *output)
{
    if (output->format != (unsigned)LUM_FORMAT_PNG ||
        picture_format() != NULL) {
        return true;
    }
    (void)fprintf(stderr,
                  "lumdump: '%s': this lumdump was built without libpng and "
                  "draws no pictures; use .csv .ply .pcd .las .xyz or .pcap\n",
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

static bool take_captures(const char *const *paths, size_t count,
                          struct options *out)
{
    lum_error why = {""};
    for (size_t i = 0; i < count; i++) {
        if (count > 1 && strncmp(paths[i], "udp://", 6) == 0) {
            (void)fprintf(stderr,
                          "lumdump: %s: a sensor is the only source of its "
                          "run; several sources are captures\n",
                          paths[i]);
            return false;
        }
        if (!values_is_no_url(paths[i])) {
            return false;
        }
    }
    const int made = sources_init(&out->sources, paths, count, &why);
    out->source = out->sources.name;
    return made == 0 || refuse(why.text);
}

static bool take_sources(int argc, char **argv, struct options *out)
{
    if (optind == argc) {
        return refuse("no SOURCE: name captures, - for standard input, or "
                      "udp://ADDRESS; see lumdump --help");
    }
    out->source = argv[optind];
    out->is_live = optind + 1 == argc && strncmp(out->source, "udp://", 6) == 0;
    return out->is_live ? values_parse_url(out->source, &out->address)
                        : take_captures((const char *const *)argv + optind,
                                        (size_t)(argc - optind), out);
}

static bool has_text_formats(const struct options *o)
{
    for (size_t i = 0; i < o->output_count; i++) {
        if (o->outputs[i].format == LUM_FORMAT_PLY ||
            o->outputs[i].format == LUM_FORMAT_PCD) {
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

static bool goes_with_source(const struct options *o)
{
    if (!o->is_live && o->laser) {
        return refuse("--laser goes with a sensor, udp://ADDRESS: a capture "
                      "has no laser");
    }
    if (!o->is_live && (o->interface != NULL || o->buffer != 0)) {
        return refuse("--interface and --buffer go with a sensor, "
                      "udp://ADDRESS");
    }
    lum_error why = {""};
    if (o->interface != NULL && !host_has_interface(o->interface, &why)) {
        (void)fprintf(stderr, "lumdump: --interface: %s\n", why.text);
        return false;
    }
    if (o->is_live && o->has_sensor) {
        return refuse("--sensor chooses among the sensors of a capture: "
                      "udp://ADDRESS names the one already");
    }
    return true;
}

static bool is_consistent(const struct options *o)
{
    if (o->ascii && !has_text_formats(o)) {
        return refuse("--ascii goes with ply and pcd output only");
    }
    if (o->json && has_standard_output(o)) {
        return refuse("--json and -o - would both write to standard output: "
                      "name a file");
    }
    return goes_with_source(o);
}

/* Whatever is no option of the other kinds. */
static enum parsed set_option(int option, struct options *out)
{
    if (option == OPT_HELP) {
        (void)fputs(help_text, stdout);
        return PARSED_DONE;
    }
    if (option == OPT_VERSION) {
        (void)puts("lumdump " LUM_VERSION);
        return PARSED_DONE;
    }
    if (option == '?') {
        (void)refuse("see lumdump --help");
        return PARSED_BAD;
    }
    if (option == 'o') {
        return add_output(optarg, out) ? PARSED_RUN : PARSED_BAD;
    }
    return set_plain(option, optarg, out) || set_value(option, optarg, out)
               ? PARSED_RUN
               : PARSED_BAD;
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    int option = 0;
    int which = -1;
    *out = (struct options){
        .eyes = 3, .frame_first = INT64_MIN, .frame_last = INT64_MAX};
    lum_selection_default(&out->selection);
    while ((option = getopt_long(argc, argv, "o:q", long_options, &which)) !=
           -1) {
        if (which >= 0 && option != '?' &&
            !is_spelt_out(argv, &long_options[which])) {
            return PARSED_BAD;
        }
        which = -1;
        const enum parsed parsed = set_option(option, out);
        if (parsed != PARSED_RUN) {
            return parsed;
        }
    }
    return take_sources(argc, argv, out) && find_formats(out) &&
                   is_consistent(out)
               ? PARSED_RUN
               : PARSED_BAD;
}

void options_free(struct options *options)
{
    sources_free(&options->sources);
}
