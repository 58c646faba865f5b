#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame_make.h"

#include <stdlib.h>
#include <string.h>

#define PLENTY 1000000u

static const lum_sample near_and_far[] = {
    {.x = 1.0f,
     .y = -2.0f,
     .z = 0.5f,
     .pulse_width = 12.34f,
     .pixel = 7,
     .return_number = 1,
     .number_of_returns = 2,
     .edge = 1},
    {.x = 1.5f,
     .y = -2.5f,
     .z = 0.25f,
     .pixel = 7,
     .return_number = 1,
     .number_of_returns = 2,
     .edge = 0},
    {.x = 3.0f,
     .y = -6.0f,
     .z = 1.5f,
     .pulse_width = 2.0f,
     .pixel = 999,
     .return_number = 2,
     .number_of_returns = 2,
     .edge = 1},
};

static const uint8_t near_and_last[] = {1, 0, 1}; /* strongest */

static const struct frame_head head = {.frame = 3,
                                       .clock_us = 1500,
                                       .utc_ns = INT64_C(2500000000),
                                       .complete_ns = INT64_C(500000000),
                                       .edges = LUM_EDGES_BOTH,
                                       .smooth = 31,
                                       .lines = 128,
                                       .lost_words = 9,
                                       .sensor = 0x0a2a0025u,
                                       .shown = 17};

static struct frame *make(struct frame_pool *pool, lum_edges edges)
{
    struct frame *frame = frame_begin(pool);
    assert_non_null(frame);
    assert_true(
        frame_add(frame, &(struct frame_part){.samples = near_and_far,
                                              .strongest = near_and_last,
                                              .count = 3,
                                              .edges = edges,
                                              .line = 258,
                                              .eye = 1}));
    return frame;
}

static void assert_bytes(const struct frame *frame, const uint8_t *want,
                         size_t want_len)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_int_equal(len, want_len);
    assert_memory_equal(bytes, want, want_len);
}

static void a_frame_is_the_bytes_of_its_layout(void **state)
{
    static const uint8_t want[] = {
        /* head */
        'L', 'U', 'M', 'F', 2, 0, 64, 0,  /* */
        0, 0, 0, 0, 0, 0, 0x08, 0x40,     /* 3.0 */
        0, 0, 0, 0, 0, 0x70, 0x97, 0x40,  /* 1500.0 */
        0, 0, 0, 0, 0, 0, 0x04, 0x40,     /* 2.5 */
        3, 0, 0, 0, 3, 31, 0, 0,          /* */
        128, 0, 0, 0, 9, 0, 0, 0,         /* */
        0x25, 0, 0x2a, 0x0a, 17, 0, 0, 0, /* */
        0, 0, 0, 0, 0, 0, 0xe0, 0x3f,     /* 0.5 */
        /* x y z */
        0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f,       /* */
        0, 0, 0xc0, 0x3f, 0, 0, 0x20, 0xc0, 0, 0, 0x80, 0x3e, /* */
        0, 0, 0x40, 0x40, 0, 0, 0xc0, 0xc0, 0, 0, 0xc0, 0x3f, /* */
        /* width */
        0xd2, 0x04, 0, 0, 200, 0, /* */
        /* line */
        2, 1, 2, 1, 2, 1, /* */
        /* pixel */
        7, 0, 7, 0, 0xe7, 0x03, /* */
        /* return */
        0x81, 1, 0x82, /* */
        /* eye, edge, returns */
        0x0b, 0x09, 0x0b};
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *frame = make(pool, LUM_EDGES_BOTH);
    frame_seal(frame, &head);
    assert_bytes(frame, want, sizeof want);
    frame_release(frame);
    frame_pool_free(pool);
}

static void a_frame_without_points_is_its_head(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *frame = frame_begin(pool);
    size_t len = 0;
    frame_seal(frame, &head);
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_int_equal(len, FRAME_HEAD_BYTES);
    assert_int_equal(bytes[32], 0);
    frame_release(frame);
    frame_pool_free(pool);
}

/* Arrays of a sealed frame. */
struct arrays {
    uint32_t count;
    const uint8_t *xyz;
    const uint8_t *width;
    const uint8_t *line;
    const uint8_t *pixel;
    const uint8_t *number;
    const uint8_t *bits;
};

static struct arrays arrays_of(const struct frame *frame)
{
    size_t len = 0;
    const uint8_t *b = frame_bytes(frame, &len);
    const uint32_t n = (uint32_t)b[32] | (uint32_t)b[33] << 8 |
                       (uint32_t)b[34] << 16 | (uint32_t)b[35] << 24;
    assert_int_equal(len, FRAME_HEAD_BYTES + (size_t)n * FRAME_POINT_BYTES);
    b += FRAME_HEAD_BYTES;
    return (struct arrays){.count = n,
                           .xyz = b,
                           .width = b + (size_t)12 * n,
                           .line = b + (size_t)14 * n,
                           .pixel = b + (size_t)16 * n,
                           .number = b + (size_t)18 * n,
                           .bits = b + (size_t)19 * n};
}

static unsigned read16(const uint8_t *bytes, size_t i)
{
    return bytes[2u * i] | (unsigned)bytes[2u * i + 1u] << 8;
}

static float x_of(const struct arrays *a, size_t i)
{
    const uint8_t *b = a->xyz + 12u * i;
    const uint32_t bits = (uint32_t)b[0] | (uint32_t)b[1] << 8 |
                          (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    float x = 0.0f;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void a_view_of_one_edge_has_those_points_alone(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *rising = make(pool, LUM_EDGES_RISING);
    struct frame *falling = make(pool, LUM_EDGES_FALLING);
    frame_seal(rising, &head);
    frame_seal(falling, &head);
    const struct arrays r = arrays_of(rising);
    const struct arrays f = arrays_of(falling);
    assert_int_equal(r.count, 2);
    assert_true(x_of(&r, 0) == 1.0f);
    assert_true(x_of(&r, 1) == 3.0f);
    assert_int_equal(r.bits[0] & 2, 2);
    assert_int_equal(r.bits[1] & 2, 2);
    assert_int_equal(read16(r.pixel, 1), 999);
    assert_int_equal(f.count, 1);
    assert_true(x_of(&f, 0) == 1.5f);
    assert_int_equal(f.bits[0] & 2, 0);
    frame_release(rising);
    frame_release(falling);
    frame_pool_free(pool);
}

static void what_does_not_fit_its_field_is_the_most_it_can_be(void **state)
{
    static const uint8_t strongest = 1;
    static const lum_sample sample = {.pulse_width = 655.4f,
                                      .pixel = 1,
                                      .return_number = 256,
                                      .number_of_returns = 64,
                                      .edge = 1};
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *frame = frame_begin(pool);
    struct frame_head much = head;
    size_t len = 0;
    assert_true(frame_add(frame, &(struct frame_part){.samples = &sample,
                                                      .strongest = &strongest,
                                                      .count = 1,
                                                      .edges = LUM_EDGES_BOTH,
                                                      .line = 65536}));
    much.lost_words = UINT64_C(1) << 33;
    frame_seal(frame, &much);
    const struct arrays a = arrays_of(frame);
    assert_int_equal(read16(a.width, 0), 65535);
    assert_int_equal(read16(a.line, 0), 65535);
    assert_int_equal(a.number[0], 0xff); /* 127, and the strongest */
    assert_int_equal(a.bits[0] >> 2, 63);
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_memory_equal(bytes + 44, "\xff\xff\xff\xff", 4);
    frame_release(frame);
    frame_pool_free(pool);
}

static lum_sample numbered(uint32_t i)
{
    return (lum_sample){.x = (float)i,
                        .y = (float)i + 0.25f,
                        .z = -(float)i,
                        .pulse_width = (float)(i % 600u),
                        .pixel = (uint16_t)(i % 1000u),
                        .return_number = (uint16_t)(i % 5u + 1u),
                        .number_of_returns = (uint16_t)(i % 7u),
                        .edge = 1};
}

#define LINE_POINTS 1000u

/* Lines of numbered points, each of its number. */
static void add_lines(struct frame *frame, uint32_t lines)
{
    static lum_sample samples[LINE_POINTS];
    static const uint8_t strongest[LINE_POINTS];
    for (uint32_t line = 0; line < lines; line++) {
        for (uint32_t i = 0; i < LINE_POINTS; i++) {
            samples[i] = numbered(line * LINE_POINTS + i);
        }
        assert_true(
            frame_add(frame, &(struct frame_part){.samples = samples,
                                                  .strongest = strongest,
                                                  .count = LINE_POINTS,
                                                  .edges = LUM_EDGES_RISING,
                                                  .line = line}));
    }
}

static void assert_numbered(const struct frame *frame, uint32_t count)
{
    const struct arrays a = arrays_of(frame);
    assert_int_equal(a.count, count);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(x_of(&a, i) == (float)i);
        assert_int_equal(read16(a.width, i), i % 600u * 100u);
        assert_int_equal(read16(a.line, i), i / LINE_POINTS);
        assert_int_equal(read16(a.pixel, i), i % 1000u);
        assert_int_equal(a.number[i], i % 5u + 1u);
        assert_int_equal(a.bits[i], 2u | i % 7u << 2);
    }
}

static void a_frame_grows_and_keeps_what_it_has(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *frame = frame_begin(pool);
    add_lines(frame, 300);
    assert_int_equal(frame_cut(frame), 0);
    frame_seal(frame, &head);
    assert_numbered(frame, 300000);
    frame_release(frame);
    frame_pool_free(pool);
}

static void beyond_its_bound_a_frame_is_cut_and_counts_that(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(2500);
    struct frame *frame = frame_begin(pool);
    add_lines(frame, 4);
    assert_int_equal(frame_cut(frame), 1500);
    frame_seal(frame, &head);
    assert_numbered(frame, 2500);
    frame_release(frame);
    frame_pool_free(pool);
}

static void only_points_that_were_asked_for_count_as_cut(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(1);
    struct frame *frame = make(pool, LUM_EDGES_RISING);
    assert_int_equal(frame_cut(frame), 1);
    frame_release(frame);
    frame_pool_free(pool);
}

static void a_buffer_is_used_again_when_nobody_needs_it(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *first = make(pool, LUM_EDGES_BOTH);
    size_t len = 0;
    frame_seal(first, &head);
    const uint8_t *bytes = frame_bytes(first, &len);
    assert_ptr_equal(frame_keep(first), first);
    frame_release(first);
    struct frame *second = frame_begin(pool);
    assert_ptr_not_equal(frame_bytes(second, &len), bytes);
    frame_release(first);
    struct frame *third = frame_begin(pool);
    assert_ptr_equal(frame_bytes(third, &len), bytes);
    frame_seal(third, &head);
    assert_int_equal(arrays_of(third).count, 0);
    frame_release(second);
    frame_release(third);
    frame_pool_free(pool);
}

static void a_frame_outlives_its_pool(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new(PLENTY);
    struct frame *frame = make(pool, LUM_EDGES_BOTH);
    frame_seal(frame, &head);
    frame_pool_free(pool);
    assert_int_equal(arrays_of(frame).count, 3);
    frame_release(frame);
    frame_release(NULL);
    frame_pool_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_is_the_bytes_of_its_layout),
        cmocka_unit_test(a_frame_without_points_is_its_head),
        cmocka_unit_test(a_view_of_one_edge_has_those_points_alone),
        cmocka_unit_test(what_does_not_fit_its_field_is_the_most_it_can_be),
        cmocka_unit_test(a_frame_grows_and_keeps_what_it_has),
        cmocka_unit_test(beyond_its_bound_a_frame_is_cut_and_counts_that),
        cmocka_unit_test(only_points_that_were_asked_for_count_as_cut),
        cmocka_unit_test(a_buffer_is_used_again_when_nobody_needs_it),
        cmocka_unit_test(a_frame_outlives_its_pool),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
