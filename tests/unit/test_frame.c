#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame_make.h"

#include "drive.h"

#include "lum/frame/framer.h"

#include <stdlib.h>
#include <string.h>

#define LINE 3u

static const struct frame_head head = {
    .frame = 3,
    .clock_us = 1500,
    .begin = {FRAME_TIME_FITTED, INT64_C(2500000000), INT64_C(250000000)},
    .complete_ns = INT64_C(500000000),
    .edges = LUM_EDGES_BOTH,
    .smooth = 31,
    .lines = 128,
    .lost_words = 9,
    .sensor = 0x0a2a0025u,
    .shown = 17};

/* A frame of one line of the green eye, with every column that is needed. */
static lum_frame *frame_of(const uint32_t *words, uint32_t count,
                           lum_edges edges)
{
    static struct drive_line line;
    lum_framer *framer = NULL;
    lum_view view;
    lum_view_default(&view);
    view.columns = FRAME_COLUMNS;
    view.selection.edges = edges;
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = &view, .view_count = 1};
    assert_int_equal(lum_framer_new(&options, &framer, NULL), 0);
    drive_make(&line, LUM_EYE_GREEN, LINE, 1500, words, count);
    for (size_t i = 0; i < line.count; i++) {
        const lum_record record = drive_record(&line, i, DRIVE_SENSOR, 1);
        assert_int_equal(lum_framer_push(framer, &record, NULL),
                         LUM_FRAMER_NONE);
    }
    assert_int_equal(lum_framer_flush(framer), LUM_FRAMER_FRAME);
    lum_frame *frame = lum_frame_keep(lum_framer_frame(framer, 0));
    lum_framer_free(framer);
    return frame;
}

/* Pixel 7 rises at 2000, falls 950 later (12.35 ns) and is alone; pixel 999
 * rises twice and falls once. */
static lum_frame *near_and_far(void)
{
    const uint32_t words[] = {
        lum_word_make(2000, true, 7),   lum_word_make(2950, false, 7),
        lum_word_make(4000, true, 999), lum_word_make(5000, false, 999),
        lum_word_make(9000, true, 999),
    };
    return frame_of(words, 5, LUM_EDGES_BOTH);
}

static void assert_bytes(const struct frame *frame, const uint8_t *want,
                         size_t want_len)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_int_equal(len, want_len);
    assert_memory_equal(bytes, want, want_len);
}

static void put_floats(uint8_t *to, const lum_frame *points, size_t i)
{
    const float xyz[3] = {lum_frame_floats(points, LUM_COLUMN_X)[i],
                          lum_frame_floats(points, LUM_COLUMN_Y)[i],
                          lum_frame_floats(points, LUM_COLUMN_Z)[i]};
    for (size_t k = 0; k < 3; k++) {
        uint32_t bits = 0;
        memcpy(&bits, &xyz[k], sizeof bits);
        for (unsigned b = 0; b < 4; b++) {
            to[4u * k + b] = (uint8_t)(bits >> 8u * b);
        }
    }
}

static void a_frame_is_the_bytes_of_its_layout(void **state)
{
    uint8_t want[] = {                                  /* head */
                      'L', 'U', 'M', 'F', 4, 0, 80, 0,  /* */
                      0, 0, 0, 0, 0, 0, 0x08, 0x40,     /* 3.0 */
                      0, 0, 0, 0, 0, 0x70, 0x97, 0x40,  /* 1500.0 */
                      0, 0, 0, 0, 0, 0, 0x04, 0x40,     /* 2.5 */
                      5, 0, 0, 0, 3, 31, 2, 0,          /* */
                      128, 0, 0, 0, 9, 0, 0, 0,         /* */
                      0x25, 0, 0x2a, 0x0a, 17, 0, 0, 0, /* */
                      0, 0, 0, 0, 0, 0, 0xe0, 0x3f,     /* 0.5 */
                      0, 0, 0, 0, 0, 0, 0xd0, 0x3f,     /* 0.25 */
                      0, 0, 0, 0, 0, 0, 0, 0,           /* */
                      /* x y z: below */
                      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, /* */
                      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, /* */
                      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, /* */
                      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, /* */
                      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, /* */
                      /* width: 12.35 ns and 13 ns */
                      0xd3, 0x04, 0, 0, 0x14, 0x05, 0, 0, 0, 0, /* */
                      /* line */
                      3, 0, 3, 0, 3, 0, 3, 0, 3, 0, /* */
                      /* pixel */
                      7, 0, 7, 0, 0xe7, 0x03, 0xe7, 0x03, 0xe7, 0x03, /* */
                      /* return, strongest */
                      0x81, 0x81, 0x81, 0x81, 2, /* */
                      /* eye, edge, returns */
                      0x07, 0x05, 0x0b, 0x05, 0x0b};
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = near_and_far();
    struct frame *frame = frame_make(pool, points, NULL, &head);
    assert_int_equal(lum_frame_count(points), 5);
    for (size_t i = 0; i < 5; i++) {
        put_floats(want + FRAME_HEAD_BYTES + 12u * i, points, i);
    }
    assert_bytes(frame, want, sizeof want);
    lum_frame_release(points);
    frame_release(frame);
    frame_pool_free(pool);
}

static void a_frame_without_points_is_its_head(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = frame_of(NULL, 0, LUM_EDGES_BOTH);
    struct frame *frame = frame_make(pool, points, NULL, &head);
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_int_equal(len, FRAME_HEAD_BYTES);
    assert_int_equal(bytes[32], 0);
    lum_frame_release(points);
    frame_release(frame);
    frame_pool_free(pool);
}

/* Arrays of a frame. */
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

/* Each array has first the points of the one, then those of the other. */
static void points_of_two_profiles_stand_one_behind_the_other(void **state)
{
    (void)state;
    const uint32_t words[] = {lum_word_make(3000, true, 5)};
    struct frame_pool *pool = frame_pool_new();
    lum_frame *one = near_and_far();
    lum_frame *other = frame_of(words, 1, LUM_EDGES_BOTH);
    struct frame *frame = frame_make(pool, one, other, &head);
    struct frame *alone[2] = {frame_make(pool, one, NULL, &head),
                              frame_make(pool, other, NULL, &head)};
    const struct arrays a = arrays_of(frame);
    size_t len = 0;
    assert_int_equal(a.count, 6);
    assert_int_equal(frame_bytes(frame, &len)[72], 1);
    for (size_t i = 0; i < 6; i++) {
        const struct arrays w = arrays_of(alone[i / 5u]);
        const size_t k = i % 5u;
        assert_memory_equal(a.xyz + 12u * i, w.xyz + 12u * k, 12);
        assert_int_equal(read16(a.width, i), read16(w.width, k));
        assert_int_equal(read16(a.line, i), read16(w.line, k));
        assert_int_equal(read16(a.pixel, i), read16(w.pixel, k));
        assert_int_equal(a.number[i], w.number[k]);
        assert_int_equal(a.bits[i], w.bits[k]);
    }
    lum_frame_release(one);
    lum_frame_release(other);
    frame_release(alone[0]);
    frame_release(alone[1]);
    frame_release(frame);
    frame_pool_free(pool);
}

/* As two frames one behind the other, and then whose they are. */
static void points_of_a_rig_are_told_by_sensor(void **state)
{
    (void)state;
    const uint8_t table[] = {
        0, 0, 0, 0, 0, 0, 0x1c, 0x40, 5, 0, 0, 0, 2, 0, 0, 0, /* 7.0 */
        0, 0, 0, 0, 0, 0, 0x08, 0x40, 0, 0, 0, 0, 4, 0, 0, 0, /* 3.0 */
        0, 0, 0, 0, 0, 0, 0xf0, 0xbf, 1, 0, 0, 0, 0, 0, 0, 0, /* -1.0 */
    };
    const uint32_t words[] = {lum_word_make(3000, true, 5)};
    struct frame_pool *pool = frame_pool_new();
    lum_frame *one = near_and_far();
    lum_frame *none = frame_of(NULL, 0, LUM_EDGES_BOTH);
    lum_frame *other = frame_of(words, 1, LUM_EDGES_BOTH);
    const struct frame_part parts[] = {
        {one, 7, 2}, {none, 3, 4}, {other, -1, 0}};
    struct frame *frame = frame_make_rig(pool, parts, 3, &head);
    struct frame *two = frame_make(pool, one, other, &head);
    size_t len = 0;
    size_t want = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    const uint8_t *points = frame_bytes(two, &want);
    assert_int_equal(len, want + sizeof table);
    assert_int_equal(bytes[39], 3);
    assert_int_equal(bytes[72], 0);
    assert_memory_equal(bytes, points, 39);
    assert_memory_equal(bytes + FRAME_HEAD_BYTES, points + FRAME_HEAD_BYTES,
                        want - FRAME_HEAD_BYTES);
    assert_memory_equal(bytes + want, table, sizeof table);
    lum_frame_release(one);
    lum_frame_release(none);
    lum_frame_release(other);
    frame_release(frame);
    frame_release(two);
    frame_pool_free(pool);
}

static void what_does_not_fit_its_field_is_the_most_it_can_be(void **state)
{
    uint32_t words[260];
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    struct frame_head much = head;
    size_t len = 0;
    for (uint32_t i = 0; i < 259; i++) {
        words[i] = lum_word_make((int32_t)(1000u + i), true, 1);
    }
    words[259] = lum_word_make(200000, false, 1); /* 2.6 us wide */
    much.lost_words = UINT64_C(1) << 33;
    lum_frame *points = frame_of(words, 260, LUM_EDGES_BOTH);
    struct frame *frame = frame_make(pool, points, NULL, &much);
    const struct arrays a = arrays_of(frame);
    assert_int_equal(a.count, 260);
    assert_int_equal(read16(a.width, 0), 65535);
    assert_int_equal(a.number[0], 0x81);   /* the strongest */
    assert_int_equal(a.number[258], 0x7f); /* 127 */
    assert_int_equal(a.bits[0] >> 2, 63);
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_memory_equal(bytes + 44, "\xff\xff\xff\xff", 4);
    lum_frame_release(points);
    frame_release(frame);
    frame_pool_free(pool);
}

static void a_buffer_is_used_again_when_nobody_needs_it(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = near_and_far();
    lum_frame *none = frame_of(NULL, 0, LUM_EDGES_BOTH);
    struct frame *first = frame_make(pool, points, NULL, &head);
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(first, &len);
    assert_ptr_equal(frame_keep(first), first);
    frame_release(first);
    struct frame *second = frame_make(pool, points, NULL, &head);
    assert_ptr_not_equal(frame_bytes(second, &len), bytes);
    frame_release(first);
    struct frame *third = frame_make(pool, none, NULL, &head);
    assert_ptr_equal(frame_bytes(third, &len), bytes);
    assert_int_equal(arrays_of(third).count, 0);
    frame_release(third);
    third = frame_make(pool, points, NULL, &head);
    assert_int_equal(arrays_of(third).count, 5);
    lum_frame_release(points);
    lum_frame_release(none);
    frame_release(second);
    frame_release(third);
    frame_pool_free(pool);
}

static void a_small_buffer_is_enlarged_for_a_large_frame(void **state)
{
    uint32_t words[3000];
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    for (uint32_t i = 0; i < 3000; i++) {
        words[i] = lum_word_make((int32_t)(1000u + i), true, i / 3u);
    }
    lum_frame *few = near_and_far();
    lum_frame *many = frame_of(words, 3000, LUM_EDGES_RISING);
    frame_release(frame_make(pool, few, NULL, &head));
    struct frame *frame = frame_make(pool, many, NULL, &head);
    const struct arrays a = arrays_of(frame);
    assert_int_equal(a.count, 3000);
    for (size_t i = 0; i < 3000; i++) {
        assert_true(x_of(&a, i) >= lum_frame_floats(many, LUM_COLUMN_X)[i] &&
                    x_of(&a, i) <= lum_frame_floats(many, LUM_COLUMN_X)[i]);
        assert_int_equal(read16(a.pixel, i), i / 3u);
    }
    lum_frame_release(few);
    lum_frame_release(many);
    frame_release(frame);
    frame_pool_free(pool);
}

static void a_frame_outlives_its_pool(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = near_and_far();
    struct frame *frame = frame_make(pool, points, NULL, &head);
    frame_pool_free(pool);
    assert_int_equal(arrays_of(frame).count, 5);
    lum_frame_release(points);
    frame_release(frame);
    frame_release(NULL);
    frame_pool_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_is_the_bytes_of_its_layout),
        cmocka_unit_test(a_frame_without_points_is_its_head),
        cmocka_unit_test(points_of_two_profiles_stand_one_behind_the_other),
        cmocka_unit_test(points_of_a_rig_are_told_by_sensor),
        cmocka_unit_test(what_does_not_fit_its_field_is_the_most_it_can_be),
        cmocka_unit_test(a_buffer_is_used_again_when_nobody_needs_it),
        cmocka_unit_test(a_small_buffer_is_enlarged_for_a_large_frame),
        cmocka_unit_test(a_frame_outlives_its_pool),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
