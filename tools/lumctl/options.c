#include "options.h"

#include "../common/host.h"
#include "../common/number.h"
#include "help.h"
#include "nearest.h"
#include "session.h"

#include "lum/wire.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define TIMEOUT_MAX_MS 60000
#define RETRIES_MAX    100
#define RATE_MIN_HZ    1.0
#define RATE_MAX_HZ    100.0
#define DURATION_MAX_S 1e9

struct option {
    const char *name;
    const char *value; /* what it takes; NULL: nothing */
    unsigned own;      /* which commands have it; 0: all */
    bool (*take)(struct ctl_options *options, const char *text);
    const char *allowed; /* of a value */
    const char *help;
};

static bool take_host(struct ctl_options *options, const char *text)
{
    options->has_host = true;
    return options_allow_host(options, text, &options->refusal) &&
           options_parse_host(text, &options->host, &options->refusal);
}

static bool take_port(struct ctl_options *options, const char *text)
{
    int64_t port = 0;
    const bool good = number_parse_int(text, 1, UINT16_MAX, &port);
    options->host.port = (uint16_t)port;
    return good;
}

static bool take_interface(struct ctl_options *options, const char *text)
{
    options->interface = text;
    return *text != '\0';
}

static bool take_profile(struct ctl_options *options, const char *text)
{
    options->profile = text;
    return *text != '\0';
}

static bool take_calibration(struct ctl_options *options, const char *text)
{
    options->calibration = text;
    return *text != '\0';
}

static bool take_timeout(struct ctl_options *options, const char *text)
{
    int64_t ms = 0;
    const bool good = number_parse_int(text, 1, TIMEOUT_MAX_MS, &ms);
    options->timeout_ms = (uint32_t)ms;
    return good;
}

static bool take_retries(struct ctl_options *options, const char *text)
{
    int64_t retries = 0;
    const bool good = number_parse_int(text, 0, RETRIES_MAX, &retries);
    options->retries = (uint32_t)retries;
    options->has_retries = good;
    return good;
}

static bool take_sequence(struct ctl_options *options, const char *text)
{
    int64_t sequence = 0;
    options->has_sequence = number_parse_int(text, 0, UINT32_MAX, &sequence);
    options->sequence = (uint32_t)sequence;
    return options->has_sequence;
}

static bool take_dry_run(struct ctl_options *options, const char *text)
{
    (void)text;
    options->dry_run = true;
    return true;
}

static bool take_json(struct ctl_options *options, const char *text)
{
    (void)text;
    options->json = true;
    return true;
}

static bool take_quiet(struct ctl_options *options, const char *text)
{
    (void)text;
    options->quiet = true;
    return true;
}

static bool take_watch(struct ctl_options *options, const char *text)
{
    (void)text;
    options->watch = true;
    return true;
}

static bool take_trace(struct ctl_options *options, const char *text)
{
    (void)text;
    options->trace = true;
    return true;
}

static bool take_heartbeat(struct ctl_options *options, const char *text)
{
    (void)text;
    options->heartbeat = true;
    return true;
}

static bool take_rate(struct ctl_options *options, const char *text)
{
    return number_parse_real(text, RATE_MIN_HZ, RATE_MAX_HZ, &options->rate_hz);
}

static bool take_duration(struct ctl_options *options, const char *text)
{
    return number_parse_real(text, 0.001, DURATION_MAX_S, &options->duration_s);
}

static bool take_shape(struct ctl_options *options, const char *text)
{
    options->shape = text;
    return *text != '\0';
}

static bool take_lines(struct ctl_options *options, const char *text)
{
    int64_t lines = 0;
    const bool good = number_parse_int(text, 1, 32767, &lines);
    options->lines = (uint32_t)lines;
    return good;
}

static bool take_force(struct ctl_options *options, const char *text)
{
    (void)text;
    options->force = true;
    return true;
}

static bool take_subnet(struct ctl_options *options, const char *text)
{
    options->subnet = text;
    return *text != '\0';
}

static const struct option table[] = {
    {"host", "HOST[:PORT]", OWN_SESSION, take_host,
     "an address of a sensor, such as 10.42.0.37 or localhost:5517",
     "the sensor (default 10.42.0.37)"},
    {"port", "N", OWN_SESSION, take_port, "a port from 1 to 65535",
     "its port (default 5517)"},
    {"interface", "NAME", OWN_SESSION, take_interface,
     "the name of an interface", "reach the sensor there alone"},
    {"timeout", "MS", OWN_SESSION, take_timeout,
     "a whole number of milliseconds from 1 to 60000",
     "wait for an answer, milliseconds (default 400)"},
    {"retries", "N", OWN_SESSION, take_retries, "a whole number from 0 to 100",
     "further tries without an answer (default 4)"},
    {"profile", "FILE", OWN_SESSION, take_profile, "the name of a file",
     "YAML; layout of packets, where it differs"},
    {"calibration", "FILE", 0, take_calibration, "the name of a file",
     "YAML; default: the manual's typical values"},
    {"sequence", "N", 0, take_sequence, "a whole number from 0 to 4294967295",
     "number of the first request (default: any)"},
    {"dry-run", NULL, 0, take_dry_run, NULL,
     "print the packet as a line of hex, send nothing"},
    {"json", NULL, 0, take_json, NULL, "the result as a JSON object"},
    {"quiet", NULL, 0, take_quiet, NULL, "no notes on standard error"},
    {"watch", NULL, OWN_WATCH, take_watch, NULL,
     "go on until Ctrl-C (status, time)"},
    {"trace", NULL, OWN_TRACE, take_trace, NULL,
     "name the firewall rule that drops packets (doctor)"},
    {"heartbeat", NULL, OWN_HEARTBEAT, take_heartbeat, NULL,
     "be the session (shell)"},
    {"rate", "HZ", OWN_RATE, take_rate, "a number from 1 to 100",
     "heartbeats a second, default 5 (heartbeat)"},
    {"duration", "S", OWN_DURATION, take_duration,
     "a number of seconds above 0", "end after so long (heartbeat, --watch)"},
    {"shape", "SHAPE", OWN_SHAPE, take_shape, "a shape",
     "how lines are distributed (yscan)"},
    {"lines", "N", OWN_LINES, take_lines, "a whole number from 1 to 32767",
     "lines of the distribution (yscan)"},
    {"force", NULL, OWN_FORCE, take_force, NULL,
     "an address by which it may be lost, too (set-ip)"},
    {"subnet", "ADDRESS/BITS", OWN_SUBNET, take_subnet,
     "a subnet such as 10.42.0.0/24", "search there, a /22 at most (find)"},
};

#define OPTIONS (sizeof table / sizeof table[0])

bool options_allow_host(const struct ctl_options *options, const char *text,
                        lum_error *why)
{
    if (!options->no_names || !host_is_name(text)) {
        return true;
    }
    (void)lum_error_set(why,
                        "'%.80s': no name is looked up while this shell keeps "
                        "a sensor alive, since its heartbeats would stop "
                        "meanwhile; give the address, such as 10.42.0.38",
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
        (void)lum_error_set(why,
                            "'%.80s': no sensor can have this address; usual "
                            "is 10.42.0.37",
                            text);
        return false;
    }
    return true;
}

const char *options_name(unsigned own)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        if ((table[i].own & own) != 0) {
            return table[i].name;
        }
    }
    return "";
}

void options_help(bool general, unsigned own)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        const struct option *o = &table[i];
        char name[24];
        const bool is_general = o->own == 0 || o->own == OWN_SESSION;
        if (is_general ? !general : (o->own & own) == 0) {
            continue;
        }
        (void)snprintf(name, sizeof name, "--%s", o->name);
        help_row(name, o->value, o->help);
    }
    if (general) {
        help_row("-q, -h, --version", NULL, "--quiet, --help, the version");
    }
}

/* The options given, being read. */
struct reader {
    const char *help; /* what tells more */
    struct ctl_options *options;
    struct options_found *found;
    char **words;
    int count;
    int next;
};

static enum exit_status complain_unknown(const struct reader *r,
                                         const char *word, size_t len)
{
    const char *names[OPTIONS];
    char name[32];
    (void)snprintf(name, sizeof name, "%.*s", (int)(len < 31 ? len : 31), word);
    for (size_t i = 0; i < OPTIONS; i++) {
        names[i] = table[i].name;
    }
    const char *near = nearest(name, names, OPTIONS);
    return ctl_complain(EXIT_BAD, "--%s: no such option%s%s; see %s", name,
                        near != NULL ? "; did you mean --" : "",
                        near != NULL ? near : "", r->help);
}

static const struct option *find(const char *name, size_t len)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        if (strlen(table[i].name) == len &&
            memcmp(table[i].name, name, len) == 0) {
            return &table[i];
        }
    }
    return NULL;
}

/* The value behind '=', or the next word. NULL: there is none. */
static const char *find_value(struct reader *r, const char *behind)
{
    if (*behind == '=') {
        return behind + 1;
    }
    return r->next < r->count ? r->words[r->next++] : NULL;
}

static enum exit_status take(struct reader *r, const struct option *o,
                             const char *behind)
{
    const char *value = NULL;
    if (o->value == NULL && *behind == '=') {
        return ctl_complain(EXIT_BAD, "--%s takes no value: '%s'", o->name,
                            behind + 1);
    }
    if (o->value != NULL) {
        value = find_value(r, behind);
        if (value == NULL) {
            return ctl_complain(EXIT_BAD, "--%s: a value is missing: %s",
                                o->name, o->allowed);
        }
    }
    r->options->refusal.text[0] = '\0';
    if (!o->take(r->options, value)) {
        const char *why = r->options->refusal.text;
        return *why != '\0' ? ctl_complain(EXIT_BAD, "--%s: %s", o->name, why)
                            : ctl_complain(EXIT_BAD, "--%s: '%s' is not %s",
                                           o->name, value, o->allowed);
    }
    r->found->own |= o->own;
    return EXIT_DONE;
}

static enum exit_status take_long(struct reader *r, const char *name)
{
    const size_t len = strcspn(name, "=");
    if (strcmp(name, "help") == 0) {
        r->found->wants_help = true;
        return EXIT_DONE;
    }
    if (strcmp(name, "version") == 0) {
        r->found->wants_version = true;
        return EXIT_DONE;
    }
    const struct option *o = find(name, len);
    return o != NULL ? take(r, o, name + len) : complain_unknown(r, name, len);
}

static enum exit_status take_short(struct reader *r, const char *letters)
{
    for (; *letters != '\0'; letters++) {
        if (*letters == 'h') {
            r->found->wants_help = true;
        } else if (*letters == 'q') {
            r->options->quiet = true;
        } else {
            return ctl_complain(EXIT_BAD, "-%c: no such option; see %s",
                                *letters, r->help);
        }
    }
    return EXIT_DONE;
}

/* A minus before a digit or a point belongs to a number; alone it is a file. */
static bool is_word(const char *text)
{
    return text[0] != '-' || text[1] == '\0' ||
           strchr(".0123456789", text[1]) != NULL;
}

static void keep(struct reader *r, char *word)
{
    r->words[r->found->count++] = word;
}

enum exit_status options_parse(struct ctl_options *options, const char *help,
                               int count, char **words,
                               struct options_found *out)
{
    struct reader r = {help, options, out, words, count, 0};
    enum exit_status status = EXIT_DONE;
    *out = (struct options_found){0};
    while (status == EXIT_DONE && r.next < count) {
        char *word = words[r.next++];
        if (is_word(word)) {
            keep(&r, word);
        } else if (strcmp(word, "--") == 0) {
            while (r.next < count) {
                keep(&r, words[r.next++]);
            }
        } else if (word[1] == '-') {
            status = take_long(&r, word + 2);
        } else {
            status = take_short(&r, word + 1);
        }
    }
    return status;
}
