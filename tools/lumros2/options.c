#include "options.h"

#include "../common/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_MIN      0.001 /* beside 0 */
#define RATE_MAX      1000.0
#define DEPTH_DEFAULT 5
#define DEPTH_MAX     1000
#define DOMAIN_MAX    232 /* above it, ports are beyond 65535 */
#define READERS_MAX   1000

#define INTO(field) OPTION_INTO(struct options, field)

static const struct option_spec specs[] = {
    {"rate", .kind = OPTION_REAL, INTO(rate), .low = 0.0, .high = RATE_MAX,
     .has = offsetof(struct options, has_rate)},
    {"loop", .kind = OPTION_FLAG, INTO(loops)},
    {"domain", .kind = OPTION_WHOLE, INTO(domain), .min = 0, .max = DOMAIN_MAX},
    {"namespace", .kind = OPTION_CALL, .call = names_take_prefix, INTO(names),
     .allowed = "a namespace such as left or /vehicle/left"},
    {"remap", .kind = OPTION_CALL, .call = names_add_remap, INTO(names),
     .allowed = "FROM:=TO, two names of topics"},
    {"qos", .kind = OPTION_CALL, .call = qos_add, INTO(qos),
     .allowed = QOS_ALLOWED},
    {"depth", .kind = OPTION_WHOLE, INTO(qos.depth), .min = 1,
     .max = DEPTH_MAX},
    {"readers", .kind = OPTION_WHOLE, INTO(readers), .min = 0,
     .max = READERS_MAX},
    {"quiet", .letter = 'q', .kind = OPTION_FLAG, INTO(quiet)},
    {"verbose", .letter = 'v', .kind = OPTION_FLAG, INTO(verbose)},
    OPTION_HELP,
    {"version", .letter = 'V', .kind = OPTION_SHOW,
     .text = "lumros2 " LUM_VERSION "\n"},
};

static enum option_end refuse(const char *why)
{
    (void)fprintf(stderr, "lumros2: %s\n", why);
    return OPTIONS_REFUSED;
}

/* As nodes of ROS 2 do. */
static enum option_end choose_domain(struct options *o)
{
    const char *text = getenv("ROS_DOMAIN_ID");
    if (o->domain >= 0) {
        return OPTIONS_READ;
    }
    o->domain = 0;
    if (text == NULL || text[0] == '\0' ||
        number_parse_int(text, 0, DOMAIN_MAX, &o->domain)) {
        return OPTIONS_READ;
    }
    (void)fprintf(stderr,
                  "lumros2: ROS_DOMAIN_ID: '%.40s' is not a number from 0 to "
                  "%d\n",
                  text, DOMAIN_MAX);
    return OPTIONS_REFUSED;
}

static enum option_end check(int words, char **argv, struct options *o)
{
    if (words == 0) {
        return refuse("an MCAP file is needed, or - for standard input; see "
                      "lumros2 --help");
    }
    if (words > 1) {
        (void)fprintf(stderr, "lumros2: '%s': only one file at a time\n",
                      argv[2]);
        return OPTIONS_REFUSED;
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

enum option_end options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumros2", "lumros2 --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){.domain = -1, .qos = {.depth = DEPTH_DEFAULT}};
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    return end == OPTIONS_READ ? check(result.count, argv, out) : end;
}
