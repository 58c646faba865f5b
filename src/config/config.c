#include "lum/config/config.h"

#include "lum/config/settings.h"
#include "sweep.h"
#include "yaml.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A file in memory; a byte more than is accepted of any shows that it is
 * longer. */
typedef struct config_text {
    size_t len;
    char bytes[LUM_YAML_LIST_BYTES_MAX + 1u];
} config_text;

static int refuse_file(const char *name, int cause, lum_error *error)
{
    if (cause == EISDIR) {
        return lum_yaml_fail(error, name, 0, NULL,
                             "is a directory; a YAML file is needed");
    }
    return lum_yaml_fail(error, name, 0, NULL, "cannot be read: %s",
                         cause != 0 ? strerror(cause) : "unknown cause");
}

static int read_file(FILE *file, const char *name, config_text *text,
                     lum_error *error)
{
    errno = 0;
    text->len = fread(text->bytes, 1, sizeof text->bytes, file);
    return ferror(file) ? refuse_file(name, errno, error) : 0;
}

static int read_path(const char *path, config_text *text, lum_error *error)
{
    errno = 0;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return refuse_file(path, errno, error);
    }
    const int result = read_file(file, path, text, error);
    (void)fclose(file);
    return result;
}

/* NULL: refused. The caller frees the text. */
static config_text *load(const char *path, const char **name, lum_error *error)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    config_text *text = malloc(sizeof *text);
    *name = is_stdin ? "<stdin>" : path;
    if (text == NULL) {
        (void)lum_yaml_fail(error, *name, 0, NULL, "out of memory");
        return NULL;
    }
    text->len = 0;
    if ((is_stdin ? read_file(stdin, *name, text, error)
                  : read_path(path, text, error)) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

int lum_calibration_load(const char *path, lum_calibration *out,
                         lum_error *error)
{
    const char *name = NULL;
    config_text *text = load(path, &name, error);
    if (text == NULL) {
        return -1;
    }
    const int result =
        lum_calibration_parse(text->bytes, text->len, name, out, error);
    free(text);
    return result;
}

int lum_profile_load(const char *path, lum_profile *out, lum_error *error)
{
    const char *name = NULL;
    config_text *text = load(path, &name, error);
    if (text == NULL) {
        return -1;
    }
    const int result =
        lum_profile_parse(text->bytes, text->len, name, out, error);
    free(text);
    return result;
}

int lum_settings_load(const char *path, lum_settings *out, lum_error *error)
{
    const char *name = NULL;
    config_text *text = load(path, &name, error);
    if (text == NULL) {
        return -1;
    }
    const int result =
        lum_settings_parse(text->bytes, text->len, name, out, error);
    free(text);
    return result;
}

int lum_sweep_load(const char *path, lum_sweep *out, lum_error *error)
{
    const char *name = NULL;
    config_text *text = load(path, &name, error);
    *out = (lum_sweep){.steps = NULL};
    if (text == NULL) {
        return -1;
    }
    const int result =
        lum_sweep_parse(text->bytes, text->len, name, out, error);
    free(text);
    return result;
}
