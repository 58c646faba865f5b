/* Datagrams in memory to assembled lines to 16-byte points, against memcpy of
 * as many bytes: interleaved rounds, one thread, buffers reused. */
#define _POSIX_C_SOURCE 200809L
#include "lum/packet.h"
#include "lum/points.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define ROUNDS         9u
#define LINES          64u
#define LINE_PERIOD_US 1562u
#define PAYLOAD_MAX    1472u
#define POINTS         (4u << 20) /* 64 MiB of points, beyond any cache */

struct datagram {
    size_t at;
    size_t len;
};

struct stream {
    uint8_t *bytes;
    size_t used;
    struct datagram *datagrams;
    size_t count;
};

static double now_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void *allocate(size_t size)
{
    void *p = malloc(size);
    if (p == NULL) {
        (void)fputs("bench_points: out of memory\n", stderr);
        exit(1);
    }
    return p;
}

/* The compiler must believe that somebody reads and writes what p points to. */
static void escape(void *p)
{
    __asm__ volatile("" : : "r"(p) : "memory");
}

static void add_packet(struct stream *s, const lum_layout *layout,
                       lum_group *group, const uint8_t *samples)
{
    size_t head = 0;
    uint8_t *out = s->bytes + s->used;
    if (lum_group_encode(layout, group, out, PAYLOAD_MAX, &head) != LUM_OK) {
        (void)fputs("bench_points: a packet cannot be encoded\n", stderr);
        exit(1);
    }
    const size_t len = (size_t)LUM_SAMPLE_BYTES * group->num_samples;
    memcpy(out + head, samples, len);
    s->datagrams[s->count++] = (struct datagram){s->used, head + len};
    s->used += head + len;
}

static void add_angles(struct stream *s, const lum_layout *layout,
                       lum_group group)
{
    uint8_t samples[334 * LUM_SAMPLE_BYTES];
    group.tag = LUM_TAG_ANGLES;
    for (uint32_t first = 0; first < LUM_LINE_PIXELS; first += 334u) {
        group.first_sample_index = first;
        group.num_samples =
            first + 334u > LUM_LINE_PIXELS ? LUM_LINE_PIXELS - first : 334u;
        for (uint32_t i = 0; i < group.num_samples; i++) {
            const int32_t azimuth = (int32_t)(first + i) * 64 - 32000;
            const int32_t elevation = 31000 - (int32_t)group.line * 1000;
            lum_angle_encode(layout,
                             (lum_angle){(int16_t)azimuth, (int16_t)elevation},
                             samples + (size_t)LUM_SAMPLE_BYTES * i);
        }
        add_packet(s, layout, &group, samples);
    }
}

static void add_ranges(struct stream *s, const lum_layout *layout,
                       lum_group group, uint32_t words_a_pixel)
{
    uint8_t samples[PAYLOAD_MAX];
    const uint32_t pixels_a_packet = 360u / words_a_pixel;
    uint32_t index = 0;
    group.tag = LUM_TAG_RANGES;
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS;) {
        group.first_sample_index = index;
        group.num_samples = 0;
        for (uint32_t k = 0; k < pixels_a_packet && pixel < LUM_LINE_PIXELS;
             k++, pixel++) {
            for (uint32_t w = 0; w < words_a_pixel; w++) {
                const int32_t tof =
                    (int32_t)(2000u + (pixel * 37u + group.line * 11u) % 9000u +
                              w * 900u);
                lum_word_encode(lum_word_make(tof, true, pixel),
                                samples + (size_t)LUM_SAMPLE_BYTES *
                                              group.num_samples);
                group.num_samples++;
            }
        }
        index += group.num_samples;
        add_packet(s, layout, &group, samples);
    }
}

static struct stream make_stream(const lum_layout *layout,
                                 uint32_t words_a_pixel, uint32_t lines)
{
    struct stream s = {0};
    const size_t packets = 3u + LUM_LINE_PIXELS / (360u / words_a_pixel) + 1u;
    s.bytes = allocate(lines * packets * PAYLOAD_MAX);
    s.datagrams = allocate(lines * packets * sizeof *s.datagrams);
    for (uint32_t i = 0; i < lines; i++) {
        lum_group group = {.eye = (uint8_t)(i % LUM_EYES),
                           .line = i / LUM_EYES % LINES,
                           .clock_raw = i / LUM_EYES * LINE_PERIOD_US};
        add_angles(&s, layout, group);
        add_ranges(&s, layout, group, words_a_pixel);
    }
    return s;
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
            exit(1);
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

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, by_value);
    return values[ROUNDS / 2u];
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
    struct stream stream = make_stream(&layout, words_a_pixel, lines);
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
        exit(1);
    }
    for (unsigned round = 0; round < ROUNDS; round++) {
        if (lum_assembler_init(&consumer.assembler, &config, &layout,
                               &storage) != LUM_OK) {
            exit(1);
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
    free(stream.bytes);
    free(stream.datagrams);
    free(consumer.points);
    free(from);
    free(to);
}

int main(void)
{
    measure(1);
    measure(2);
    measure(4);
    return 0;
}
