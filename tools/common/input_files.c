#include "input_files.h"

#include "file_look.h"

#include <string.h>

bool input_files_is_same(const char *input, const char *output)
{
    struct file_look i;
    struct file_look o;
    return file_look_input(input, &i) && file_look(output, &o) &&
           i.kind == FILE_REGULAR && o.kind == FILE_REGULAR &&
           file_look_is_same(&i, &o);
}

int input_files_check(const struct input_file *inputs, size_t count,
                      const char *output, lum_error *error)
{
    for (size_t i = 0; i < count; i++) {
        if (inputs[i].path == NULL ||
            !input_files_is_same(inputs[i].path, output)) {
            continue;
        }
        return strcmp(output, "-") == 0
                   ? lum_error_set(error,
                                   "standard output is %s, which this run "
                                   "reads: redirect it elsewhere",
                                   inputs[i].what)
                   : lum_error_set(error,
                                   "%s is %s, which this run reads: name "
                                   "another output",
                                   output, inputs[i].what);
    }
    return 0;
}

/* A regular file can be opened again. */
bool input_files_is_stdin(const char *path)
{
    struct file_look file;
    struct file_look standard;
    return strcmp(path, "-") == 0 ||
           (file_look_input(path, &file) && file_look_input("-", &standard) &&
            file.kind != FILE_REGULAR && (file.volume | file.number) != 0 &&
            file_look_is_same(&file, &standard));
}

int input_files_check_once(const struct input_file *inputs, size_t count,
                           lum_error *error)
{
    const char *first = NULL;
    for (size_t i = 0; i < count; i++) {
        if (inputs[i].path == NULL || !input_files_is_stdin(inputs[i].path)) {
            continue;
        }
        if (first != NULL) {
            return lum_error_set(error,
                                 "standard input can be read only once: %s and "
                                 "%s both name it",
                                 first, inputs[i].what);
        }
        first = inputs[i].what;
    }
    return 0;
}
