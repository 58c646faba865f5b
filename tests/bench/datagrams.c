#define _POSIX_C_SOURCE 200809L
#include "datagrams.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define LINE_PERIOD_US 1562u
#define PAYLOAD_MAX    1472u

static double seconds_of(clockid_t clock)
{
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

double now_s(void)
{
    return seconds_of(CLOCK_MONOTONIC);
}

double processor_s(void)
{
    return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

void stop(const char *why)
{
    (void)fprintf(stderr, "bench: %s\n", why);
    exit(1);
}

void *allocate(size_t size)
{
    void *p = malloc(size);
    if (p == NULL) {
        stop("out of memory");
    }
    return p;
}

static void add_packet(struct stream *s, const lum_layout *layout,
                       lum_group *group, const uint8_t *samples)
{
    size_t head = 0;
    uint8_t *out = s->bytes + s->used;
    if (lum_group_encode(layout, group, out, PAYLOAD_MAX, &head) != LUM_OK) {
        stop("a packet cannot be encoded");
    }
    const size_t len = (size_t)LUM_SAMPLE_BYTES * group->num_samples;
    memcpy(out + head, samples, len);
    s->datagrams[s->count++] =
        (struct datagram){.at = s->used,
                          .len = head + len,
                          .arrival_ns = (int64_t)group->clock_raw * 1000};
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

struct stream stream_make(const lum_layout *layout, uint32_t words_a_pixel,
                          uint32_t lines)
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

void stream_free(struct stream *stream)
{
    free(stream->bytes);
    free(stream->datagrams);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, by_value);
    return values[ROUNDS / 2u];
}
