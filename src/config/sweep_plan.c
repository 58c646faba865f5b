#include "sweep_plan.h"

#include "host/keys_internal.h"
#include "settings_keys.h"
#include "yaml.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    VERSION,
    STEPS,
    FILE_VALUES
};
enum {
    RECORD = LUM_SETTINGS_VALUES,
    RECORD_FRAMES,
    SETTLE,
    STEP_VALUES
};

#define MS(n)     ((n)*INT64_C(1000))
#define NS_PER_MS INT64_C(1000000)

/* In milliseconds: up to a day, and up to an hour. */
static const lum_key_rule seconds = {
    .min = 100, .max = MS(86400), .decimals = 3, .unit = "s"};
static const lum_key_rule settle = {
    .min = 0, .max = MS(3600), .decimals = 3, .unit = "s"};
static const lum_key_rule frames = {.min = 1, .max = 1000000, .whole = true};
static const lum_key_rule steps = {
    .min = 0, .max = -1, .allowed = "a list of steps, each begun by '-'"};

/* A plan that is being read. */
typedef struct plan {
    const char *name;
    const lum_settings_keys *keys;
    const lum_key_value *values;
    lum_sweep *out;
    lum_error *error;
} plan;

static bool has_any(const lum_settings *settings)
{
    bool has = settings->has_shape;
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        has = has || settings->has[id];
    }
    return has;
}

static void take_one(lum_settings *out, const lum_settings *from, unsigned id)
{
    if (from->has[id]) {
        out->has[id] = true;
        out->value[id] = from->value[id];
    }
}

void lum_sweep_merge(lum_settings *all, const lum_settings *later)
{
    const bool has_scan = later->has_shape || later->has[LUM_COMMAND_YSCAN];
    if (has_scan || later->has[LUM_COMMAND_LINE_MODE]) {
        all->has_shape = false;
    }
    if (has_scan) {
        all->has[LUM_COMMAND_YSCAN] = false;
    }
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        take_one(all, later, id);
    }
    if (later->has_shape) {
        all->has_shape = true;
        all->shape = later->shape;
    }
}

static void add_step(lum_sweep *out, lum_sweep_step *step)
{
    if (out->count > 0) {
        const lum_settings *before = &out->steps[out->count - 1u].all;
        step->all = *before;
        if (step->settings.has_shape &&
            !step->settings.has[LUM_COMMAND_LINE_MODE]) {
            take_one(&step->settings, before, LUM_COMMAND_LINE_MODE);
        }
    }
    lum_sweep_merge(&step->all, &step->settings);
    out->steps[out->count++] = *step;
}

static int take_step(void *context, unsigned number, unsigned line)
{
    plan *p = context;
    const lum_key_value *v = p->values;
    lum_sweep_step step = {.record_ns = v[RECORD].number * NS_PER_MS,
                           .frames = (uint32_t)v[RECORD_FRAMES].number,
                           .settle_ns = v[SETTLE].number * NS_PER_MS};
    char at[32];
    (void)snprintf(at, sizeof at, "steps.%u", number);
    if (lum_settings_keys_take(p->keys, p->name, at, v, &step.settings,
                               p->error) != 0) {
        return -1;
    }
    if (v[RECORD].place != 0 && v[RECORD_FRAMES].place != 0) {
        return lum_yaml_fail(p->error, p->name, line, at,
                             "record.seconds and record.frames: give one");
    }
    if (v[RECORD].place == 0 && v[RECORD_FRAMES].place == 0 &&
        !has_any(&step.settings)) {
        return lum_yaml_fail(p->error, p->name, line, at,
                             "neither a setting nor record");
    }
    add_step(p->out, &step);
    return 0;
}

static int read_plan(const lum_yaml_source *source, lum_sweep *out,
                     lum_error *error)
{
    static const lum_key_entry entries[] = {
        {"version", VERSION, &lum_key_version}, {"steps", STEPS, &steps}};
    const lum_key_table table = {entries, sizeof entries / sizeof entries[0]};
    lum_key_value file[FILE_VALUES] = {{0, 0}};
    lum_key_value values[STEP_VALUES];
    lum_settings_keys keys;
    plan p = {source->name, &keys, values, out, error};
    lum_settings_keys_init(&keys);
    keys.entries[keys.count++] = (lum_key_entry){"record", RECORD, &seconds};
    keys.entries[keys.count++] =
        (lum_key_entry){"record.seconds", RECORD, &seconds};
    keys.entries[keys.count++] =
        (lum_key_entry){"record.frames", RECORD_FRAMES, &frames};
    keys.entries[keys.count++] = (lum_key_entry){"settle", SETTLE, &settle};
    const lum_key_table step = {keys.entries, keys.count};
    const lum_yaml_list list = {"steps",         &step,     values, STEP_VALUES,
                                LUM_SWEEP_STEPS, take_step, &p,     NULL};
    if (lum_yaml_read_list(source, &table, file, &list, error) != 0) {
        return -1;
    }
    return out->count > 0
               ? 0
               : lum_yaml_fail(error, source->name, file[STEPS].place, "steps",
                               "the list is empty; give at least one step");
}

int lum_sweep_parse(const char *text, size_t len, const char *name,
                    lum_sweep *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    *out =
        (lum_sweep){.steps = calloc(LUM_SWEEP_STEPS, sizeof(lum_sweep_step))};
    if (out->steps == NULL) {
        return lum_yaml_fail(error, name, 0, NULL, "out of memory");
    }
    if (read_plan(&source, out, error) != 0) {
        lum_sweep_free(out);
        return -1;
    }
    return 0;
}

int lum_sweep_load(const char *path, lum_sweep *out, lum_error *error)
{
    lum_yaml_file *file = lum_yaml_load(path, error);
    *out = (lum_sweep){.steps = NULL};
    return file == NULL
               ? -1
               : lum_yaml_end(file, lum_sweep_parse(file->bytes, file->len,
                                                    file->name, out, error));
}

void lum_sweep_free(lum_sweep *sweep)
{
    free(sweep->steps);
    *sweep = (lum_sweep){.steps = NULL};
}
