/* bench_points [directions]: datagrams in memory to assembled lines to 16-byte
 * points, against memcpy of as many bytes: interleaved rounds, one thread,
 * buffers reused. With the word, the time of a pixel's direction alone. Says by
 * which vectors, of which LUM_CPU chooses others. */
#include "datagrams.h"

#include "lum/points.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The compiler must believe that somebody reads and writes what p points to. */
static void escape(void *p)
{
    __asm__ volatile("" : : "r"(p) : "memory");
}

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

static void run(struct consumer *c, const lum_layout *layout,
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

static void measure(uint32_t words_a_pixel)
{
    static lum_line_slot slots[8];
    static uint32_t words[8u * 16384u];
    static lum_reach reach[2u * 8u];
    static const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    static struct consumer consumer;
    lum_layout layout;
    lum_calibration calibration;
    lum_assembler_config config;
    double ours[ROUNDS];
    double copied[ROUNDS];
    const size_t bytes = POINTS * sizeof(lum_point);
    const uint32_t lines = POINTS / LUM_LINE_PIXELS / words_a_pixel;
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lum_assembler_config_default(&config);
    struct stream stream = stream_make(&layout, words_a_pixel, lines);
    /* a line's worth of room behind the last point, as the API asks */
    consumer.points = allocate(bytes + 16384u * sizeof(lum_point));
    uint8_t *from = allocate(bytes);
    uint8_t *to = allocate(bytes);
    memset(consumer.points, 1, bytes);
    memset(from, 1, bytes);
    memset(to, 2, bytes);
    escape(consumer.points);
    escape(from);
    escape(to);
    if (lum_projector_init(&consumer.projector, &calibration, &layout) !=
        LUM_OK) {
        stop("no projector");
    }
    for (unsigned round = 0; round < ROUNDS; round++) {
        if (lum_assembler_init(&consumer.assembler, &config, &layout,
                               &storage) != LUM_OK) {
            stop("no assembler");
        }
        double begin = now_s();
        run(&consumer, &layout, &stream);
        ours[round] =
            (double)consumer.count * sizeof(lum_point) / (now_s() - begin);
        begin = now_s();
        memcpy(to, from, bytes);
        escape(to);
        copied[round] = (double)bytes / (now_s() - begin);
    }
    const double a = median(ours);
    const double b = median(copied);
    (void)printf("%u words a pixel: %zu points, %.2f GB/s of points, memcpy "
                 "%.2f GB/s, ratio %.3f\n",
                 words_a_pixel, consumer.count, a * 1e-9, b * 1e-9, a / b);
    stream_free(&stream);
    free(consumer.points);
    free(from);
    free(to);
}

/* Of lines that stay in the first-level cache. */
static void measure_directions(void)
{
    const unsigned times = 20000;
    static lum_angle angles[LUM_LINE_PIXELS];
    static lum_direction directions[LUM_LINE_PIXELS];
    const lum_line line = {.angles = angles};
    lum_projector projector;
    lum_layout layout;
    lum_calibration calibration;
    double ns[ROUNDS];
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    if (lum_projector_init(&projector, &calibration, &layout) != LUM_OK) {
        stop("no projector");
    }
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        angles[i] = (lum_angle){(int16_t)(65 * (int)i - 32500),
                                (int16_t)(31 * (int)i - 15000)};
    }
    for (unsigned round = 0; round < ROUNDS; round++) {
        const double begin = now_s();
        for (unsigned i = 0; i < times; i++) {
            escape(angles);
            lum_directions_compute(&projector, &line, directions);
            escape(directions);
        }
        ns[round] = (now_s() - begin) * 1e9 / times / LUM_LINE_PIXELS;
    }
    (void)printf("directions by %s: %.3f ns a pixel\n", lum_points_vectors(),
                 median(ns));
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "directions") == 0) {
        measure_directions();
        return 0;
    }
    (void)printf("by %s\n", lum_points_vectors());
    measure(1);
    measure(2);
    measure(4);
    return 0;
}
