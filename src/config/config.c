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
    const char *name; /* for messages */
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

static int read_file(FILE *file, config_text *text, lum_error *error)
{
    errno = 0;
    text->len = fread(text->bytes, 1, sizeof text->bytes, file);
    return ferror(file) ? refuse_file(text->name, errno, error) : 0;
}

static int read_path(config_text *text, lum_error *error)
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

/* NULL: refused. */
static config_text *load(const char *path, lum_error *error)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *name = is_stdin ? "<stdin>" : path;
    config_text *text = malloc(sizeof *text);
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

/* The text was parsed. */
static int end(config_text *text, int result)
{
    free(text);
    return result;
}

int lum_calibration_load(const char *path, lum_calibration *out,
                         lum_error *error)
{
    config_text *text = load(path, error);
    return text == NULL
               ? -1
               : end(text, lum_calibration_parse(text->bytes, text->len,
                                                 text->name, out, error));
}

int lum_profile_load(const char *path, lum_profile *out, lum_error *error)
{
    config_text *text = load(path, error);
    return text == NULL ? -1
                        : end(text, lum_profile_parse(text->bytes, text->len,
                                                      text->name, out, error));
}

int lum_settings_load(const char *path, lum_settings *out, lum_error *error)
{
    config_text *text = load(path, error);
    return text == NULL ? -1
                        : end(text, lum_settings_parse(text->bytes, text->len,
                                                       text->name, out, error));
}

int lum_sweep_load(const char *path, lum_sweep *out, lum_error *error)
{
    config_text *text = load(path, error);
    *out = (lum_sweep){.steps = NULL};
    return text == NULL ? -1
                        : end(text, lum_sweep_parse(text->bytes, text->len,
                                                    text->name, out, error));
}
