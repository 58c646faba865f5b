#include "file_text.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int refuse_file(const char *name, int cause, lum_error *error)
{
    if (cause == EISDIR) {
        return lum_yaml_fail(error, name, 0, NULL,
                             "is a directory; a YAML file is needed");
    }
    return lum_yaml_fail(error, name, 0, NULL, "cannot be read: %s",
                         cause != 0 ? strerror(cause) : "unknown cause");
}

static int read_file(FILE *file, lum_file_text *text, lum_error *error)
{
    errno = 0;
    text->len = fread(text->bytes, 1, sizeof text->bytes, file);
    return ferror(file) ? refuse_file(text->name, errno, error) : 0;
}

static int read_path(lum_file_text *text, lum_error *error)
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

lum_file_text *lum_file_text_load(const char *path, lum_error *error)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *name = is_stdin ? "<stdin>" : path;
    lum_file_text *text = malloc(sizeof *text);
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

void lum_file_text_free(lum_file_text *text)
{
    free(text);
}
