#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include "../common/number.h"
#include "lum/io/config.h"
#include "lum/version.h"
#include "lum/wire.h"
#include "sim/packets.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FRAMES_MAX  10000000
#define CLIENT      0x0a2a0001u /* 10.42.0.1 */
#define CLIENT_PORT 50000
#define EXIT_USAGE  2
#define RATE_MIN_HZ 0.2
#define RATE_MAX_HZ 100.0

static const char help[] =
    "Usage: lumsim -o OUTPUT [OPTION]...\n"
    "Simulate a Luminar Model G2 that drives along a street, and write what "
    "it\n"
    "sends to a capture.\n"
    "\n"
    "Output:\n"
    "  -o, --output FILE       the capture, pcap; - for standard output\n"
    "      --truth FILE        CSV of the exact points: true angles, ranges\n"
    "                          without noise; the columns and the order of "
    "rows\n"
    "                          are lumdump's\n"
    "  -q, --quiet             no progress, no summary\n"
    "\n"
    "Drive:\n"
    "  -n, --frames N          how many frames (default 10)\n"
    "      --lines 64|640      lines of a frame (default 64)\n"
    "      --rate HZ           frames a second, 0.2 to 100 (default 10)\n"
    "      --seed S            of street, noise and faults (default 1); the "
    "same\n"
    "                          arguments give the same bytes\n"
    "      --returns-max N     returns of a pixel, 1 to 8 (default 4)\n"
    "\n"
    "Faults, each the probability 0..1 that it befalls a packet (default 0):\n"
    "      --loss P            it never comes\n"
    "      --duplicate P       it comes twice\n"
    "      --reorder P         it comes behind 1 to 4 later ones\n"
    "      --corrupt P         1 to 3 bits of its payload are flipped\n"
    "\n"
    "Sensor:\n"
    "      --calibration FILE  YAML; default: the manual's typical values\n"
    "      --profile FILE      YAML; layout of data packets, where it differs\n"
    "      --address ADDRESS   of the sensor (default 10.42.0.37)\n"
    "      --client ADDRESS[:PORT]\n"
    "                          who gets the data (default 10.42.0.1:50000)\n"
    "\n"
    "      --help, --version\n"
    "\n"
    "Exit status: 0 done, 1 it failed, 2 bad arguments or configuration.\n"
    "\n"
    "Examples:\n"
    "  lumsim -o street.pcap                    one second of a street\n"
    "  lumsim -o street.pcap --frames 100 --seed 7 --truth truth.csv\n"
    "  lumsim -o bad.pcap --loss 0.01 --reorder 0.05 --corrupt 0.001\n"
    "  lumsim -o - --lines 640 --frames 1 | lumdump - -o street.png\n";

enum {
    OPT_TRUTH = 256,
    OPT_LINES,
    OPT_RATE,
    OPT_SEED,
    OPT_RETURNS_MAX,
    OPT_LOSS,
    OPT_DUPLICATE,
    OPT_REORDER,
    OPT_CORRUPT,
    OPT_CALIBRATION,
    OPT_PROFILE,
    OPT_ADDRESS,
    OPT_CLIENT,
    OPT_HELP,
    OPT_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"truth", required_argument, NULL, OPT_TRUTH},
    {"quiet", no_argument, NULL, 'q'},
    {"frames", required_argument, NULL, 'n'},
    {"lines", required_argument, NULL, OPT_LINES},
    {"rate", required_argument, NULL, OPT_RATE},
    {"seed", required_argument, NULL, OPT_SEED},
    {"returns-max", required_argument, NULL, OPT_RETURNS_MAX},
    {"loss", required_argument, NULL, OPT_LOSS},
    {"duplicate", required_argument, NULL, OPT_DUPLICATE},
    {"reorder", required_argument, NULL, OPT_REORDER},
    {"corrupt", required_argument, NULL, OPT_CORRUPT},
    {"calibration", required_argument, NULL, OPT_CALIBRATION},
    {"profile", required_argument, NULL, OPT_PROFILE},
    {"address", required_argument, NULL, OPT_ADDRESS},
    {"client", required_argument, NULL, OPT_CLIENT},
    {"help", no_argument, NULL, OPT_HELP},
    {"version", no_argument, NULL, OPT_VERSION},
    {NULL, 0, NULL, 0},
};

static bool complain(const char *option, const char *text, const char *allowed)
{
    (void)fprintf(stderr, "lumsim: %s: '%s' is not %s\n", option, text,
                  allowed);
    return false;
}

static bool parse_whole(const char *option, const char *text, int64_t min,
                        int64_t max, int64_t *out)
{
    char allowed[80];
    if (number_parse_int(text, min, max, out)) {
        return true;
    }
    (void)snprintf(allowed, sizeof allowed, "a whole number from %lld to %lld",
                   (long long)min, (long long)max);
    return complain(option, text, allowed);
}

static bool parse_lines(const char *text, struct options *out)
{
    const bool is_64 = strcmp(text, "64") == 0;
    out->render.lines = is_64 ? 64 : 640;
    return is_64 || strcmp(text, "640") == 0 ||
           complain("--lines", text, "64 or 640");
}

static bool parse_rate(const char *text, struct options *out)
{
    return number_parse_real(text, RATE_MIN_HZ, RATE_MAX_HZ,
                             &out->render.rate_hz) ||
           complain("--rate", text, "a number from 0.2 to 100");
}

static bool parse_seed(const char *text, struct options *out)
{
    int64_t value = 0;
    const bool good = parse_whole("--seed", text, 0, INT64_MAX, &value);
    out->render.seed = (uint64_t)value;
    return good;
}

static bool parse_returns(const char *text, struct options *out)
{
    int64_t value = 0;
    const bool good =
        parse_whole("--returns-max", text, 1, LUM_RENDER_RETURNS_MAX, &value);
    out->render.returns_max = (unsigned)value;
    return good;
}

/* An address that a host may have. */
static bool parse_host(const char *option, const char *text, uint32_t *out)
{
    return (number_parse_address(text, out) && *out >> 24 != 0 &&
            *out >> 28 < 0xeu) ||
           complain(option, text, "an address of a host, such as 10.42.0.37");
}

static bool parse_client(const char *text, struct options *out)
{
    char address[64];
    const size_t len = strcspn(text, ":");
    int64_t port = CLIENT_PORT;
    if (len >= sizeof address) {
        return complain("--client", text, "ADDRESS or ADDRESS:PORT");
    }
    (void)memcpy(address, text, len);
    address[len] = '\0';
    if (text[len] == ':' &&
        !number_parse_int(text + len + 1, 1, UINT16_MAX, &port)) {
        return complain("--client", text,
                        "ADDRESS or ADDRESS:PORT with a port from 1 to 65535");
    }
    out->client_port = (uint16_t)port;
    return parse_host("--client", address, &out->client);
}

static bool parse_probability(int option, const char *text, struct options *out)
{
    static const struct {
        int option;
        enum lum_fault_kind kind;
        const char *name;
    } faults[] = {
        {OPT_LOSS, LUM_FAULT_LOSS, "--loss"},
        {OPT_DUPLICATE, LUM_FAULT_DUPLICATE, "--duplicate"},
        {OPT_REORDER, LUM_FAULT_REORDER, "--reorder"},
        {OPT_CORRUPT, LUM_FAULT_CORRUPT, "--corrupt"},
    };
    size_t i = 0;
    while (faults[i].option != option) {
        i++;
    }
    return number_parse_real(text, 0.0, 1.0, &out->faults[faults[i].kind]) ||
           complain(faults[i].name, text, "a probability from 0 to 1");
}

static bool parse_output(int option, const char *text, struct options *out)
{
    switch (option) {
    case 'o':
        out->output = text;
        return true;
    case OPT_TRUTH:
        out->truth = text;
        return true;
    case OPT_CALIBRATION:
        out->calibration = text;
        return true;
    case OPT_PROFILE:
        out->profile = text;
        return true;
    case 'q':
        out->quiet = true;
        return true;
    default:
        return parse_probability(option, text, out);
    }
}

static bool parse_option(int option, const char *text, struct options *out)
{
    switch (option) {
    case '?':
        return false;
    case 'n':
        return parse_whole("--frames", text, 1, FRAMES_MAX, &out->frames);
    case OPT_LINES:
        return parse_lines(text, out);
    case OPT_RATE:
        return parse_rate(text, out);
    case OPT_SEED:
        return parse_seed(text, out);
    case OPT_RETURNS_MAX:
        return parse_returns(text, out);
    case OPT_ADDRESS:
        return parse_host("--address", text, &out->sensor);
    case OPT_CLIENT:
        return parse_client(text, out);
    default:
        return parse_output(option, text, out);
    }
}

static int see_help(void)
{
    (void)fputs("Try 'lumsim --help'.\n", stderr);
    return EXIT_USAGE;
}

static int print(const char *text)
{
    if (fputs(text, stdout) == EOF || fflush(stdout) != 0) {
        perror("lumsim: standard output");
        return 1;
    }
    return 0;
}

static bool is_same_file(const char *a, const char *b)
{
    struct stat first;
    struct stat second;
    if (strcmp(a, b) == 0) {
        return true;
    }
    return stat(a, &first) == 0 && stat(b, &second) == 0 &&
           S_ISREG(first.st_mode) && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

static bool check_outputs(const struct options *o)
{
    if (o->output == NULL) {
        (void)fputs("lumsim: no output: -o FILE names the capture to write, "
                    "-o - is standard output\n",
                    stderr);
        return false;
    }
    if (o->truth != NULL && is_same_file(o->output, o->truth)) {
        (void)fprintf(stderr,
                      "lumsim: --truth: '%s' is the capture's output too; "
                      "give them different names\n",
                      o->truth);
        return false;
    }
    if (strcmp(o->output, "-") == 0 && isatty(STDOUT_FILENO)) {
        (void)fputs("lumsim: -o -: a capture is binary and standard output is "
                    "a terminal; redirect it, or give a file's name\n",
                    stderr);
        return false;
    }
    return true;
}

static bool complain_of_profile(const struct options *o, const char *why)
{
    (void)fprintf(stderr, "lumsim: %s: %s\n", o->profile, why);
    return false;
}

static bool load(struct options *o)
{
    lum_render_options *r = &o->render;
    lum_error error = {""};
    lum_profile profile = r->layout.profile;
    if ((o->calibration != NULL &&
         lum_calibration_load(o->calibration, &r->calibration, &error) != 0) ||
        (o->profile != NULL &&
         lum_profile_load(o->profile, &profile, &error) != 0)) {
        (void)fprintf(stderr, "lumsim: %s\n", error.text);
        return false;
    }
    if (lum_layout_init(&r->layout, &profile, NULL, NULL) != LUM_OK) {
        return complain_of_profile(o, "this layout cannot be");
    }
    if (lum_packets_check(&r->layout, r->lines) != LUM_OK) {
        return complain_of_profile(
            o, "a field of group is too narrow for what it has to hold; line, "
               "num_samples and first_sample_index need 2 bytes");
    }
    return true;
}

static void set_defaults(struct options *out)
{
    *out = (struct options){.frames = 10,
                            .sensor = LUM_BOOT_ADDRESS,
                            .client = CLIENT,
                            .client_port = CLIENT_PORT};
    lum_render_options_default(&out->render);
    out->render.seed = 1;
}

static int finish(int argc, char **argv, struct options *out)
{
    if (optind < argc) {
        (void)fprintf(stderr,
                      "lumsim: '%s': no argument is expected beside the "
                      "options; -o FILE names the output\n",
                      argv[optind]);
        return see_help();
    }
    if (!check_outputs(out)) {
        return see_help();
    }
    return load(out) ? -1 : EXIT_USAGE;
}

int options_parse(int argc, char **argv, struct options *out)
{
    int option;
    set_defaults(out);
    while ((option = getopt_long(argc, argv, "o:n:q", long_options, NULL)) !=
           -1) {
        if (option == OPT_HELP) {
            return print(help);
        }
        if (option == OPT_VERSION) {
            return print("lumsim " LUM_VERSION "\n");
        }
        if (!parse_option(option, optarg, out)) {
            return see_help();
        }
    }
    return finish(argc, argv, out);
}
