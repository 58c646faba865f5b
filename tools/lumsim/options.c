#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include "../common/host.h"
#include "../common/number.h"
#include "files.h"
#include "lum/version.h"
#include "lum/wire.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

#define FRAMES_MAX   10000000
#define LOOP_MAX     1000        /* frames that are held in memory */
#define CLIENT       0x0a2a0001u /* 10.42.0.1 */
#define LOOPBACK     0x7f000001u /* 127.0.0.1 */
#define CLIENT_PORT  50000
#define EXIT_USAGE   2
#define RATE_MIN_HZ  0.2
#define RATE_MAX_HZ  100.0
#define DELAY_MAX_MS 10000.0
#define SPEED_MIN    0.001
#define SPEED_MAX    1000.0
#define DURATION_MAX 1e9
#define DRIFT_MAX    1000.0
#define BATCH_MAX_MS 1000.0

static bool complain(const char *option, const char *text, const char *allowed)
{
    (void)fprintf(stderr, "lumsim: --%s: '%s' is not %s\n", option, text,
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

static bool parse_real(const char *option, const char *text, double min,
                       double max, double *out)
{
    char allowed[80];
    if (number_parse_real(text, min, max, out)) {
        return true;
    }
    (void)snprintf(allowed, sizeof allowed, "a number from %g to %g", min, max);
    return complain(option, text, allowed);
}

static bool parse_frames(const char *name, const char *text,
                         struct options *out)
{
    return parse_whole(name, text, 1, FRAMES_MAX, &out->frames);
}

static bool parse_lines(const char *name, const char *text, struct options *out)
{
    const bool is_64 = strcmp(text, "64") == 0;
    out->render.lines = is_64 ? 64 : 640;
    return is_64 || strcmp(text, "640") == 0 ||
           complain(name, text, "64 or 640");
}

static bool parse_rate(const char *name, const char *text, struct options *out)
{
    return parse_real(name, text, RATE_MIN_HZ, RATE_MAX_HZ,
                      &out->render.rate_hz);
}

static bool parse_seed(const char *name, const char *text, struct options *out)
{
    int64_t value = 0;
    const bool good = parse_whole(name, text, 0, INT64_MAX, &value);
    out->render.seed = (uint64_t)value;
    return good;
}

static bool parse_returns(const char *name, const char *text,
                          struct options *out)
{
    int64_t value = 0;
    const bool good =
        parse_whole(name, text, 1, LUM_RENDER_RETURNS_MAX, &value);
    out->render.returns_max = (unsigned)value;
    return good;
}

static bool parse_clock(const char *name, const char *text, struct options *out)
{
    int64_t value = 0;
    const bool good = parse_whole(name, text, 0, UINT32_MAX, &value);
    out->clock_us = (uint32_t)value;
    return good;
}

static bool parse_port(const char *name, const char *text, struct options *out)
{
    int64_t value = 0;
    const bool good = parse_whole(name, text, 1, UINT16_MAX, &value);
    out->port = (uint16_t)value;
    return good;
}

/* An address that a host may have. */
static bool parse_host(const char *option, const char *text, uint32_t *out)
{
    lum_error why = {""};
    if (!host_parse(text, out, &why)) {
        (void)fprintf(stderr, "lumsim: --%s: %s\n", option, why.text);
        return false;
    }
    return (*out >> 24 != 0 && *out >> 28 < 0xeu) ||
           complain(option, text, "an address of a host, such as 10.42.0.37");
}

static bool parse_address(const char *name, const char *text,
                          struct options *out)
{
    return parse_host(name, text, &out->sensor);
}

static bool parse_sensor(const char *name, const char *text,
                         struct options *out)
{
    return parse_host(name, text, &out->replayed);
}

static bool parse_interface(const char *name, const char *text,
                            struct options *out)
{
    lum_error why = {""};
    out->interface = text;
    if (!host_has_interface(text, &why)) {
        (void)fprintf(stderr, "lumsim: --%s: %s\n", name, why.text);
        return false;
    }
    return true;
}

static bool parse_client(const char *name, const char *text,
                         struct options *out)
{
    char address[256];
    const size_t len = strcspn(text, ":");
    int64_t port = CLIENT_PORT;
    if (len >= sizeof address) {
        return complain(name, text, "HOST or HOST:PORT");
    }
    (void)memcpy(address, text, len);
    address[len] = '\0';
    if (text[len] == ':' &&
        !number_parse_int(text + len + 1, 1, UINT16_MAX, &port)) {
        return complain(name, text,
                        "HOST or HOST:PORT with a port from 1 to 65535");
    }
    out->client_port = (uint16_t)port;
    return parse_host(name, address, &out->client);
}

static bool parse_probability(const char *name, const char *text, double *out)
{
    return number_parse_real(text, 0.0, 1.0, out) ||
           complain(name, text, "a probability from 0 to 1");
}

static bool parse_loss(const char *name, const char *text, struct options *out)
{
    return parse_probability(name, text, &out->faults[LUM_FAULT_LOSS]);
}

static bool parse_duplicate(const char *name, const char *text,
                            struct options *out)
{
    return parse_probability(name, text, &out->faults[LUM_FAULT_DUPLICATE]);
}

static bool parse_reorder(const char *name, const char *text,
                          struct options *out)
{
    return parse_probability(name, text, &out->faults[LUM_FAULT_REORDER]);
}

static bool parse_corrupt(const char *name, const char *text,
                          struct options *out)
{
    return parse_probability(name, text, &out->faults[LUM_FAULT_CORRUPT]);
}

static bool parse_answer_loss(const char *name, const char *text,
                              struct options *out)
{
    return parse_probability(name, text, &out->answer_loss);
}

static bool parse_jitter(const char *name, const char *text,
                         struct options *out)
{
    return parse_real(name, text, 0.0, DELAY_MAX_MS, &out->jitter_ms);
}

static bool parse_answer_delay(const char *name, const char *text,
                               struct options *out)
{
    return parse_real(name, text, 0.0, DELAY_MAX_MS, &out->answer_delay_ms);
}

static bool parse_drift(const char *name, const char *text, struct options *out)
{
    return parse_real(name, text, -DRIFT_MAX, DRIFT_MAX, &out->drift_ppm);
}

static bool parse_batch(const char *name, const char *text, struct options *out)
{
    return parse_real(name, text, 0.0, BATCH_MAX_MS, &out->batch_ms);
}

static bool parse_time(const char *name, const char *text, struct options *out)
{
    out->truth_is_utc = strcmp(text, "utc") == 0;
    return out->truth_is_utc || strcmp(text, "sensor") == 0 ||
           complain(name, text, "sensor or utc");
}

static bool parse_duration(const char *name, const char *text,
                           struct options *out)
{
    return parse_real(name, text, 0.001, DURATION_MAX, &out->duration_s);
}

static bool parse_speed(const char *name, const char *text, struct options *out)
{
    return parse_real(name, text, SPEED_MIN, SPEED_MAX, &out->speed);
}

static bool parse_fault(const char *name, const char *text, struct options *out)
{
    const char *right;
    return timeline_add(&out->timeline, text, &right) ||
           complain(name, text, right);
}

#define KEEP(function, field)                                                  \
    static bool function(const char *name, const char *text,                   \
                         struct options *out)                                  \
    {                                                                          \
        (void)name;                                                            \
        out->field = text;                                                     \
        return true;                                                           \
    }
KEEP(keep_output, output)
KEEP(keep_truth, truth)
KEEP(keep_calibration, calibration)
KEEP(keep_profile, profile)
KEEP(keep_log, log)
KEEP(keep_replay, replay)

#define SET(function, field)                                                   \
    static bool function(const char *name, const char *text,                   \
                         struct options *out)                                  \
    {                                                                          \
        (void)name;                                                            \
        (void)text;                                                            \
        out->field = true;                                                     \
        return true;                                                           \
    }
SET(set_loop, loop)
SET(set_quiet, quiet)

#define ALL     (MODE_FILE | MODE_SCENE | MODE_REPLAY)
#define LIVE    (MODE_SCENE | MODE_REPLAY)
#define DRIVE   (MODE_FILE | MODE_SCENE)
#define PLAIN   no_argument
#define VALUE   required_argument
#define HELP    0x100
#define VERSION 0x101
#define FIRST   0x102 /* of the table */

static const struct spec {
    const char *name;
    int argument;
    int letter; /* 0: none */
    int modes;  /* that it goes with */
    bool (*parse)(const char *name, const char *text, struct options *out);
} specs[] = {
    {"output", VALUE, 'o', ALL, keep_output},
    {"frames", VALUE, 'n', DRIVE, parse_frames},
    {"quiet", PLAIN, 'q', ALL, set_quiet},
    {"truth", VALUE, 0, MODE_FILE, keep_truth},
    {"time", VALUE, 0, MODE_FILE, parse_time},
    {"drift", VALUE, 0, MODE_FILE, parse_drift},
    {"batch", VALUE, 0, MODE_FILE, parse_batch},
    {"lines", VALUE, 0, DRIVE, parse_lines},
    {"rate", VALUE, 0, DRIVE, parse_rate},
    {"seed", VALUE, 0, ALL, parse_seed},
    {"returns-max", VALUE, 0, DRIVE, parse_returns},
    {"loss", VALUE, 0, ALL, parse_loss},
    {"duplicate", VALUE, 0, ALL, parse_duplicate},
    {"reorder", VALUE, 0, ALL, parse_reorder},
    {"corrupt", VALUE, 0, ALL, parse_corrupt},
    {"jitter", VALUE, 0, LIVE, parse_jitter},
    {"answer-delay", VALUE, 0, LIVE, parse_answer_delay},
    {"answer-loss", VALUE, 0, LIVE, parse_answer_loss},
    {"fault", VALUE, 0, LIVE, parse_fault},
    {"calibration", VALUE, 0, DRIVE, keep_calibration},
    {"profile", VALUE, 0, ALL, keep_profile},
    {"address", VALUE, 0, ALL, parse_address},
    {"port", VALUE, 0, LIVE, parse_port},
    {"interface", VALUE, 0, LIVE, parse_interface},
    {"clock", VALUE, 0, LIVE, parse_clock},
    {"duration", VALUE, 0, LIVE, parse_duration},
    {"log", VALUE, 0, LIVE, keep_log},
    {"client", VALUE, 0, MODE_FILE, parse_client},
    {"replay", VALUE, 0, ALL, keep_replay},
    {"speed", VALUE, 0, MODE_REPLAY, parse_speed},
    {"loop", PLAIN, 0, MODE_REPLAY, set_loop},
    {"sensor", VALUE, 0, MODE_REPLAY, parse_sensor},
};

#define SPECS (sizeof specs / sizeof specs[0])

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

/* Why an option does not go with the mode. */
static const char *reason(int modes)
{
    switch (modes) {
    case MODE_FILE:
        return "goes with -o FILE alone, not with a sensor on the network";
    case MODE_REPLAY:
        return "goes with --replay FILE alone";
    case DRIVE:
        return "does not go with --replay: the capture decides that";
    default:
        return "is for a sensor on the network; it does not go with -o";
    }
}

static bool check_modes(const struct options *o, const bool given[SPECS])
{
    for (size_t i = 0; i < SPECS; i++) {
        if (given[i] && (specs[i].modes & (int)o->mode) == 0) {
            (void)fprintf(stderr, "lumsim: --%s %s\n", specs[i].name,
                          reason(specs[i].modes));
            return false;
        }
    }
    return true;
}

/* Whether what was asked for can be done in one run. */
static bool check_choice(const struct options *o)
{
    if (o->mode == MODE_SCENE && o->frames > LOOP_MAX) {
        (void)fprintf(stderr,
                      "lumsim: --frames: on the network frames are held in "
                      "memory and played in a loop; at most %d\n",
                      LOOP_MAX);
        return false;
    }
    if (o->truth_is_utc && o->truth == NULL) {
        (void)fputs("lumsim: --time utc is about the times in --truth FILE; "
                    "name one\n",
                    stderr);
        return false;
    }
    if (o->output != NULL && o->replay != NULL) {
        (void)fputs("lumsim: -o and --replay: one writes a capture, the other "
                    "sends one over the network; choose\n",
                    stderr);
        return false;
    }
    return true;
}

static void choose_mode(struct options *o)
{
    o->mode = o->output != NULL   ? MODE_FILE
              : o->replay != NULL ? MODE_REPLAY
                                  : MODE_SCENE;
    if (o->sensor == 0) {
        o->sensor = o->mode == MODE_FILE ? LUM_BOOT_ADDRESS : LOOPBACK;
    }
}

static void set_defaults(struct options *out)
{
    *out = (struct options){.client = CLIENT,
                            .client_port = CLIENT_PORT,
                            .port = LUM_PORT,
                            .speed = 1.0};
    lum_render_options_default(&out->render);
    out->render.seed = 1;
}

static void describe(struct option out[SPECS + 3], char letters[2 * SPECS + 1])
{
    char *letter = letters;
    for (size_t i = 0; i < SPECS; i++) {
        const struct spec *s = &specs[i];
        out[i] = (struct option){s->name, s->argument, NULL, FIRST + (int)i};
        if (s->letter != 0) {
            *letter++ = (char)s->letter;
            if (s->argument == VALUE) {
                *letter++ = ':';
            }
        }
    }
    *letter = '\0';
    out[SPECS] = (struct option){"help", PLAIN, NULL, HELP};
    out[SPECS + 1] = (struct option){"version", PLAIN, NULL, VERSION};
    out[SPECS + 2] = (struct option){NULL, 0, NULL, 0};
}

/* SPECS if getopt_long() did not know it. */
static size_t find(int option)
{
    size_t i = 0;
    if (option >= FIRST) {
        return (size_t)(option - FIRST);
    }
    while (i < SPECS && specs[i].letter != option) {
        i++;
    }
    return i;
}

/* -1 when all were read, else the exit status. */
static int read_options(int argc, char **argv, bool given[SPECS],
                        struct options *out)
{
    struct option table[SPECS + 3];
    char letters[2 * SPECS + 1];
    int option;
    describe(table, letters);
    while ((option = getopt_long(argc, argv, letters, table, NULL)) != -1) {
        if (option == HELP) {
            return print(options_help);
        }
        if (option == VERSION) {
            return print("lumsim " LUM_VERSION "\n");
        }
        const size_t i = find(option);
        if (i == SPECS || !specs[i].parse(specs[i].name, optarg, out)) {
            return see_help();
        }
        given[i] = true;
    }
    return -1;
}

int options_parse(int argc, char **argv, struct options *out)
{
    bool given[SPECS] = {false};
    set_defaults(out);
    const int status = read_options(argc, argv, given, out);
    if (status >= 0) {
        return status;
    }
    if (optind < argc) {
        (void)fprintf(stderr,
                      "lumsim: '%s': no argument is expected beside the "
                      "options; -o FILE names an output\n",
                      argv[optind]);
        return see_help();
    }
    choose_mode(out);
    if (!check_choice(out) || !check_modes(out, given) || !files_check(out)) {
        return see_help();
    }
    return files_load(out) ? -1 : EXIT_USAGE;
}
