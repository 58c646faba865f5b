#include "options.h"

#include "../common/host.h"
#include "../common/option_table.h"
#include "../common/source_url.h"
#include "assets.h"
#include "lum/version.h"

#include <stdio.h>
#include <string.h>

#define SENSOR_ALLOWED "an address such as 10.42.0.37, or 10.42.0.37%eth1"

#define SPEED_MIN 0.01
#define SPEED_MAX 100.0

/* What an option goes with. */
enum {
    ANY,
    SENSOR,
    CAPTURE
};

static void show_help(void)
{
    (void)fputs(help_text, stdout);
}

static void show_version(void)
{
    (void)puts("lumview " LUM_VERSION);
}

/* Of the program and of its parts. */
static void show_licenses(void)
{
    for (size_t i = 0; i < assets_count; i++) {
        if (strcmp(assets[i].path, "/licenses.txt") == 0) {
            (void)fwrite(assets[i].bytes, 1, assets[i].len, stdout);
        }
    }
}

/* 0.0.0.0 is refused: then a Host header could not be distinguished from one by
 * another name that points here. */
static bool take_bind(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    uint32_t *address = &o->listen.address;
    return host_parse(text, address, why) && *address >> 24 != 0 &&
           *address >> 28 < 14;
}

static bool take_set(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return set_keys_add(&o->set, text, why);
}

/* A second one is shown beside the first. */
static bool take_profile(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    if (o->second != NULL) {
        (void)lum_error_set(why,
                            "at most two profiles can be shown side by side");
        return false;
    }
    *(o->profile == NULL ? &o->profile : &o->second) = text;
    return *text != '\0';
}

#define INTO(field) OPTION_INTO(struct options, field)
#define HAS(field)  .has = offsetof(struct options, field)

static const struct option_spec specs[] = {
    {"no-open", .kind = OPTION_FLAG, INTO(stays_closed)},
    {"port", .kind = OPTION_WHOLE, INTO(listen.port), .max = UINT16_MAX,
     .allowed = "a port from 0 to 65535, 0 any"},
    {"bind", .kind = OPTION_CALL, .call = take_bind, HAS(listen.has_address),
     .allowed = "one address of this host, such as 192.168.1.5"},
    {"json", .kind = OPTION_FLAG, INTO(json)},
    {"quiet", .letter = 'q', .kind = OPTION_FLAG, INTO(quiet)},
    {"laser", .kind = OPTION_FLAG, .group = SENSOR, INTO(live.laser)},
    {"interface", .kind = OPTION_TEXT, .group = SENSOR, INTO(live.interface),
     .allowed = "the name of an interface"},
    {"sensor", .kind = OPTION_TEXT, .group = CAPTURE, INTO(sensor.text),
     HAS(sensor.is_given),
     .allowed = SENSOR_ALLOWED ", or the name of a rig's sensor"},
    {"sensor-port", .kind = OPTION_WHOLE, .group = CAPTURE, INTO(sensor.port),
     .min = 1, .max = UINT16_MAX},
    {"loop", .kind = OPTION_FLAG, .group = CAPTURE, INTO(play.loops)},
    {"speed", .kind = OPTION_REAL, .group = CAPTURE, INTO(play.speed),
     .low = SPEED_MIN, .high = SPEED_MAX},
    {"paused", .kind = OPTION_FLAG, .group = CAPTURE, INTO(play.paused)},
    {"rig", .kind = OPTION_TEXT, INTO(rig_path),
     .allowed = "the name of a file of a rig"},
    {"labels", .kind = OPTION_TEXT, .group = CAPTURE, INTO(beside.labels),
     .allowed = "the name of an array of NumPy, .npy"},
    {"truth", .kind = OPTION_TEXT, .group = CAPTURE, INTO(beside.truth),
     .allowed = "the name of a capture or of an array of NumPy, .npy"},
    {"poses", .kind = OPTION_TEXT, .group = CAPTURE, INTO(beside.poses_path),
     .allowed = "the name of a file of poses"},
    {"calibration", .kind = OPTION_TEXT, INTO(calibration)},
    {"profile", .kind = OPTION_CALL, .call = take_profile,
     .allowed = "the name of a file"},
    {"set", .kind = OPTION_CALL, .call = take_set, .allowed = SET_KEYS_ALLOWED},
    {"help", .letter = 'h', .kind = OPTION_SHOW, .show = show_help},
    {"version", .kind = OPTION_SHOW, .show = show_version},
    {"licenses", .kind = OPTION_SHOW, .show = show_licenses},
};

#define OPTIONS (sizeof specs / sizeof specs[0])

static enum parsed refuse(const char *why)
{
    (void)fprintf(stderr, "lumview: %s\n", why);
    return PARSED_BAD;
}

static enum parsed check_kinds(const struct options *o,
                               const struct option_result *result)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        const unsigned source = specs[i].group;
        if (!option_table_has(result, i) || source == ANY ||
            o->is_live == (source == SENSOR)) {
            continue;
        }
        (void)fprintf(stderr, "lumview: --%s goes with %s\n", specs[i].name,
                      source == SENSOR ? "a sensor, udp://ADDRESS"
                                       : "a capture, not with a sensor");
        return PARSED_BAD;
    }
    return PARSED_RUN;
}

/* Of a rig it is a name, which is looked up in that. */
static enum parsed take_sensor(struct options *o)
{
    lum_error why = {""};
    if (!o->sensor.is_given || o->rig_path != NULL ||
        host_parse_sensor(o->sensor.text, &o->sensor.address,
                          o->sensor.interface, &why)) {
        return PARSED_RUN;
    }
    if (why.text[0] != '\0') {
        (void)fprintf(stderr, "lumview: --sensor: %s\n", why.text);
    } else {
        (void)fprintf(stderr, "lumview: --sensor: '%s' is not %s\n",
                      o->sensor.text, SENSOR_ALLOWED);
    }
    return PARSED_BAD;
}

/* What the rig's file has the place of, or cannot be yet. */
static enum parsed check_rig(const struct options *o)
{
    const char *rival = o->calibration != NULL ? "--calibration"
                        : o->profile != NULL   ? "--profile"
                        : set_keys_first(&o->set, true) != NULL ||
                                set_keys_first(&o->set, false) != NULL
                            ? "--set"
                            : NULL;
    if (o->rig_path == NULL) {
        return PARSED_RUN;
    }
    if (o->is_live) {
        return refuse("--rig goes with captures: show a live sensor by a "
                      "lumview of its own, with --calibration and --profile");
    }
    if (rival != NULL) {
        (void)fprintf(stderr,
                      "lumview: %s does not go with --rig: each sensor has its "
                      "calibration and its profile in the rig's file\n",
                      rival);
        return PARSED_BAD;
    }
    return PARSED_RUN;
}

static enum parsed take_sources(struct options *o, int count, char **words)
{
    lum_error why = {""};
    if (count == 0) {
        return refuse("no SOURCE: name captures, - for standard input, or "
                      "udp://ADDRESS; see lumview --help");
    }
    o->source = words[0];
    o->is_live = count == 1 && source_url_is_sensor(o->source);
    if (o->is_live) {
        return source_url_parse(o->source, &o->live.address, &why)
                   ? PARSED_RUN
                   : refuse(why.text);
    }
    if (sources_init(&o->sources, (const char *const *)words, (size_t)count,
                     &why) != 0) {
        return refuse(why.text);
    }
    o->source = count == 1 ? words[0] : o->sources.name;
    return PARSED_RUN;
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {"lumview", "lumview --help",
                                              specs, OPTIONS, false};
    struct option_result result;
    lum_error why = {""};
    *out = (struct options){.play.speed = 1.0};
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    if (end != OPTIONS_READ) {
        return end == OPTIONS_SHOWN ? PARSED_DONE : PARSED_BAD;
    }
    if (take_sources(out, result.count, argv + 1) != PARSED_RUN) {
        return PARSED_BAD;
    }
    if (out->live.interface != NULL &&
        !host_has_interface(out->live.interface, &why)) {
        (void)fprintf(stderr, "lumview: --interface: %s\n", why.text);
        return PARSED_BAD;
    }
    if (check_rig(out) != PARSED_RUN ||
        check_kinds(out, &result) != PARSED_RUN) {
        return PARSED_BAD;
    }
    return take_sensor(out);
}
