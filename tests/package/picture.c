/* Links the pictures of an installed copy. */
#include <lum/picture/picture.h>

#include <stdio.h>

int main(void)
{
    lum_writer *writer = NULL;
    lum_writer_options options = {.struct_size = sizeof options};
    lum_error error;

    options.format = LUM_FORMAT_PNG;
    options.picture = lum_picture_format();
    if (lum_writer_open("no-such-directory/x.png", &options, &writer, &error) ==
        0) {
        lum_writer_abort(writer);
        return 1;
    }
    (void)puts("picture");
    return 0;
}
