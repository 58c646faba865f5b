/* Calibrations and profiles from YAML, and files of YAML into memory. */
#include "lum/config/config.h"

#include "host/keys_internal.h"
#include "yaml.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- Files --- */

static int refuse_file(const char *name, int cause, lum_error *error)
{
    if (cause == EISDIR) {
        return lum_yaml_fail(error, name, 0, NULL,
                             "is a directory; a YAML file is needed");
    }
    return lum_yaml_fail(error, name, 0, NULL, "cannot be read: %s",
                         cause != 0 ? strerror(cause) : "unknown cause");
}

static int read_file(FILE *file, lum_yaml_file *text, lum_error *error)
{
    errno = 0;
    text->len = fread(text->bytes, 1, sizeof text->bytes, file);
    return ferror(file) ? refuse_file(text->name, errno, error) : 0;
}

static int read_path(lum_yaml_file *text, lum_error *error)
{
    errno = 0;
    FILE *file = fopen(text->name, "rb");
    if (file == NULL) {
        return refuse_file(text->name, errno, error);
    }
    const int result = read_file(file, text, error);
    (void)fclose(file);
    return result;
}

lum_yaml_file *lum_yaml_load(const char *path, lum_error *error)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *name = is_stdin ? "<stdin>" : path;
    lum_yaml_file *text = malloc(sizeof *text);
    if (text == NULL) {
        (void)lum_yaml_fail(error, name, 0, NULL, "out of memory");
        return NULL;
    }
    text->name = name;
    text->len = 0;
    if ((is_stdin ? read_file(stdin, text, error) : read_path(text, error)) !=
        0) {
        free(text);
        return NULL;
    }
    return text;
}

int lum_yaml_end(lum_yaml_file *file, int result)
{
    free(file);
    return result;
}

/* --- Keys --- */

static int read_keys(const lum_yaml_source *source, lum_keys *keys,
                     lum_error *error)
{
    return lum_yaml_read(source, lum_keys_table(keys), keys->values, error);
}

static int refuse(const lum_yaml_source *source, const lum_key_refusal *why,
                  lum_error *error)
{
    return lum_yaml_fail(error, source->name, why->place, why->key, "%s",
                         why->text);
}

int lum_calibration_parse(const char *text, size_t len, const char *name,
                          lum_calibration *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_keys keys;
    lum_key_refusal why;
    lum_keys_of_calibration(&keys, NULL);
    if (read_keys(&source, &keys, error) != 0) {
        return -1;
    }
    return lum_keys_calibration(&keys, out, &why) == LUM_OK
               ? 0
               : refuse(&source, &why, error);
}

int lum_profile_parse(const char *text, size_t len, const char *name,
                      lum_profile *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_keys keys;
    lum_key_refusal why;
    lum_keys_of_profile(&keys, NULL);
    if (read_keys(&source, &keys, error) != 0) {
        return -1;
    }
    if (keys.values[LUM_KEYS_VERSION].place == 0) {
        return lum_yaml_fail(error, name, 1, "version",
                             "missing; a profile needs 'version: 1'");
    }
    return lum_keys_profile(&keys, out, &why) == LUM_OK
               ? 0
               : refuse(&source, &why, error);
}

int lum_calibration_load(const char *path, lum_calibration *out,
                         lum_error *error)
{
    lum_yaml_file *file = lum_yaml_load(path, error);
    return file == NULL
               ? -1
               : lum_yaml_end(file,
                              lum_calibration_parse(file->bytes, file->len,
                                                    file->name, out, error));
}

int lum_profile_load(const char *path, lum_profile *out, lum_error *error)
{
    lum_yaml_file *file = lum_yaml_load(path, error);
    return file == NULL
               ? -1
               : lum_yaml_end(file, lum_profile_parse(file->bytes, file->len,
                                                      file->name, out, error));
}
