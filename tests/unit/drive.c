#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/group.h"
#include "lum/wire.h"

#define ANGLES_MAX 334u
#define WORDS_MAX  360u

static const lum_layout *used; /* NULL: the default */

void drive_use(const lum_layout *layout)
{
    used = layout;
}

/* The angles of pixels from group.first_sample_index on, or words. */
static void add_packet(struct drive_line *out, const lum_group *group,
                       const uint32_t *words)
{
    lum_layout layout;
    size_t head = 0;
    lum_layout_default(&layout);
    layout = used != NULL ? *used : layout;
    assert_true(out->count < DRIVE_PACKETS);
    uint8_t *bytes = out->bytes[out->count];
    assert_int_equal(
        lum_group_encode(&layout, group, bytes, DRIVE_BYTES, &head), LUM_OK);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        uint8_t *to = bytes + head + (size_t)LUM_SAMPLE_BYTES * i;
        const int32_t pixel = (int32_t)(group->first_sample_index + i);
        const lum_angle angle = {
            (int16_t)(60 * pixel - 30000),
            (int16_t)(300 * (int32_t)(group->line % 64u) - 9000)};
        if (words != NULL) {
            lum_group_word_encode(&layout, words[i], to);
        } else {
            lum_angle_encode(&layout, angle, to);
        }
    }
    out->len[out->count++] =
        head + (size_t)LUM_SAMPLE_BYTES * group->num_samples;
}

/* A pixel never crosses a packet. */
static uint32_t fitting(const uint32_t *words, uint32_t left)
{
    uint32_t n = left < WORDS_MAX ? left : WORDS_MAX;
    while (n < left &&
           lum_word_pixel(words[n]) == lum_word_pixel(words[n - 1u])) {
        n--;
    }
    return n;
}

void drive_make(struct drive_line *out, unsigned eye, uint32_t line,
                uint32_t clock, const uint32_t *words, uint32_t count)
{
    lum_group g = {.line = line,
                   .clock_raw = clock,
                   .eye = (uint8_t)eye,
                   .tag = LUM_TAG_ANGLES};
    out->count = 0;
    for (uint32_t at = 0; at < LUM_LINE_PIXELS; at += g.num_samples) {
        g.first_sample_index = at;
        g.num_samples = LUM_LINE_PIXELS - at < ANGLES_MAX ? LUM_LINE_PIXELS - at
                                                          : ANGLES_MAX;
        add_packet(out, &g, NULL);
    }
    g.tag = LUM_TAG_RANGES;
    for (uint32_t at = 0; at < count; at += g.num_samples) {
        g.first_sample_index = at;
        g.num_samples = fitting(words + at, count - at);
        add_packet(out, &g, words + at);
    }
}

int32_t drive_tof(unsigned eye, uint32_t line, uint32_t pixel)
{
    return (int32_t)(2000u + 10u * pixel + 7u * (line % 64u) + 5000u * eye);
}

void drive_pixels(struct drive_line *out, unsigned eye, uint32_t line,
                  uint32_t clock, uint32_t first, uint32_t count)
{
    uint32_t words[LUM_LINE_PIXELS];
    for (uint32_t i = 0; i < count; i++) {
        words[i] =
            lum_word_make(drive_tof(eye, line, first + i), true, first + i);
    }
    drive_make(out, eye, line, clock, words, count);
}

lum_record drive_record(const struct drive_line *line, size_t packet,
                        uint32_t sensor, int64_t time_ns)
{
    return (lum_record){.time_ns = time_ns,
                        .payload = line->bytes[packet],
                        .len = line->len[packet],
                        .source = sensor,
                        .destination = DRIVE_CLIENT,
                        .source_port = LUM_PORT,
                        .destination_port = 50000,
                        .kind = LUM_RECORD_DATAGRAM};
}
