#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include "../common/number.h"
#include "lum/version.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "Usage: lumdump SOURCE [-o OUTPUT] [OPTION]...\n"
    "Turn a capture of a Luminar Model G2 into a point cloud, or sum it up.\n"
    "\n"
    "SOURCE is a pcap or pcapng file, or - for a capture on standard input.\n"
    "Without -o a summary is printed: sensors, packets, lines, frames, "
    "points,\n"
    "and what was lost, by cause.\n"
    "\n"
    "Output:\n"
    "  -o, --output FILE       .csv .ply .pcd .las .xyz .png .pcap, or - for\n"
    "                          standard output; %04d in the name stands for "
    "the\n"
    "                          frame number: one file a frame\n"
    "      --format FORMAT     csv, ply, pcd, las, xyz, png or pcap, whatever\n"
    "                          the name's ending\n"
    "      --ascii             text instead of binary (ply, pcd)\n"
    "      --time sensor|utc   timestamps: sensor clock (default), or the\n"
    "                          capture time of the line's first packet\n"
    "      --json              the summary as one JSON object\n"
    "  -q, --quiet             no summary, no progress, no warnings\n"
    "\n"
    "Selection:\n"
    "      --sensor ADDRESS    one of several sensors in the capture\n"
    "      --eye blue|green|both\n"
    "      --edge rising|falling|both         default: rising\n"
    "      --return all|first|last|strongest|N\n"
    "      --frames A:B        frame numbers, both included; A: or :B too\n"
    "      --range MIN:MAX     metres from the eye\n"
    "      --box XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX\n"
    "                          metres: x forward, y left, z up\n"
    "      --incomplete keep|drop  lines that lack angles or words\n"
    "      --duration SECONDS  only so much of the capture, from its start\n"
    "\n"
    "Interpretation:\n"
    "      --calibration FILE  YAML; default: the manual's typical values\n"
    "      --profile FILE      YAML; layout of data packets, where it differs\n"
    "\n"
    "      --help, --version\n"
    "\n"
    "Exit status: 0 done, 1 it failed, 2 bad arguments or configuration.\n"
    "\n"
    "Examples:\n"
    "  lumdump drive.pcap                      what is in it?\n"
    "  lumdump drive.pcap -o drive.ply         open it in CloudCompare\n"
    "  lumdump drive.pcap -o frame-%04d.pcd    one file a frame\n"
    "  lumdump drive.pcap --frames 1:1 -o look.png   a picture of one frame\n"
    "  lumdump drive.pcap -o - --format csv --return last --range 2:80\n"
    "  tcpdump -w - udp port 5517 | lumdump - -o drive.csv\n";

enum {
    OPT_FORMAT = 256,
    OPT_ASCII,
    OPT_TIME,
    OPT_JSON,
    OPT_SENSOR,
    OPT_EYE,
    OPT_EDGE,
    OPT_RETURN,
    OPT_FRAMES,
    OPT_RANGE,
    OPT_BOX,
    OPT_INCOMPLETE,
    OPT_DURATION,
    OPT_CALIBRATION,
    OPT_PROFILE,
    OPT_HELP,
    OPT_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"format", required_argument, NULL, OPT_FORMAT},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"time", required_argument, NULL, OPT_TIME},
    {"json", no_argument, NULL, OPT_JSON},
    {"sensor", required_argument, NULL, OPT_SENSOR},
    {"eye", required_argument, NULL, OPT_EYE},
    {"edge", required_argument, NULL, OPT_EDGE},
    {"return", required_argument, NULL, OPT_RETURN},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"range", required_argument, NULL, OPT_RANGE},
    {"box", required_argument, NULL, OPT_BOX},
    {"incomplete", required_argument, NULL, OPT_INCOMPLETE},
    {"duration", required_argument, NULL, OPT_DURATION},
    {"calibration", required_argument, NULL, OPT_CALIBRATION},
    {"profile", required_argument, NULL, OPT_PROFILE},
    {"help", no_argument, NULL, OPT_HELP},
    {"version", no_argument, NULL, OPT_VERSION},
    {NULL, 0, NULL, 0},
};

/* A word an option takes, and what it stands for. */
struct word {
    const char *text;
    unsigned value;
};

static const struct word formats[] = {
    {"csv", LUM_FORMAT_CSV}, {"ply", LUM_FORMAT_PLY},
    {"pcd", LUM_FORMAT_PCD}, {"las", LUM_FORMAT_LAS},
    {"xyz", LUM_FORMAT_XYZ}, {"png", LUM_FORMAT_PNG},
    {"pcap", FORMAT_PCAP},   {NULL, 0},
};
static const struct word times[] = {{"sensor", 0}, {"utc", 1}, {NULL, 0}};
static const struct word keeps[] = {{"keep", 0}, {"drop", 1}, {NULL, 0}};
static const struct word eyes[] = {{"blue", 1u << LUM_EYE_BLUE},
                                   {"green", 1u << LUM_EYE_GREEN},
                                   {"both", 3},
                                   {NULL, 0}};
static const struct word edges[] = {{"rising", LUM_EDGES_RISING},
                                    {"falling", LUM_EDGES_FALLING},
                                    {"both", LUM_EDGES_BOTH},
                                    {NULL, 0}};
static const struct word returns[] = {{"all", LUM_RETURNS_ALL},
                                      {"first", LUM_RETURNS_FIRST},
                                      {"last", LUM_RETURNS_LAST},
                                      {"strongest", LUM_RETURNS_STRONGEST},
                                      {NULL, 0}};

static bool look_up(const struct word *words, const char *text, unsigned *out)
{
    for (; words->text != NULL; words++) {
        if (strcmp(words->text, text) == 0) {
            *out = words->value;
            return true;
        }
    }
    return false;
}

static bool complain(const char *option, const char *text, const char *allowed)
{
    (void)fprintf(stderr, "lumdump: %s: '%s' is not %s\n", option, text,
                  allowed);
    return false;
}

static bool choose(const char *option, const struct word *words,
                   const char *text, unsigned *out)
{
    char allowed[128] = "one of";
    if (look_up(words, text, out)) {
        return true;
    }
    for (; words->text != NULL; words++) {
        const size_t len = strlen(allowed);
        (void)snprintf(allowed + len, sizeof allowed - len, " %s", words->text);
    }
    return complain(option, text, allowed);
}

static bool parse_return(const char *text, lum_selection *out)
{
    unsigned choice = 0;
    int64_t number = 0;
    if (look_up(returns, text, &choice)) {
        out->returns = (lum_return_choice)choice;
        return true;
    }
    if (number_parse_int(text, 1, UINT16_MAX, &number)) {
        out->returns = LUM_RETURNS_NUMBER;
        out->return_number = (uint16_t)number;
        return true;
    }
    return complain("--return", text,
                    "all, first, last, strongest or a number from 1");
}

/* Splits MIN:MAX in place; either may be empty. */
static bool split(char *text, char **min, char **max)
{
    char *colon = strchr(text, ':');
    if (colon == NULL || strchr(colon + 1, ':') != NULL) {
        return false;
    }
    *colon = '\0';
    *min = text;
    *max = colon + 1;
    return true;
}

static bool parse_limits(const char *text, float *min, float *max)
{
    char copy[128];
    char *low = NULL;
    char *high = NULL;
    double a = -INFINITY;
    double b = INFINITY;
    if (strlen(text) >= sizeof copy) {
        return false;
    }
    (void)memcpy(copy, text, strlen(text) + 1);
    if (!split(copy, &low, &high) ||
        (*low != '\0' && !number_parse_real(low, -1e6, 1e6, &a)) ||
        (*high != '\0' && !number_parse_real(high, -1e6, 1e6, &b)) || a > b) {
        return false;
    }
    *min = (float)a;
    *max = (float)b;
    return true;
}

static bool parse_box(const char *text, lum_selection *out)
{
    const char *p = text;
    for (unsigned axis = 0; axis < 3; axis++) {
        const size_t len = strcspn(p, ",");
        char limits[64];
        const bool is_last = p[len] == '\0';
        if (len >= sizeof limits || is_last != (axis == 2)) {
            return false;
        }
        (void)memcpy(limits, p, len);
        limits[len] = '\0';
        if (!parse_limits(limits, &out->box_min[axis], &out->box_max[axis])) {
            return false;
        }
        p += len + 1;
    }
    out->has_box = true;
    return true;
}

static bool parse_frames(const char *text, struct options *out)
{
    char copy[64];
    char *first = NULL;
    char *last = NULL;
    if (strlen(text) >= sizeof copy) {
        return false;
    }
    (void)memcpy(copy, text, strlen(text) + 1);
    return split(copy, &first, &last) &&
           (*first == '\0' ||
            number_parse_int(first, INT64_MIN, INT64_MAX, &out->frame_first)) &&
           (*last == '\0' ||
            number_parse_int(last, INT64_MIN, INT64_MAX, &out->frame_last)) &&
           out->frame_first <= out->frame_last;
}

static bool parse_choice(int option, const char *text, struct options *out)
{
    unsigned value = 0;
    switch (option) {
    case OPT_FORMAT:
        out->has_format = choose("--format", formats, text, &out->format);
        return out->has_format;
    case OPT_TIME:
        return choose("--time", times, text, &value) &&
               ((out->utc = value != 0), true);
    case OPT_INCOMPLETE:
        return choose("--incomplete", keeps, text, &value) &&
               ((out->drop_incomplete = value != 0), true);
    case OPT_EYE:
        return choose("--eye", eyes, text, &out->eyes);
    default:
        return choose("--edge", edges, text, &value) &&
               ((out->selection.edges = (lum_edges)value), true);
    }
}

static bool parse_limit(int option, const char *text, struct options *out)
{
    lum_selection *s = &out->selection;
    double seconds = 0;
    switch (option) {
    case OPT_FRAMES:
        return parse_frames(text, out) ||
               complain("--frames", text, "FIRST:LAST, such as 10:20 or 10:");
    case OPT_RANGE:
        s->has_range = parse_limits(text, &s->range_min, &s->range_max);
        return s->has_range ||
               complain("--range", text, "MIN:MAX in metres, such as 2:80");
    case OPT_BOX:
        return parse_box(text, s) ||
               complain("--box", text,
                        "XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX in metres, such as "
                        "0:50,-10:10,:4");
    case OPT_SENSOR:
        out->has_sensor = number_parse_address(text, &out->sensor);
        return out->has_sensor ||
               complain("--sensor", text, "an address such as 10.42.0.37");
    case OPT_RETURN:
        return parse_return(text, s);
    default:
        if (!number_parse_real(text, 1e-6, 1e9, &seconds)) {
            return complain("--duration", text, "a number of seconds above 0");
        }
        out->duration_ns = (int64_t)(seconds * 1e9);
        return true;
    }
}

static bool set_option(int option, struct options *out)
{
    switch (option) {
    case 'o':
        out->output = optarg;
        return true;
    case 'q':
        out->quiet = true;
        return true;
    case OPT_ASCII:
        out->ascii = true;
        return true;
    case OPT_JSON:
        out->json = true;
        return true;
    case OPT_CALIBRATION:
        out->calibration = optarg;
        return true;
    case OPT_PROFILE:
        out->profile = optarg;
        return true;
    case OPT_FORMAT:
    case OPT_TIME:
    case OPT_INCOMPLETE:
    case OPT_EYE:
    case OPT_EDGE:
        return parse_choice(option, optarg, out);
    default:
        return parse_limit(option, optarg, out);
    }
}

static bool has_ending(const char *name, const char *ending)
{
    const size_t n = strlen(name);
    const size_t m = strlen(ending);
    return n > m && strcmp(name + n - m, ending) == 0;
}

static bool find_format(struct options *out)
{
    lum_format format = LUM_FORMAT_CSV;
    if (out->output == NULL || out->has_format) {
        return true;
    }
    if (strcmp(out->output, "-") == 0) {
        (void)fprintf(
            stderr, "lumdump: standard output has no ending to tell a format "
                    "by: say --format csv, ply, pcd, las, xyz, png or pcap\n");
        return false;
    }
    if (has_ending(out->output, ".pcap")) {
        out->format = FORMAT_PCAP;
        return true;
    }
    if (lum_format_from_name(out->output, &format) != 0) {
        (void)fprintf(stderr,
                      "lumdump: '%s' tells no format by its ending: use .csv "
                      ".ply .pcd .las .xyz .png or .pcap, or say --format\n",
                      out->output);
        return false;
    }
    out->format = format;
    return true;
}

static bool take_source(int argc, char **argv, struct options *out)
{
    if (optind == argc) {
        (void)fprintf(stderr, "lumdump: no SOURCE: name a capture, or - for "
                              "standard input; see lumdump --help\n");
        return false;
    }
    if (optind + 1 < argc) {
        (void)fprintf(stderr,
                      "lumdump: one SOURCE only: '%s' is one too many\n",
                      argv[optind + 1]);
        return false;
    }
    out->source = argv[optind];
    if (strncmp(out->source, "udp://", 6) == 0) {
        (void)fprintf(stderr,
                      "lumdump: %s: a live sensor cannot be read by this "
                      "version; capture it (tcpdump -w FILE udp port 5517) and "
                      "name the file\n",
                      out->source);
        return false;
    }
    return true;
}

static bool is_consistent(const struct options *o)
{
    const bool has_ascii =
        o->format == LUM_FORMAT_PLY || o->format == LUM_FORMAT_PCD;
    if (o->ascii && o->output != NULL && !has_ascii) {
        (void)fprintf(stderr,
                      "lumdump: --ascii goes with ply and pcd output only\n");
        return false;
    }
    if (o->json && o->output != NULL && strcmp(o->output, "-") == 0) {
        (void)fprintf(stderr, "lumdump: --json and -o - would both write to "
                              "standard output: name a file\n");
        return false;
    }
    return true;
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    int option = 0;
    *out = (struct options){
        .eyes = 3, .frame_first = INT64_MIN, .frame_last = INT64_MAX};
    lum_selection_default(&out->selection);
    while ((option = getopt_long(argc, argv, "o:q", long_options, NULL)) !=
           -1) {
        if (option == OPT_HELP) {
            (void)fputs(help, stdout);
            return PARSED_DONE;
        }
        if (option == OPT_VERSION) {
            (void)puts("lumdump " LUM_VERSION);
            return PARSED_DONE;
        }
        if (option == '?') {
            (void)fputs("lumdump: see lumdump --help\n", stderr);
            return PARSED_BAD;
        }
        if (!set_option(option, out)) {
            return PARSED_BAD;
        }
    }
    return take_source(argc, argv, out) && find_format(out) &&
                   is_consistent(out)
               ? PARSED_RUN
               : PARSED_BAD;
}
