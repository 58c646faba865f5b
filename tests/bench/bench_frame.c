/* Datagrams in memory to frames with columns x y z, and with all columns,
 * against the same datagrams to lines and 16-byte points (bench_points):
 * interleaved rounds, one thread, points a second of processor time. */
#include "datagrams.h"

#include "lum/frame/framer.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_WORDS 16384u

#define RUN_NS INT64_C(10000000000) /* longer than any */

struct consumer {
    lum_assembler assembler;
    lum_projector projector;
    lum_direction directions[LUM_LINE_PIXELS];
    lum_point *points;
    size_t count;
    lum_point_losses losses;
};

static void take_line(struct consumer *c)
{
    const lum_line *line = lum_assembler_line(&c->assembler);
    lum_directions_compute(&c->projector, line, c->directions);
    c->count += lum_points_compute(&c->projector, line, c->directions,
                                   c->points + c->count, &c->losses);
}

static void run_points(struct consumer *c, const lum_layout *layout,
                       const struct stream *s)
{
    lum_group group;
    lum_result r = LUM_OK;
    c->count = 0;
    for (size_t i = 0; i < s->count; i++) {
        if (lum_packet_decode(layout, s->bytes + s->datagrams[i].at,
                              s->datagrams[i].len, &group) != LUM_PACKET_DATA) {
            stop("no data");
        }
        while ((r = lum_assembler_push(&c->assembler, &group, 0)) > 0) {
            if (r == LUM_LINE_READY) {
                take_line(c);
            }
        }
    }
    while ((r = lum_assembler_flush(&c->assembler)) > 0) {
        if (r == LUM_LINE_READY) {
            take_line(c);
        }
    }
}

static size_t count_frame(const lum_framer *framer, lum_framer_event event)
{
    if (event != LUM_FRAMER_FRAME) {
        stop("out of memory");
    }
    return lum_frame_count(lum_framer_frame(framer, 0));
}

/* Each run is later than the one before, as if the sensor had started anew. */
static size_t run_frames(lum_framer *framer, const struct stream *s)
{
    static int64_t begin_ns;
    lum_framer_event event = LUM_FRAMER_NONE;
    size_t count = 0;
    for (size_t i = 0; i < s->count; i++) {
        const lum_record record = {.payload = s->bytes + s->datagrams[i].at,
                                   .len = s->datagrams[i].len,
                                   .time_ns =
                                       begin_ns + s->datagrams[i].arrival_ns,
                                   .source = 1,
                                   .source_port = LUM_PORT,
                                   .kind = LUM_RECORD_DATAGRAM};
        while ((event = lum_framer_push(framer, &record, NULL)) !=
               LUM_FRAMER_NONE) {
            count += count_frame(framer, event);
        }
    }
    while ((event = lum_framer_flush(framer)) != LUM_FRAMER_NONE) {
        count += count_frame(framer, event);
    }
    begin_ns += RUN_NS;
    return count;
}

static lum_framer *make_framer(lum_columns columns)
{
    lum_framer *framer = NULL;
    lum_error error = {""};
    lum_view view;
    lum_view_default(&view);
    view.columns = columns;
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = &view, .view_count = 1};
    if (lum_framer_new(&options, &framer, &error) != 0) {
        stop(error.text);
    }
    return framer;
}

/* Points a second. */
static double time_frames(lum_framer *framer, const struct stream *s,
                          size_t expected)
{
    const double begin = processor_s();
    const size_t count = run_frames(framer, s);
    const double seconds = processor_s() - begin;
    if (count != expected) {
        stop("frames have other points than lines have");
    }
    return (double)count / seconds;
}

static double time_points(struct consumer *c, const lum_layout *layout,
                          const struct stream *s)
{
    static lum_line_slot slots[8];
    static uint32_t words[8u * LINE_WORDS];
    static lum_reach reach[2u * 8u];
    static const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    lum_assembler_config config;
    lum_assembler_config_default(&config);
    if (lum_assembler_init(&c->assembler, &config, layout, &storage) !=
        LUM_OK) {
        stop("no assembler");
    }
    const double begin = processor_s();
    run_points(c, layout, s);
    return (double)c->count / (processor_s() - begin);
}

static void measure(uint32_t words_a_pixel)
{
    static struct consumer consumer;
    lum_layout layout;
    lum_calibration calibration;
    double points[ROUNDS];
    double xyz[ROUNDS];
    double all[ROUNDS];
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    struct stream stream = stream_make(
        &layout, words_a_pixel, POINTS / LUM_LINE_PIXELS / words_a_pixel);
    consumer.points = allocate((POINTS + LINE_WORDS) * sizeof(lum_point));
    memset(consumer.points, 1, POINTS * sizeof(lum_point));
    if (lum_projector_init(&consumer.projector, &calibration, &layout) !=
        LUM_OK) {
        stop("no projector");
    }
    lum_framer *of_xyz = make_framer(LUM_COLUMNS_XYZ);
    lum_framer *of_all = make_framer(LUM_COLUMNS_ALL);
    for (unsigned round = 0; round < ROUNDS; round++) {
        points[round] = time_points(&consumer, &layout, &stream);
        xyz[round] = time_frames(of_xyz, &stream, consumer.count);
        all[round] = time_frames(of_all, &stream, consumer.count);
    }
    const double a = median(points);
    const double b = median(xyz);
    (void)printf(
        "%u words a pixel: %.0f M points/s in frames of x y z, %.0f of "
        "all columns, %.0f in lines, ratio %.3f\n",
        words_a_pixel, b * 1e-6, median(all) * 1e-6, a * 1e-6, b / a);
    lum_framer_free(of_xyz);
    lum_framer_free(of_all);
    stream_free(&stream);
    free(consumer.points);
}

/* bench_frame [WORDS]: only captures of so many words a pixel. */
int main(int argc, char **argv)
{
    for (uint32_t words = 1; words <= 4; words *= 2) {
        if (argc < 2 || strtoul(argv[1], NULL, 10) == words) {
            measure(words);
        }
    }
    return 0;
}
