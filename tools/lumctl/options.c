#include "options.h"

#include "../common/host.h"
#include "../common/option_table.h"
#include "ctl_session.h"
#include "help.h"

#include "lum/host/yscan.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

#define TIMEOUT_MAX_MS 60000
#define RETRIES_MAX    100
#define RATE_MIN_HZ    (1000.0 / LUM_SENSOR_HEARTBEAT_MAX_MS)
#define RATE_MAX_HZ    (1000.0 / LUM_SENSOR_HEARTBEAT_MIN_MS)
#define DURATION_MIN_S 0.001
#define DURATION_MAX_S 1e9
#define EVERY_MIN_S    0.1
#define EVERY_MAX_S    86400.0

bool options_allow_host(const struct ctl_options *options, const char *text,
                        lum_error *why)
{
    if (!options->no_names || !host_is_name(text)) {
        return true;
    }
    (void)lum_error_set(why,
                        "'%.80s': no name is looked up while this shell sends "
                        "heartbeats, because they would stop during that "
                        "time; give the address, such as 10.42.0.38",
                        text);
    return false;
}

bool options_parse_host(const char *text, lum_endpoint *out, lum_error *why)
{
    lum_endpoint found = *out;
    if (!host_parse_endpoint(text, &found, why)) {
        return false;
    }
    *out = found;
    if (!lum_address_is_host(found.address)) {
        (void)lum_error_set(
            why,
            "'%.80s': no sensor can have this address; the usual "
            "one is 10.42.0.37",
            text);
        return false;
    }
    return true;
}

static bool take_host(void *options, const char *text, lum_error *why)
{
    struct ctl_options *o = options;
    return options_allow_host(o, text, why) &&
           options_parse_host(text, &o->host, why);
}

#define INTO(field) OPTION_INTO(struct ctl_options, field)
static bool take_set(void *options, const char *text, lum_error *why)
{
    struct ctl_options *o = options;
    return set_keys_add(&o->set, text, why);
}

#define HAS(field) .has = offsetof(struct ctl_options, field)

static const struct option_word until_words[] = {{"hazard", UNTIL_HAZARD},
                                                 {"up", UNTIL_UP},
                                                 {"down", UNTIL_DOWN},
                                                 {NULL, 0}};

static const struct option_spec specs[] = {
    {"host", .kind = OPTION_CALL, .group = OWN_SESSION, .call = take_host,
     HAS(has_host), .value = "HOST[:PORT]",
     .allowed = "an address of a sensor, such as 10.42.0.37 or localhost:5517",
     .help = "the sensor (default 10.42.0.37)"},
    {"port", .kind = OPTION_WHOLE, .group = OWN_SESSION, INTO(host.port),
     .min = 1, .max = UINT16_MAX, .value = "N",
     .allowed = "a port from 1 to 65535", .help = "its port (default 5517)"},
    {"interface", .kind = OPTION_TEXT, .group = OWN_SESSION, INTO(interface),
     .value = "NAME", .allowed = "the name of an interface",
     .help = "reach the sensor only through this"},
    {"timeout", .kind = OPTION_WHOLE, .group = OWN_SESSION,
     INTO(requests.timeout_ms), .min = 1, .max = TIMEOUT_MAX_MS, .value = "MS",
     .allowed = "a whole number of milliseconds from 1 to 60000",
     .help = "wait for an answer, milliseconds (default 400)"},
    {"retries", .kind = OPTION_WHOLE, .group = OWN_SESSION,
     INTO(requests.retries), HAS(requests.has_retries), .max = RETRIES_MAX,
     .value = "N", .help = "further tries without an answer (default 4)"},
    {"profile", .kind = OPTION_TEXT, .group = OWN_PROFILE, INTO(profile),
     .value = "FILE", .help = "YAML; layout of packets, if it differs"},
    {"calibration", .kind = OPTION_TEXT, .group = OWN_CALIBRATION,
     INTO(calibration), .value = "FILE",
     .help = "YAML; default: typical values (yscan, apply, sweep)"},
    {"set", .kind = OPTION_CALL, .call = take_set, .value = "KEY=VALUE",
     .allowed = SET_KEYS_ALLOWED,
     .help = "a key of a profile or calibration, on top"},
    {"sequence", .kind = OPTION_WHOLE, INTO(requests.sequence),
     HAS(requests.has_sequence), .max = UINT32_MAX, .value = "N",
     .help = "number of the first request (default: any)"},
    {"dry-run", .kind = OPTION_FLAG, INTO(dry_run),
     .help = "print the packet as a line of hex, send nothing"},
    {"json", .kind = OPTION_FLAG, INTO(json),
     .help = "the result as a JSON object"},
    {"quiet", .letter = 'q', .kind = OPTION_FLAG, INTO(quiet),
     .help = "no notes on standard error"},
    {"watch", .kind = OPTION_FLAG, .group = OWN_WATCH, INTO(repeat.watch),
     .help = "continue until Ctrl-C (status, time)"},
    {"heartbeat", .kind = OPTION_FLAG, .group = OWN_HEARTBEAT,
     INTO(owner.heartbeat), .help = "own the session (shell)"},
    {"rate", .kind = OPTION_REAL, .group = OWN_RATE, INTO(owner.rate_hz),
     .low = RATE_MIN_HZ, .high = RATE_MAX_HZ, .value = "HZ",
     .help = "heartbeats a second, default 5 (heartbeat, sweep)"},
    {"duration", .kind = OPTION_REAL, .group = OWN_DURATION,
     INTO(repeat.duration_s), .low = DURATION_MIN_S, .high = DURATION_MAX_S,
     .value = "S", .allowed = "a number of seconds above 0",
     .help = "end after this time (heartbeat, status, time)"},
    {"for", .kind = OPTION_REAL, .group = OWN_FOR, INTO(repeat.duration_s),
     .low = DURATION_MIN_S, .high = DURATION_MAX_S, .value = "S",
     .allowed = "a number of seconds above 0",
     .help = "wait at most this time (wait)"},
    {"laser", .kind = OPTION_FLAG, .group = OWN_LASER, INTO(owner.laser),
     .help = "on at first, off at the end (heartbeat, sweep)"},
    {"every", .kind = OPTION_REAL, .group = OWN_EVERY, INTO(repeat.every_s),
     .low = EVERY_MIN_S, .high = EVERY_MAX_S, .value = "S",
     .allowed = "a number of seconds from 0.1 to 86400",
     .help = "write a line at this interval (status, heartbeat)"},
    {"until", .kind = OPTION_WORD, .group = OWN_UNTIL, INTO(repeat.until),
     .words = until_words, .value = "hazard|up|down",
     .allowed = "hazard, up or down",
     .help = "end in this state (status, heartbeat)"},
    {"csv", .kind = OPTION_TEXT, .group = OWN_CSV, INTO(repeat.csv),
     .value = "FILE", .allowed = "a file",
     .help = "add the lines of --every to it (status, heartbeat)"},
    {"prometheus", .kind = OPTION_TEXT, .group = OWN_PROMETHEUS,
     INTO(repeat.prometheus), .value = "FILE", .allowed = "a file",
     .help = "write metrics for node_exporter (status, heartbeat)"},
    {"output", .letter = 'o', .kind = OPTION_TEXT, .group = OWN_OUTPUT,
     INTO(sweep.output), .value = "FOLDER", .allowed = "a folder",
     .help = "for recordings and their manifest (sweep)"},
    {"continue", .kind = OPTION_FLAG, .group = OWN_CONTINUE,
     INTO(sweep.goes_on), .help = "only the steps that are not done (sweep)"},
    {"shape", .kind = OPTION_TEXT, .group = OWN_SHAPE, INTO(yscan.shape),
     .value = "SHAPE", .allowed = "a shape",
     .help = "how lines are distributed (yscan)"},
    {"lines", .kind = OPTION_WHOLE, .group = OWN_LINES, INTO(yscan.lines),
     .min = 1, .max = LUM_YSCAN_LINES_MAX, .value = "N",
     .help = "lines of the distribution (yscan)"},
    {"force", .kind = OPTION_FLAG, .group = OWN_FORCE, INTO(force),
     .help = "allow an unreachable address (set-ip)"},
    {"subnet", .kind = OPTION_TEXT, .group = OWN_SUBNET, INTO(subnet),
     .value = "ADDRESS/BITS", .allowed = "a subnet such as 10.42.0.0/24",
     .help = "search there; a /22 at most (find)"},
    {"help", .letter = 'h', .kind = OPTION_FLAG, INTO(wants_help)},
    {"version", .kind = OPTION_FLAG, INTO(wants_version)},
};

#define OPTIONS (sizeof specs / sizeof specs[0])

const char *options_name(unsigned own)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        if ((specs[i].group & own) != 0) {
            return specs[i].name;
        }
    }
    return "";
}

static bool is_lacked(const char *name, const char *const lacks[2])
{
    for (size_t i = 0; lacks != NULL && i < 2 && lacks[i] != NULL; i++) {
        if (strcmp(name, lacks[i]) == 0) {
            return true;
        }
    }
    return false;
}

void options_help(bool general, unsigned own, const char *const lacks[2])
{
    for (size_t i = 0; i < OPTIONS; i++) {
        const struct option_spec *s = &specs[i];
        char name[24];
        const bool is_general =
            (s->group & ~(unsigned)(OWN_SESSION | OWN_PROFILE)) == 0;
        if (s->help == NULL || is_lacked(s->name, lacks) ||
            (is_general ? !general : (s->group & own) == 0)) {
            continue;
        }
        (void)snprintf(name, sizeof name, "--%s", s->name);
        help_row(name, s->value, s->help);
    }
    if (general) {
        help_row("-q, -h, --version", NULL, "--quiet, --help, the version");
    }
}

enum exit_status options_parse(struct ctl_options *options, const char *help,
                               int argc, char **argv, struct options_found *out)
{
    const struct option_table table = {"lumctl", help, specs, OPTIONS, true};
    struct option_result result;
    *out = (struct options_found){0, 0};
    if (option_table_read(&table, argc, argv, options, &result) !=
        OPTIONS_READ) {
        return EXIT_BAD;
    }
    out->count = result.count;
    for (size_t i = 0; i < OPTIONS; i++) {
        out->own |= option_table_has(&result, i) ? specs[i].group : 0u;
    }
    return EXIT_DONE;
}
