/* Links the cloud files of an installed copy, and no third-party library. */
#include <lum/cloud/writer.h>

#include <stdio.h>

int main(void)
{
    lum_writer *writer = NULL;
    lum_writer_options options = {.struct_size = sizeof options};
    lum_error error;

    options.format = LUM_FORMAT_LAS;
    if (lum_writer_open("no-such-directory/x.las", &options, &writer, &error) ==
        0) {
        lum_writer_abort(writer);
        return 1;
    }
    (void)puts("cloud");
    return 0;
}
