/* Links io of an installed copy, and all that io needs. */
#include <lum/io/capture.h>
#include <lum/io/config.h>
#include <lum/io/writer.h>

#include <stdio.h>
#include <string.h>

int main(void)
{
    static const char text[] = "version: 1\n";
    lum_calibration calibration;
    lum_capture *capture = NULL;
    lum_writer *writer = NULL;
    lum_writer_options options = {0};
    lum_error error;

    if (lum_calibration_parse(text, strlen(text), "text", &calibration,
                              &error) != 0 ||
        lum_capture_open("no-such-file", &capture, &error) == 0) {
        return 1;
    }
    options.format = LUM_FORMAT_PNG;
    if (lum_writer_open("no-such-directory/x.png", &options, &writer, &error) ==
        0) {
        lum_writer_abort(writer);
        return 1;
    }
    (void)puts("io");
    return 0;
}
