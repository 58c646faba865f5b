/* Links the frame library of an installed copy. */
#include <lum/frame/reader.h>

#include <stdio.h>

int main(void)
{
    lum_reader_options options = {.struct_size = sizeof options,
                                  .path = "no-such-file"};
    lum_reader *reader = NULL;
    lum_error error;
    (void)puts("frame");
    return lum_reader_open(&options, &reader, &error) == 0;
}
