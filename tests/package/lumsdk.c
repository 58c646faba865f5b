/* Links the shared library of an installed copy, from two threads: lumsdk
 * [CAPTURE], which has points. Compiled as C++ too. */
#include <lum/base/time.h>
#include <lum/cloud/writer.h>
#include <lum/command.h>
#include <lum/frame/reader.h>
#include <lum/host/yscan_plan.h>
#include <lum/net/sensor.h>
#include <lum/packet.h>
#include <lum/version.h>

#include <pthread.h>
#include <stdio.h>
#include <string.h>

/* What a thread found; 0: all is as it should be. */
struct work {
    char path[32];
    const char *capture; /* NULL: none */
    size_t points;       /* of its frames */
    int fault;
};

static int decode(void)
{
    static const unsigned char heartbeat[LUM_HEARTBEAT_BYTES] = {
        0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8, 0, 0, 0};
    lum_layout layout;
    lum_group group;
    lum_calibration calibration;
    lum_projector projector;
    lum_sensor_options options;

    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lum_sensor_options_default(&options);
    return lum_packet_decode(&layout, heartbeat, sizeof heartbeat, &group) !=
               LUM_PACKET_HEARTBEAT ||
           lum_projector_init(&projector, &calibration, &layout) != LUM_OK ||
           lum_command_specs[0].letter == 0;
}

static int write_points(const char *path)
{
    lum_writer_options options;
    lum_sample sample;
    lum_line_samples line;
    lum_writer *writer = NULL;
    lum_error error;

    memset(&options, 0, sizeof options);
    memset(&sample, 0, sizeof sample);
    memset(&line, 0, sizeof line);
    options.struct_size = sizeof options;
    options.format = LUM_FORMAT_CSV;
    line.struct_size = sizeof line;
    line.samples = &sample;
    line.count = 1;
    if (lum_writer_open(path, &options, &writer, &error) != 0) {
        return 1;
    }
    for (int i = 0; i < 20000; i++) {
        if (lum_writer_add(writer, &line, &error) != 0) {
            lum_writer_abort(writer);
            return 1;
        }
    }
    return lum_writer_close(writer, &error) != 0 || remove(path) != 0;
}

static int read_points(const char *capture, size_t *points)
{
    lum_reader_options options;
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error;
    int status = 0;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.path = capture;
    if (lum_reader_open(&options, &reader, &error) != 0) {
        return 1;
    }
    while ((status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        if (lum_frame_floats(frame, LUM_COLUMN_X) == NULL) {
            status = -1;
            break;
        }
        *points += lum_frame_count(frame);
    }
    lum_reader_close(reader);
    return status != 0 || *points == 0;
}

static void *run(void *context)
{
    struct work *work = (struct work *)context;
    work->fault = decode() != 0 || write_points(work->path) != 0 ||
                  (work->capture != NULL &&
                   read_points(work->capture, &work->points) != 0);
    return NULL;
}

int main(int argc, char **argv)
{
    const char *capture = argc > 1 ? argv[1] : NULL;
    struct work work[2] = {{"first.csv", capture, 0, 1},
                           {"second.csv", capture, 0, 1}};
    pthread_t thread[2];

    for (int i = 0; i < 2; i++) {
        if (pthread_create(&thread[i], NULL, run, &work[i]) != 0) {
            return 1;
        }
    }
    for (int i = 0; i < 2; i++) {
        (void)pthread_join(thread[i], NULL);
    }
    (void)puts("lumsdk " LUM_VERSION);
    return work[0].fault != 0 || work[1].fault != 0 ||
           work[0].points != work[1].points;
}
