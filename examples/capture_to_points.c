/* A capture to points: capture_to_points CAPTURE. Needs lumsdk::frame. */
#include "lum/frame/reader.h"

#include <stdio.h>

int main(int argc, char **argv)
{
    lum_reader_options options = {.struct_size = sizeof options};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error;
    if (argc != 2) {
        (void)fputs("usage: capture_to_points CAPTURE\n", stderr);
        return 2;
    }
    options.path = argv[1];
    int status = lum_reader_open(&options, &reader, &error);
    while (status >= 0 &&
           (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
        const float *y = lum_frame_floats(frame, LUM_COLUMN_Y);
        const float *z = lum_frame_floats(frame, LUM_COLUMN_Z);
        for (size_t i = 0; i < lum_frame_count(frame); i += 10000) {
            (void)printf("%.3f %.3f %.3f\n", x[i], y[i], z[i]);
        }
    }
    if (status < 0) { /* what came before has been printed */
        (void)fprintf(stderr, "capture_to_points: %s\n", error.text);
    }
    lum_reader_close(reader);
    return status < 0 || fflush(stdout) != 0;
}
