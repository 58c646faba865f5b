#include "lum/config/rig.h"

#include "host/rig_keys.h"
#include "lum/config/config.h"
#include "yaml.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* A rig that is being read. */
typedef struct reading {
    const char *name;
    lum_rig_files *out;
    lum_error *error;
    lum_key_value values[LUM_RIG_SENSOR_VALUES]; /* of the sensor at hand */
    /* The lines of each sensor: of its keys, and where it begins. */
    unsigned lines[LUM_RIG_SENSORS_MAX][LUM_RIG_SENSOR_VALUES];
    unsigned begins[LUM_RIG_SENSORS_MAX];
} reading;

/* --- Values --- */

static bool is_from_root(const char *path)
{
#ifdef _WIN32
    return path[0] == '/' || path[0] == '\\' ||
           (path[0] != '\0' && path[1] == ':');
#else
    return path[0] == '/';
#endif
}

/* Bytes of a path up to its file's name. */
static size_t folder_len(const char *path)
{
    size_t len = strlen(path);
#ifdef _WIN32
    const char *ends = "/\\";
#else
    const char *ends = "/";
#endif
    while (len > 0 && strchr(ends, path[len - 1u]) == NULL) {
        len--;
    }
    return len;
}

/* A path of the rig's file as it is opened. */
static lum_result put_path(const char *name, const char *path,
                           char out[LUM_RIG_PATH_BYTES], lum_key_refusal *why)
{
    const size_t folder = is_from_root(path) ? 0 : folder_len(name);
    const int len =
        snprintf(out, LUM_RIG_PATH_BYTES, "%.*s%s", (int)folder, name, path);
    if (len >= 0 && (unsigned)len < LUM_RIG_PATH_BYTES) {
        return LUM_OK;
    }
    (void)snprintf(why->text, sizeof why->text,
                   "with the folder of the rig it is longer than %u bytes",
                   LUM_RIG_PATH_BYTES - 1u);
    return LUM_E_SPACE;
}

static lum_result take_text(void *context, bool is_in_list, const char *path,
                            const char *value, lum_key_refusal *why)
{
    reading *r = context;
    lum_rig *rig = &r->out->rig;
    if (!is_in_list) {
        return lum_rig_set(rig, path, value, why);
    }
    /* A sensor that has a value already is the last one until it is whole. */
    size_t i = rig->count;
    if (i > 0 && r->begins[i - 1u] == 0) {
        i--;
    }
    const lum_result result = lum_rig_set_sensor(rig, i, path, value, why);
    if (result != LUM_OK) {
        return result;
    }
    lum_rig_sensor_files *files = &r->out->sensor[i];
    if (strcmp(path, "calibration") == 0) {
        return put_path(r->name, value, files->calibration_path, why);
    }
    return strcmp(path, "profile") == 0
               ? put_path(r->name, value, files->profile_path, why)
               : LUM_OK;
}

/* The sensor is whole; one without any value is refused here. */
static int take_sensor(void *context, unsigned number, unsigned line)
{
    reading *r = context;
    const size_t i = number - 1u;
    char key[LUM_KEY_BYTES];
    if (r->out->rig.count != number) {
        (void)snprintf(key, sizeof key, "sensors.%u", number);
        return lum_yaml_fail(r->error, r->name, line, key,
                             "has no keys; each sensor needs a name and its "
                             "address");
    }
    for (size_t value = 0; value < LUM_RIG_SENSOR_VALUES; value++) {
        r->lines[i][value] = r->values[value].place;
    }
    r->begins[i] = line;
    return 0;
}

/* --- Files --- */

/* The message of a sensor's file, behind where the rig names it. */
static int refuse_file(const reading *r, size_t i, unsigned value,
                       const char *key, const lum_error *inner)
{
    char path[LUM_KEY_BYTES];
    (void)snprintf(path, sizeof path, "sensors.%u.%s", (unsigned)i + 1u, key);
    return lum_yaml_fail(r->error, r->name, r->lines[i][value], path, "%s",
                         inner->text);
}

static int load_files(const reading *r, size_t i)
{
    lum_rig_sensor_files *files = &r->out->sensor[i];
    lum_error inner = {""};
    lum_calibration_default(&files->calibration);
    lum_profile_default(&files->profile);
    if (files->calibration_path[0] != '\0' &&
        lum_calibration_load(files->calibration_path, &files->calibration,
                             &inner) != 0) {
        return refuse_file(r, i, LUM_RIG_CALIBRATION, "calibration", &inner);
    }
    return files->profile_path[0] == '\0' ||
                   lum_profile_load(files->profile_path, &files->profile,
                                    &inner) == 0
               ? 0
               : refuse_file(r, i, LUM_RIG_PROFILE, "profile", &inner);
}

/* --- The whole --- */

/* The line of what is refused. */
static unsigned line_of(const reading *r, const lum_key_refusal *why)
{
    if (why->place == 0) {
        return 0;
    }
    const size_t i = why->place - 1u;
    const char *key = strrchr(why->key, '.');
    const lum_key_entry *entry =
        key != NULL ? lum_key_table_entry(&lum_rig_sensor_keys, key + 1) : NULL;
    const unsigned line = entry != NULL ? r->lines[i][entry->index] : 0;
    return line != 0 ? line : r->begins[i];
}

static int take_rig(const reading *r, const lum_key_value *file)
{
    lum_key_refusal why;
    if (file[LUM_RIG_VERSION].place == 0) {
        return lum_yaml_fail(r->error, r->name, 1, "version",
                             "missing; a rig needs 'version: 1'");
    }
    if (lum_rig_check(&r->out->rig, &why) != LUM_OK) {
        return lum_yaml_fail(r->error, r->name, line_of(r, &why), why.key, "%s",
                             why.text);
    }
    for (size_t i = 0; i < r->out->rig.count; i++) {
        if (load_files(r, i) != 0) {
            return -1;
        }
    }
    return 0;
}

int lum_rig_parse(const char *text, size_t len, const char *name,
                  lum_rig_files *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_key_value file[LUM_RIG_FILE_VALUES] = {{0, 0}};
    reading r = {.name = name, .out = out, .error = error};
    const lum_yaml_list list = {"sensors",
                                &lum_rig_sensor_keys,
                                r.values,
                                LUM_RIG_SENSOR_VALUES,
                                LUM_RIG_SENSORS_MAX,
                                take_sensor,
                                &r,
                                take_text};
    memset(out, 0, sizeof *out);
    lum_rig_init(&out->rig);
    return lum_yaml_read_list(&source, &lum_rig_keys, file, &list, error) == 0
               ? take_rig(&r, file)
               : -1;
}

int lum_rig_load(const char *path, lum_rig_files *out, lum_error *error)
{
    lum_yaml_file *file = lum_yaml_load(path, error);
    return file == NULL
               ? -1
               : lum_yaml_end(file, lum_rig_parse(file->bytes, file->len,
                                                  file->name, out, error));
}
