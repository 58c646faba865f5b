#include "input_files.h"

#include "same_file.h"

#include <string.h>

int input_files_check(const struct input_file *inputs, size_t count,
                      const char *output, lum_error *error)
{
    for (size_t i = 0; i < count; i++) {
        if (inputs[i].path == NULL || !same_file(inputs[i].path, output)) {
            continue;
        }
        return strcmp(output, "-") == 0
                   ? lum_error_set(error,
                                   "standard output is %s, which this run "
                                   "reads: lead it elsewhere",
                                   inputs[i].what)
                   : lum_error_set(error,
                                   "%s is %s, which this run reads: name "
                                   "another output",
                                   output, inputs[i].what);
    }
    return 0;
}
