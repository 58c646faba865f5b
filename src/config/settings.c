#include "lum/config/settings.h"

#include "host/keys_internal.h"
#include "settings_keys.h"
#include "yaml.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The values of a file in order; those of a shape count from YSCAN, which is a
 * field of view itself, those of a region from its own first. */
enum {
    REGION_MIN,
    REGION_MAX,
    REGION_WEIGHT,
    REGION_VALUES
};
enum {
    FOV,
    SHAPE,
    MIN,
    MAX,
    CENTER,
    SIGMA,
    REGIONS,
    YSCAN_VALUES = REGIONS + (int)LUM_YSCAN_REGIONS_MAX * REGION_VALUES
};
enum {
    VERSION,
    LASER,
    POWER,
    THRESHOLD_GREEN,
    THRESHOLD_BLUE,
    LINES,
    HOLDOFF,
    OFFSET_GREEN,
    OFFSET_BLUE,
    YSCAN,
    VALUES = YSCAN + YSCAN_VALUES
};

typedef char values_have_room[VALUES <= LUM_SETTINGS_VALUES ? 1 : -1];

/* The key of each command, and the index of its value; NULL: a file cannot have
 * it. */
static const struct command_key {
    const char *path;
    unsigned at;
} command_keys[LUM_COMMANDS] = {
    [LUM_COMMAND_POWER] = {"power", POWER},
    [LUM_COMMAND_THRESHOLD_GREEN] = {"threshold.green", THRESHOLD_GREEN},
    [LUM_COMMAND_THRESHOLD_BLUE] = {"threshold.blue", THRESHOLD_BLUE},
    [LUM_COMMAND_LINE_MODE] = {"lines", LINES},
    [LUM_COMMAND_YSCAN] = {"yscan", YSCAN + FOV},
    [LUM_COMMAND_HOLDOFF] = {"holdoff", HOLDOFF},
    [LUM_COMMAND_OFFSET_GREEN] = {"offset.green", OFFSET_GREEN},
    [LUM_COMMAND_OFFSET_BLUE] = {"offset.blue", OFFSET_BLUE},
};

/* The file's degrees are our microdegrees. */
#define MICRO(n) ((n)*INT64_C(1000000))

static const lum_key_word line_modes[] = {{"640", 0}, {"64", 1}, {NULL, 0}};
static const lum_key_word shapes[] = {{"uniform", LUM_YSCAN_UNIFORM},
                                      {"gaussian", LUM_YSCAN_GAUSSIAN},
                                      {"regions", LUM_YSCAN_REGIONS},
                                      {NULL, 0}};

static const lum_key_rule laser = {
    .refusal =
        "a file cannot switch the laser; a person who watches the sensor does, "
        "by 'lumctl laser on' or 'lumctl laser off'; leave the key out"};
static const lum_key_rule lines = {.words = line_modes, .min = 0, .max = -1};
static const lum_key_rule shape = {.words = shapes, .min = 0, .max = -1};
static const lum_key_rule elevation = {
    .min = -MICRO(90), .max = MICRO(90), .decimals = 6, .unit = "deg"};
static const lum_key_rule sigma = {
    .min = 10000, .max = MICRO(90), .decimals = 6, .unit = "deg"};
static const lum_key_rule weight = {.min = 1, .max = 1000000, .whole = true};

#define REGION_AT(n) (YSCAN + REGIONS + (unsigned)(n)*REGION_VALUES)
#define REGION(n)                                                              \
    {"yscan.regions." #n ".min_deg", REGION_AT((n)-1) + REGION_MIN,            \
     &elevation},                                                              \
        {"yscan.regions." #n ".max_deg", REGION_AT((n)-1) + REGION_MAX,        \
         &elevation},                                                          \
    {                                                                          \
        "yscan.regions." #n ".weight", REGION_AT((n)-1) + REGION_WEIGHT,       \
            &weight                                                            \
    }
#define ALL_REGIONS                                                            \
    REGION(1), REGION(2), REGION(3), REGION(4), REGION(5), REGION(6),          \
        REGION(7), REGION(8), REGION(9), REGION(10), REGION(11), REGION(12),   \
        REGION(13), REGION(14), REGION(15), REGION(16)

/* --- Keys and their rules --- */

static void make_rules(lum_settings_keys *out)
{
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command_spec *spec = &lum_command_specs[id];
        char steps[20] = "";
        if (spec->step > 1) {
            (void)snprintf(steps, sizeof steps, " in steps of %u", spec->step);
        }
        (void)snprintf(out->allowed[id], sizeof out->allowed[id], "%u to %u%s",
                       spec->min, spec->max, steps);
        out->rules[id] = (lum_key_rule){.min = spec->min,
                                        .max = spec->max,
                                        .whole = true,
                                        .allowed = out->allowed[id]};
    }
}

void lum_settings_keys_init(lum_settings_keys *out)
{
    const lum_key_rule *rule = out->rules;
    const lum_key_entry entries[] = {
        {"lines", LINES, &lines},
        {"yscan", YSCAN, &rule[LUM_COMMAND_YSCAN]},
        {"yscan.shape", YSCAN + SHAPE, &shape},
        {"yscan.min_deg", YSCAN + MIN, &elevation},
        {"yscan.max_deg", YSCAN + MAX, &elevation},
        {"yscan.center_deg", YSCAN + CENTER, &elevation},
        {"yscan.sigma_deg", YSCAN + SIGMA, &sigma},
        ALL_REGIONS,
        {"power", POWER, &rule[LUM_COMMAND_POWER]},
        {"threshold.green", THRESHOLD_GREEN,
         &rule[LUM_COMMAND_THRESHOLD_GREEN]},
        {"threshold.blue", THRESHOLD_BLUE, &rule[LUM_COMMAND_THRESHOLD_BLUE]},
        {"holdoff", HOLDOFF, &rule[LUM_COMMAND_HOLDOFF]},
        {"offset.green", OFFSET_GREEN, &rule[LUM_COMMAND_OFFSET_GREEN]},
        {"offset.blue", OFFSET_BLUE, &rule[LUM_COMMAND_OFFSET_BLUE]},
        {"laser", LASER, &laser},
    };
    make_rules(out);
    memcpy(out->entries, entries, sizeof entries);
    out->count = COUNT(entries);
}

/* A file whose values are being checked. */
typedef struct check {
    const char *name;
    const char *at; /* "": the whole file */
    const lum_key_value *values;
    lum_error *error;
} check;

#define AT_BYTES 80

/* A key as it is named in messages. */
static const char *key_of(const check *c, const char *key, char out[AT_BYTES])
{
    (void)snprintf(out, AT_BYTES, "%s%s%s", c->at, *c->at != '\0' ? "." : "",
                   key);
    return out;
}

#define FAIL(c, line, key, ...)                                                \
    lum_yaml_fail((c)->error, (c)->name, line,                                 \
                  key_of(c, key, (char[AT_BYTES]){""}), __VA_ARGS__)

/* --- Commands --- */

static int take_commands(const check *c, const lum_settings_keys *keys,
                         lum_settings *out)
{
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_key_value *v = &c->values[command_keys[id].at];
        const lum_command_spec *spec = &lum_command_specs[id];
        if (command_keys[id].path == NULL || v->place == 0) {
            continue;
        }
        if ((v->number - spec->min) % spec->step != 0) {
            return FAIL(c, v->place, command_keys[id].path,
                        "%" PRId64 " is not a step; allowed: %s", v->number,
                        keys->allowed[id]);
        }
        out->has[id] = true;
        out->value[id] = (uint16_t)v->number;
    }
    return 0;
}

#define NUMBER_BYTES 24 /* of an elevation */

/* --- The shape of the Y scan --- */

static void format_degrees(char out[NUMBER_BYTES], int64_t udeg)
{
    lum_key_text text = lum_key_text_begin(out, NUMBER_BYTES);
    lum_key_text_add_number(&text, udeg, elevation.decimals);
}

static int refuse_order(const check *c, const char *key, unsigned line,
                        int64_t low, int64_t high)
{
    char min[NUMBER_BYTES];
    char max[NUMBER_BYTES];
    format_degrees(min, low);
    format_degrees(max, high);
    return FAIL(c, line, key,
                "min_deg must be below max_deg; they are %s and %s", min, max);
}

static unsigned first_line(const lum_key_value *values, size_t count)
{
    unsigned line = 0;
    for (size_t i = 0; i < count; i++) {
        if (values[i].place != 0 && (line == 0 || values[i].place < line)) {
            line = values[i].place;
        }
    }
    return line;
}

#define LOWEST  0x01u /* bits of the keys that a shape may or must have */
#define HIGHEST 0x02u
#define MIDDLE  0x04u
#define WIDTH   0x08u
#define BANDS   0x10u

static const struct shape_spec {
    unsigned may;
    unsigned must;
} shape_specs[] = {
    [LUM_YSCAN_UNIFORM] = {LOWEST | HIGHEST, 0},
    [LUM_YSCAN_GAUSSIAN] = {LOWEST | HIGHEST | MIDDLE | WIDTH, MIDDLE | WIDTH},
    [LUM_YSCAN_REGIONS] = {BANDS, BANDS},
};

/* By their bits. */
static const struct shape_key {
    const char *name;
    unsigned at;
    unsigned count;
} shape_keys[] = {
    {"min_deg", MIN, 1},
    {"max_deg", MAX, 1},
    {"center_deg", CENTER, 1},
    {"sigma_deg", SIGMA, 1},
    {"regions", REGIONS, LUM_YSCAN_REGIONS_MAX *REGION_VALUES},
};

/* Compares the keys of the file with those of their shape. */
static int check_shape_keys(const check *c, const lum_key_value *v)
{
    const struct shape_spec *spec = &shape_specs[v[SHAPE].number];
    const char *name = shapes[v[SHAPE].number].text;
    for (unsigned i = 0; i < COUNT(shape_keys); i++) {
        const struct shape_key *key = &shape_keys[i];
        const unsigned line = first_line(v + key->at, key->count);
        char path[32];
        (void)snprintf(path, sizeof path, "yscan.%s", key->name);
        if (line != 0 && (spec->may >> i & 1u) == 0) {
            return FAIL(c, line, path,
                        "does not belong to the shape %s, line %u", name,
                        v[SHAPE].place);
        }
        if (line == 0 && (spec->must >> i & 1u) != 0) {
            return FAIL(c, v[SHAPE].place, "yscan.shape",
                        "%s needs %s beside it", name, key->name);
        }
    }
    return 0;
}

static int take_span(const check *c, const lum_key_value *v,
                     lum_yscan_shape *out)
{
    const bool has_min = v[MIN].place != 0;
    const bool has_max = v[MAX].place != 0;
    const int64_t min = has_min ? v[MIN].number : INT32_MIN;
    const int64_t max = has_max ? v[MAX].number : INT32_MAX;
    if (min >= max) {
        return refuse_order(c, "yscan.min_deg", v[MIN].place, min, max);
    }
    out->min_udeg = (int32_t)min;
    out->max_udeg = (int32_t)max;
    if (out->kind == LUM_YSCAN_GAUSSIAN &&
        (v[CENTER].number < min || v[CENTER].number > max)) {
        return FAIL(c, v[CENTER].place, "yscan.center_deg",
                    "lies outside min_deg to max_deg; the lines are "
                    "densest there, so it must be among them");
    }
    out->center_udeg = (int32_t)v[CENTER].number;
    out->sigma_udeg = (int32_t)v[SIGMA].number;
    return 0;
}

/* Inserts a region in the order of elevation. */
static void insert_region(lum_yscan_shape *s, lum_yscan_region r)
{
    size_t i = s->region_count++;
    while (i > 0 && s->regions[i - 1].max_udeg < r.max_udeg) {
        s->regions[i] = s->regions[i - 1];
        i--;
    }
    s->regions[i] = r;
}

static int take_region(const check *c, const lum_key_value *v, unsigned number,
                       lum_yscan_shape *out)
{
    const unsigned line = first_line(v, REGION_VALUES);
    char path[32];
    (void)snprintf(path, sizeof path, "yscan.regions.%u", number);
    if (v[REGION_MIN].place == 0 || v[REGION_MAX].place == 0) {
        return FAIL(c, line, path, "needs %s",
                    v[REGION_MIN].place == 0 ? "min_deg" : "max_deg");
    }
    if (v[REGION_MIN].number >= v[REGION_MAX].number) {
        return refuse_order(c, path, line, v[REGION_MIN].number,
                            v[REGION_MAX].number);
    }
    const int64_t share =
        v[REGION_WEIGHT].place == 0 ? 1 : v[REGION_WEIGHT].number;
    insert_region(out, (lum_yscan_region){(int32_t)v[REGION_MIN].number,
                                          (int32_t)v[REGION_MAX].number,
                                          (uint32_t)share});
    return 0;
}

/* Regions are sorted, so that only neighbours can overlap. */
static int refuse_overlaps(const check *c, unsigned line,
                           const lum_yscan_shape *s)
{
    for (size_t i = 1; i < s->region_count; i++) {
        char end[NUMBER_BYTES];
        char start[NUMBER_BYTES];
        format_degrees(end, s->regions[i].max_udeg);
        format_degrees(start, s->regions[i - 1].min_udeg);
        if (s->regions[i].max_udeg > s->regions[i - 1].min_udeg) {
            return FAIL(c, line, "yscan.regions",
                        "two overlap: one reaches up to %s, the next "
                        "higher begins at %s",
                        end, start);
        }
    }
    return 0;
}

static int take_regions(const check *c, const lum_key_value *v,
                        lum_yscan_shape *out)
{
    for (unsigned i = 0; i < LUM_YSCAN_REGIONS_MAX; i++) {
        const lum_key_value *r = c->values + REGION_AT(i);
        if (first_line(r, REGION_VALUES) != 0 &&
            take_region(c, r, i + 1, out) != 0) {
            return -1;
        }
    }
    return refuse_overlaps(
        c, first_line(v + REGIONS, (size_t)YSCAN_VALUES - REGIONS), out);
}

static int take_shape(const check *c, lum_settings *out)
{
    const lum_key_value *v = c->values + YSCAN;
    const unsigned line = first_line(v + SHAPE, (size_t)YSCAN_VALUES - SHAPE);
    if (line == 0) {
        return 0;
    }
    if (v[SHAPE].place == 0) {
        return FAIL(c, line, "yscan",
                    "needs a shape: uniform, gaussian or regions");
    }
    out->has_shape = true;
    out->shape.kind = (lum_yscan_kind)v[SHAPE].number;
    if (check_shape_keys(c, v) != 0) {
        return -1;
    }
    return out->shape.kind == LUM_YSCAN_REGIONS
               ? take_regions(c, v, &out->shape)
               : take_span(c, v, &out->shape);
}

/* --- The file --- */

int lum_settings_keys_take(const lum_settings_keys *keys, const char *name,
                           const char *at, const lum_key_value *values,
                           lum_settings *out, lum_error *error)
{
    const check c = {name, at, values, error};
    lum_settings s;
    memset(&s, 0, sizeof s);
    if (take_commands(&c, keys, &s) != 0 || take_shape(&c, &s) != 0) {
        return -1;
    }
    *out = s;
    return 0;
}

int lum_settings_parse(const char *text, size_t len, const char *name,
                       lum_settings *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_key_value values[VALUES];
    lum_settings_keys keys;
    memset(values, 0, sizeof values);
    lum_settings_keys_init(&keys);
    memmove(keys.entries + 1, keys.entries,
            keys.count++ * sizeof keys.entries[0]);
    keys.entries[0] = (lum_key_entry){"version", VERSION, &lum_key_version};
    const lum_key_table table = {keys.entries, keys.count};
    return lum_yaml_read(&source, &table, values, error) == 0
               ? lum_settings_keys_take(&keys, name, "", values, out, error)
               : -1;
}

int lum_settings_load(const char *path, lum_settings *out, lum_error *error)
{
    lum_yaml_file *file = lum_yaml_load(path, error);
    return file == NULL
               ? -1
               : lum_yaml_end(file, lum_settings_parse(file->bytes, file->len,
                                                       file->name, out, error));
}
