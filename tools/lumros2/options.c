#include "options.h"

#include "../common/number.h"
#include "../common/option_table.h"
#include "lum/version.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_MIN      0.001 /* beside 0 */
#define RATE_MAX      1000.0
#define DEPTH_DEFAULT 5
#define DEPTH_MAX     1000
#define DOMAIN_MAX    232 /* above it, ports are beyond 65535 */
#define READERS_MAX   1000

static void show_help(void)
{
    (void)fputs(help_text, stdout);
}

static void show_version(void)
{
    (void)puts("lumros2 " LUM_VERSION);
}

static bool take_namespace(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    (void)why;
    o->names.prefix = text;
    return names_is(text);
}

static bool take_remap(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return names_add_remap(&o->names, text, why);
}

static bool take_qos(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return qos_add(&o->qos, text, why);
}

#define INTO(field) OPTION_INTO(struct options, field)

static const struct option_spec specs[] = {
    {"rate", .kind = OPTION_REAL, .group = 1, INTO(rate), .low = 0.0,
     .high = RATE_MAX, .has = offsetof(struct options, has_rate)},
    {"loop", .kind = OPTION_FLAG, .group = 1, INTO(loops)},
    {"domain", .kind = OPTION_WHOLE, .group = 1, INTO(domain), .min = 0,
     .max = DOMAIN_MAX},
    {"namespace", .kind = OPTION_CALL, .group = 1, .call = take_namespace,
     .allowed = "a namespace such as left or /vehicle/left"},
    {"remap", .kind = OPTION_CALL, .group = 1, .call = take_remap,
     .allowed = "FROM:=TO, two names of topics"},
    {"qos", .kind = OPTION_CALL, .group = 1, .call = take_qos,
     .allowed = QOS_ALLOWED},
    {"depth", .kind = OPTION_WHOLE, .group = 1, INTO(qos.depth), .min = 1,
     .max = DEPTH_MAX},
    {"readers", .kind = OPTION_WHOLE, .group = 1, INTO(readers), .min = 0,
     .max = READERS_MAX},
    {"quiet", .letter = 'q', .kind = OPTION_FLAG, .group = 1, INTO(quiet)},
    {"verbose", .letter = 'v', .kind = OPTION_FLAG, .group = 1, INTO(verbose)},
    {"help", .letter = 'h', .kind = OPTION_SHOW, .group = 1, .show = show_help},
    {"version", .letter = 'V', .kind = OPTION_SHOW, .group = 1,
     .show = show_version},
};

static enum parsed refuse(const char *why)
{
    (void)fprintf(stderr, "lumros2: %s\n", why);
    return PARSED_BAD;
}

/* As nodes of ROS 2 do. */
static enum parsed choose_domain(struct options *o)
{
    const char *text = getenv("ROS_DOMAIN_ID");
    if (o->domain >= 0) {
        return PARSED_RUN;
    }
    o->domain = 0;
    if (text == NULL || text[0] == '\0' ||
        number_parse_int(text, 0, DOMAIN_MAX, &o->domain)) {
        return PARSED_RUN;
    }
    (void)fprintf(stderr,
                  "lumros2: ROS_DOMAIN_ID: '%.40s' is not a number from 0 to "
                  "%d\n",
                  text, DOMAIN_MAX);
    return PARSED_BAD;
}

static enum parsed check(int words, char **argv, struct options *o)
{
    if (words == 0) {
        return refuse("an MCAP file is needed, or - for standard input; see "
                      "lumros2 --help");
    }
    if (words > 1) {
        (void)fprintf(stderr, "lumros2: '%s': only one file at a time\n",
                      argv[2]);
        return PARSED_BAD;
    }
    o->source = argv[1];
    const bool is_stream = strcmp(o->source, "-") == 0;
    if (is_stream && o->loops) {
        return refuse("--loop: standard input can be read only once");
    }
    if (o->rate > 0.0 && o->rate < RATE_MIN) {
        return refuse("--rate: 0, or 0.001 to 1000");
    }
    if (!o->has_rate && !is_stream) {
        o->has_rate = true;
        o->rate = 1.0;
    }
    return choose_domain(o);
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumros2", "lumros2 --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){.domain = -1, .qos = {.depth = DEPTH_DEFAULT}};
    switch (option_table_read(&table, argc, argv, out, &result)) {
    case OPTIONS_SHOWN:
        return PARSED_DONE;
    case OPTIONS_REFUSED:
        return PARSED_BAD;
    case OPTIONS_READ:
    default:
        return check(result.count, argv, out);
    }
}
