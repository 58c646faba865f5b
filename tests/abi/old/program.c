/* What script/abi --keep compiles against this version's headers and links with
 * its liblumsdk, to be run with later ones: a capture from memory to frames, a
 * cloud, a session's options. It prints the same with each. */
#include <lum/cloud/writer.h>
#include <lum/command.h>
#include <lum/frame/reader.h>
#include <lum/net/sensor.h>
#include <lum/packet.h>

#include <stdio.h>
#include <string.h>

/* A heartbeat of a sensor, over Ethernet. */
static const unsigned char capture[] = {
    0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1,
    0, 0, 0,
    /* the record */
    1, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0, 54, 0, 0, 0, 2, 0, 0, 0, 0, 1, 2, 0, 0,
    0, 0, 2, 8, 0, 0x45, 0, 0, 40, 0, 0, 0x40, 0, 64, 17, 0, 0, 10, 42, 0, 37,
    10, 42, 0, 1, 0x15, 0x8d, 0x15, 0x8d, 0, 20, 0, 0, 0xed, 0xfe, 0xf3, 0xa1,
    0xef, 0xbe, 0x34, 0x12, 8, 0, 0, 0};

struct place {
    size_t at;
};

static int64_t give(void *context, void *buffer, size_t room, lum_error *error)
{
    struct place *place = context;
    const size_t left = sizeof capture - place->at;
    const size_t n = left < room ? left : room;
    (void)error;
    memcpy(buffer, capture + place->at, n);
    place->at += n;
    return (int64_t)n;
}

static int read_frames(void)
{
    struct place place = {0};
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = give,
                                            .context = &place,
                                            .total = sizeof capture};
    lum_reader_options options = {.struct_size = sizeof options};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error = {""};
    int frames = 0;
    int status = 0;
    options.source = lum_source_from_functions("memory", &functions, &error);
    status = lum_reader_open(&options, &reader, &error);
    while (status >= 0 &&
           (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        frames++;
    }
    lum_reader_close(reader);
    (void)printf("frames: %d %s\n", frames, error.text);
    return status;
}

static int write_cloud(void)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_XYZ};
    const lum_sample sample = {.return_number = 1};
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &sample, .count = 1};
    lum_writer *writer = NULL;
    lum_error error = {""};
    if (lum_writer_open("-", &options, &writer, &error) != 0) {
        return -1;
    }
    if (lum_writer_add(writer, &line, &error) != 0) {
        lum_writer_abort(writer);
        return -1;
    }
    return lum_writer_close(writer, &error);
}

int main(void)
{
    lum_layout layout;
    lum_group group;
    lum_calibration calibration;
    lum_projector projector;
    lum_sensor_options session;
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lum_sensor_options_default(&session);
    (void)printf("packet: %d\n",
                 (int)lum_packet_decode(&layout, capture + 82, 12, &group));
    (void)printf("projector: %d\n",
                 (int)lum_projector_init(&projector, &calibration, &layout));
    (void)printf("heartbeat: %u ms\n", (unsigned)session.heartbeat_ms);
    (void)printf("first command: %c\n", lum_command_specs[0].letter);
    if (read_frames() != 0) {
        return 1;
    }
    (void)fflush(stdout);
    return write_cloud() != 0;
}
