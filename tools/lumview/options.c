#include "options.h"

#include "../common/number.h"
#include "help.h"
#include "licenses.h"
#include "lum/version.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

#define SPEED_MIN 0.01
#define SPEED_MAX 100.0

enum goes_with {
    ANY,
    SENSOR,
    CAPTURE
};

struct option {
    const char *name;
    bool has_value;
    enum goes_with source;
    bool (*take)(struct options *options, const char *text);
    const char *allowed; /* of a value */
};

static bool take_no_open(struct options *options, const char *text)
{
    (void)text;
    options->opens = false;
    return true;
}

static bool take_port(struct options *options, const char *text)
{
    int64_t port = 0;
    const bool good = number_parse_int(text, 0, UINT16_MAX, &port);
    options->port = (uint16_t)port;
    return good;
}

/* Any address at all would be too many: a Host header could not be told from
 * one that another name brought here. */
static bool take_bind(struct options *options, const char *text)
{
    options->has_bind = number_parse_address(text, &options->bind);
    return options->has_bind && options->bind >> 24 != 0 &&
           options->bind >> 28 < 14;
}

static bool take_json(struct options *options, const char *text)
{
    (void)text;
    options->json = true;
    return true;
}

static bool take_quiet(struct options *options, const char *text)
{
    (void)text;
    options->quiet = true;
    return true;
}

static bool take_laser(struct options *options, const char *text)
{
    (void)text;
    options->laser = true;
    return true;
}

static bool take_interface(struct options *options, const char *text)
{
    options->interface = text;
    return *text != '\0';
}

static bool take_sensor(struct options *options, const char *text)
{
    options->has_sensor = number_parse_address(text, &options->sensor);
    return options->has_sensor;
}

static bool take_loop(struct options *options, const char *text)
{
    (void)text;
    options->loops = true;
    return true;
}

static bool take_speed(struct options *options, const char *text)
{
    return number_parse_real(text, SPEED_MIN, SPEED_MAX, &options->speed);
}

static bool take_paused(struct options *options, const char *text)
{
    (void)text;
    options->paused = true;
    return true;
}

static bool take_calibration(struct options *options, const char *text)
{
    options->calibration = text;
    return *text != '\0';
}

static bool take_profile(struct options *options, const char *text)
{
    options->profile = text;
    return *text != '\0';
}

static const struct option table[] = {
    {"no-open", false, ANY, take_no_open, NULL},
    {"port", true, ANY, take_port, "a port from 0 to 65535, 0 any"},
    {"bind", true, ANY, take_bind,
     "one address of this host, such as 192.168.1.5"},
    {"json", false, ANY, take_json, NULL},
    {"quiet", false, ANY, take_quiet, NULL},
    {"laser", false, SENSOR, take_laser, NULL},
    {"interface", true, SENSOR, take_interface, "the name of an interface"},
    {"sensor", true, CAPTURE, take_sensor, "an address such as 10.42.0.37"},
    {"loop", false, CAPTURE, take_loop, NULL},
    {"speed", true, CAPTURE, take_speed, "a number from 0.01 to 100"},
    {"paused", false, CAPTURE, take_paused, NULL},
    {"calibration", true, ANY, take_calibration, "the name of a file"},
    {"profile", true, ANY, take_profile, "the name of a file"},
};

#define OPTIONS (sizeof table / sizeof table[0])

/* The arguments, being read. */
struct reader {
    struct options *options;
    char **words;
    int count;
    int next;
    bool is_given[OPTIONS];
};

static enum parsed refuse(const char *what, const char *why)
{
    (void)fprintf(stderr, "lumview: %s: %s\n", what, why);
    return PARSED_BAD;
}

static enum parsed take_value(struct reader *r, const struct option *o,
                              const char *behind)
{
    const char *value = NULL;
    if (*behind == '=') {
        value = behind + 1;
    } else if (r->next < r->count) {
        value = r->words[r->next++];
    } else {
        (void)fprintf(stderr, "lumview: --%s: a value is missing: %s\n",
                      o->name, o->allowed);
        return PARSED_BAD;
    }
    if (!o->take(r->options, value)) {
        (void)fprintf(stderr, "lumview: --%s: '%s' is not %s\n", o->name, value,
                      o->allowed);
        return PARSED_BAD;
    }
    return PARSED_RUN;
}

static enum parsed take(struct reader *r, size_t i, const char *behind)
{
    const struct option *o = &table[i];
    r->is_given[i] = true;
    if (o->has_value) {
        return take_value(r, o, behind);
    }
    if (*behind == '=') {
        (void)fprintf(stderr, "lumview: --%s takes no value: '%s'\n", o->name,
                      behind + 1);
        return PARSED_BAD;
    }
    (void)o->take(r->options, NULL);
    return PARSED_RUN;
}

static enum parsed print_help(void)
{
    (void)fputs(help_text, stdout);
    return PARSED_DONE;
}

static enum parsed take_long(struct reader *r, const char *word)
{
    const char *name = word + 2;
    const size_t len = strcspn(name, "=");
    if (strcmp(name, "help") == 0) {
        return print_help();
    }
    if (strcmp(name, "version") == 0) {
        (void)puts("lumview " LUM_VERSION);
        return PARSED_DONE;
    }
    if (strcmp(name, "licenses") == 0) {
        licenses_print();
        return PARSED_DONE;
    }
    for (size_t i = 0; i < OPTIONS; i++) {
        if (strlen(table[i].name) == len &&
            memcmp(table[i].name, name, len) == 0) {
            return take(r, i, name + len);
        }
    }
    return refuse(word, "no such option; see lumview --help");
}

static enum parsed take_short(struct reader *r, const char *word)
{
    if (strcmp(word, "-h") == 0) {
        return print_help();
    }
    if (strcmp(word, "-q") == 0) {
        r->options->quiet = true;
        return PARSED_RUN;
    }
    return refuse(word, "no such option; see lumview --help");
}

static enum parsed take_source(struct reader *r, const char *word)
{
    if (r->options->source != NULL) {
        (void)fprintf(stderr,
                      "lumview: one SOURCE only: '%s' is one too many\n", word);
        return PARSED_BAD;
    }
    r->options->source = word;
    return PARSED_RUN;
}

static enum parsed take_words(struct reader *r)
{
    enum parsed parsed = PARSED_RUN;
    bool has_options = true;
    while (parsed == PARSED_RUN && r->next < r->count) {
        const char *word = r->words[r->next++];
        if (!has_options || word[0] != '-' || word[1] == '\0') {
            parsed = take_source(r, word);
        } else if (strcmp(word, "--") == 0) {
            has_options = false;
        } else if (word[1] == '-') {
            parsed = take_long(r, word);
        } else {
            parsed = take_short(r, word);
        }
    }
    return parsed;
}

static enum parsed check_address(const struct options *o)
{
    const uint32_t address = o->address.address;
    return address >> 24 != 0 && address >> 28 < 14
               ? PARSED_RUN
               : refuse(o->source, "no sensor can have this address");
}

static enum parsed parse_url(struct options *o)
{
    static const char right[] = "right is udp://ADDRESS or udp://ADDRESS:PORT, "
                                "the address four numbers from 0 to 255, such "
                                "as udp://10.42.0.37";
    char address[16];
    const char *host = o->source + strlen("udp://");
    const size_t len = strcspn(host, ":");
    int64_t port = LUM_PORT;
    if (len >= sizeof address) {
        return refuse(o->source, right);
    }
    (void)memcpy(address, host, len);
    address[len] = '\0';
    if (!number_parse_address(address, &o->address.address) ||
        (host[len] == ':' &&
         !number_parse_int(host + len + 1, 1, UINT16_MAX, &port))) {
        return refuse(o->source, right);
    }
    o->address.port = (uint16_t)port;
    return check_address(o);
}

static enum parsed check_kinds(const struct reader *r)
{
    const bool is_live = r->options->is_live;
    for (size_t i = 0; i < OPTIONS; i++) {
        const enum goes_with source = table[i].source;
        if (!r->is_given[i] || source == ANY || is_live == (source == SENSOR)) {
            continue;
        }
        (void)fprintf(stderr, "lumview: --%s goes with %s\n", table[i].name,
                      source == SENSOR ? "a sensor, udp://ADDRESS"
                                       : "a capture, not with a sensor");
        return PARSED_BAD;
    }
    return PARSED_RUN;
}

static enum parsed check(const struct reader *r)
{
    struct options *o = r->options;
    if (o->source == NULL) {
        (void)fputs("lumview: no SOURCE: name a capture, - for standard input, "
                    "or udp://ADDRESS; see lumview --help\n",
                    stderr);
        return PARSED_BAD;
    }
    o->is_live = strncmp(o->source, "udp://", 6) == 0;
    if (o->is_live && parse_url(o) != PARSED_RUN) {
        return PARSED_BAD;
    }
    return check_kinds(r);
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    struct reader r = {.options = out, .words = argv, .count = argc, .next = 1};
    *out = (struct options){.opens = true, .speed = 1.0};
    const enum parsed parsed = take_words(&r);
    return parsed == PARSED_RUN ? check(&r) : parsed;
}
