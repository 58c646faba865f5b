#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "page_frame.h"

#include "drive.h"
#include "unpacked.h"

#include "lum/frame/framer.h"

#include <math.h>

#define LINE 3u

static const lum_packed_head head = {.struct_size = sizeof head,
                                     .frame = 3,
                                     .clock_us = 1500,
                                     .time = LUM_PACKED_TIME_FITTED,
                                     .utc_ns = INT64_C(2500000000),
                                     .utc_error_ns = INT64_C(250000000),
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
    view.columns = LUM_PACKED_COLUMNS;
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

static lum_packed_part part_of(const lum_frame *frame)
{
    lum_packed_part part = {.struct_size = sizeof part};
    assert_int_equal(lum_packed_part_of(frame, &part), LUM_OK);
    return part;
}

/* other: by a second profile; NULL: there is none. */
static struct frame *make(struct frame_pool *pool, const lum_frame *one,
                          const lum_frame *other)
{
    const lum_packed_part parts[] = {part_of(one),
                                     part_of(other != NULL ? other : one)};
    return frame_make(pool, &head, parts, other != NULL ? 2 : 1);
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

static struct unpacked arrays_of(const struct frame *frame)
{
    struct unpacked out;
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_true(unpack(bytes, len, &out));
    return out;
}

static void assert_same_point(const struct unpacked *a, size_t i,
                              const struct unpacked *b, size_t k)
{
    for (size_t axis = 0; axis < 3; axis++) {
        assert_true(fabs(a->xyz[i][axis] - b->xyz[k][axis]) <= b->step[k]);
    }
    assert_int_equal(a->width[i], b->width[k]);
    assert_int_equal(a->line[i], b->line[k]);
    assert_int_equal(a->pixel[i], b->pixel[k]);
    assert_int_equal(a->turn[i], b->turn[k]);
    assert_int_equal(a->bits[i], b->bits[k]);
}

/* What is told of a frame of the library. */
static void a_frame_has_all_that_is_shown_of_its_points(void **state)
{
    static const struct {
        unsigned pixel, width, turn, bits;
    } want[] = {{7, 1235, 0x81, 0x07},
                {7, 0, 0x81, 0x05},
                {999, 1300, 0x81, 0x0b},
                {999, 0, 0x81, 0x05},
                {999, 0, 0x02, 0x0b}};
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = near_and_far();
    struct frame *frame = make(pool, points, NULL);
    struct unpacked a = arrays_of(frame);
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_int_equal(frame_piece(frame, 0), len);
    assert_int_equal(frame_piece(frame, len), 0);
    assert_true(unpacked_double(bytes, 8) == 3.0);
    assert_true(unpacked_double(bytes, 24) == 2.5);
    assert_int_equal(bytes[38], LUM_PACKED_TIME_FITTED);
    assert_int_equal(a.count, 5);
    for (size_t i = 0; i < 5; i++) {
        const double x = (double)lum_frame_floats(points, LUM_COLUMN_X)[i];
        assert_true(fabs(a.xyz[i][0] - x) <= a.step[i] / 2.0);
        assert_int_equal(a.line[i], LINE);
        assert_int_equal(a.pixel[i], want[i].pixel);
        assert_int_equal(a.width[i], want[i].width);
        assert_int_equal(a.turn[i], want[i].turn);
        assert_int_equal(a.bits[i], want[i].bits);
    }
    unpacked_free(&a);
    lum_frame_release(points);
    frame_release(frame);
    frame_pool_free(pool);
}

/* Each array has first the points of the one, then those of the other. */
static void points_of_two_profiles_stand_one_behind_the_other(void **state)
{
    (void)state;
    const uint32_t words[] = {lum_word_make(3000, true, 5)};
    struct frame_pool *pool = frame_pool_new();
    lum_frame *one = near_and_far();
    lum_frame *other = frame_of(words, 1, LUM_EDGES_BOTH);
    struct frame *frame = make(pool, one, other);
    struct frame *alone[2] = {make(pool, one, NULL), make(pool, other, NULL)};
    struct unpacked a = arrays_of(frame);
    size_t len = 0;
    assert_int_equal(a.count, 6);
    assert_int_equal(frame_bytes(frame, &len)[72], 1);
    for (size_t k = 0; k < 2; k++) {
        struct unpacked w = arrays_of(alone[k]);
        for (size_t i = 0; i < w.count; i++) {
            assert_same_point(&a, 5u * k + i, &w, i);
        }
        unpacked_free(&w);
    }
    unpacked_free(&a);
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
    lum_packed_part parts[] = {part_of(one), part_of(none), part_of(other)};
    const int64_t numbers[] = {7, 3, -1};
    const uint32_t sensors[] = {2, 4, 0};
    lum_packed_head rig = head;
    rig.is_rig = true;
    for (size_t i = 0; i < 3; i++) {
        parts[i].frame = numbers[i];
        parts[i].sensor = sensors[i];
    }
    struct frame *frame = frame_make(pool, &rig, parts, 3);
    struct frame *two = make(pool, one, other);
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    struct unpacked a = arrays_of(frame);
    struct unpacked w = arrays_of(two);
    assert_int_equal(bytes[39], 3);
    assert_int_equal(bytes[72], 0);
    assert_memory_equal(bytes + LUM_PACKED_HEAD_BYTES, table, sizeof table);
    assert_int_equal(a.count, w.count);
    for (size_t i = 0; i < a.count; i++) {
        assert_same_point(&a, i, &w, i);
    }
    unpacked_free(&a);
    unpacked_free(&w);
    lum_frame_release(one);
    lum_frame_release(none);
    lum_frame_release(other);
    frame_release(frame);
    frame_release(two);
    frame_pool_free(pool);
}

static size_t points_of(const struct frame *frame)
{
    struct unpacked a = arrays_of(frame);
    unpacked_free(&a);
    return a.count;
}

static void a_buffer_is_used_again_when_nobody_needs_it(void **state)
{
    (void)state;
    struct frame_pool *pool = frame_pool_new();
    lum_frame *points = near_and_far();
    lum_frame *none = frame_of(NULL, 0, LUM_EDGES_BOTH);
    struct frame *first = make(pool, points, NULL);
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(first, &len);
    assert_ptr_equal(frame_keep(first), first);
    frame_release(first);
    struct frame *second = make(pool, points, NULL);
    assert_ptr_not_equal(frame_bytes(second, &len), bytes);
    frame_release(first);
    struct frame *third = make(pool, none, NULL);
    assert_ptr_equal(frame_bytes(third, &len), bytes);
    assert_int_equal(points_of(third), 0);
    frame_release(third);
    third = make(pool, points, NULL);
    assert_int_equal(points_of(third), 5);
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
    frame_release(make(pool, few, NULL));
    struct frame *frame = make(pool, many, NULL);
    struct unpacked a = arrays_of(frame);
    assert_int_equal(a.count, 3000);
    for (size_t i = 0; i < 3000; i++) {
        assert_int_equal(a.pixel[i], i / 3u);
    }
    unpacked_free(&a);
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
    struct frame *frame = make(pool, points, NULL);
    frame_pool_free(pool);
    assert_int_equal(points_of(frame), 5);
    lum_frame_release(points);
    frame_release(frame);
    frame_release(NULL);
    frame_pool_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_has_all_that_is_shown_of_its_points),
        cmocka_unit_test(points_of_two_profiles_stand_one_behind_the_other),
        cmocka_unit_test(points_of_a_rig_are_told_by_sensor),
        cmocka_unit_test(a_buffer_is_used_again_when_nobody_needs_it),
        cmocka_unit_test(a_small_buffer_is_enlarged_for_a_large_frame),
        cmocka_unit_test(a_frame_outlives_its_pool),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
