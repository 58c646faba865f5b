#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame/frame_internal.h"

#define POINTS_MAX (1u << 24)
#define SPARE_MAX  4u

static const lum_columns of_two =
    LUM_COLUMN_BIT(LUM_COLUMN_Z) | LUM_COLUMN_BIT(LUM_COLUMN_RANGE);

static lum_frame_pool *make_pool(void)
{
    lum_frame_pool *pool = lum_frame_pool_new(POINTS_MAX, SPARE_MAX, false);
    assert_non_null(pool);
    return pool;
}

static lum_frame *begin(lum_frame_pool *pool, lum_columns columns, size_t usual)
{
    lum_frame *frame = lum_frame_begin(pool, columns, usual);
    assert_non_null(frame);
    return frame;
}

/* A number of each point and column. */
static float number_of(size_t i, unsigned column)
{
    return (float)(i * 8u + column);
}

static void add(lum_frame *frame, size_t points)
{
    assert_true(lum_frame_reserve_row(frame));
    if (!lum_frame_claim_room(frame, points)) {
        assert_true(lum_frame_relocate(frame, points));
        assert_true(lum_frame_claim_room(frame, points));
    }
    for (unsigned c = LUM_COLUMN_X; c <= LUM_COLUMN_RANGE; c++) {
        float *to = frame->store.columns[c].at;
        const bool is_wanted = (frame->mask & LUM_COLUMN_BIT(c)) != 0;
        for (size_t i = frame->count; is_wanted && i < frame->count + points;
             i++) {
            to[i] = number_of(i, c);
        }
    }
    frame->count += points;
}

static void expect_points(const lum_frame *frame)
{
    for (unsigned c = LUM_COLUMN_X; c <= LUM_COLUMN_RANGE; c++) {
        const float *at = lum_frame_floats(frame, (lum_column)c);
        for (size_t i = 0; at != NULL && i < frame->count; i++) {
            if (at[i] != number_of(i, c)) {
                fail_msg("point %zu of column %u is %g", i, c, (double)at[i]);
            }
        }
    }
}

/* The frame after another of as many points. Some of its own come before that
 * one gives back its memory. */
static lum_frame *follow(lum_frame_pool *pool, lum_frame *before)
{
    lum_frame *frame = begin(pool, before->mask, before->count);
    add(frame, 10);
    lum_frame_release(before);
    return frame;
}

/* The rest of its points. With the first of them it may move, and never after
 * that. */
static void expect_early_move(lum_frame *frame, size_t points)
{
    const lum_column first = (frame->mask & LUM_COLUMN_BIT(LUM_COLUMN_X)) != 0
                                 ? LUM_COLUMN_X
                                 : LUM_COLUMN_Z;
    add(frame, 10);
    const float *at = lum_frame_floats(frame, first);
    while (frame->count < points) {
        const size_t left = points - frame->count;
        add(frame, left < 50000 ? left : 50000);
    }
    assert_ptr_equal(lum_frame_floats(frame, first), at);
    expect_points(frame);
}

static void frames_move_once_as_soon_as_they_can(void **state)
{
    static const size_t sizes[] = {1000,   65535,  65536,  65537,
                                   128000, 262144, 262145, 700000};
    (void)state;
    for (size_t i = 0; i < 2u * sizeof sizes / sizeof sizes[0]; i++) {
        const size_t points = sizes[i / 2u];
        lum_frame_pool *pool = make_pool();
        lum_frame *frame =
            begin(pool, i % 2u == 0 ? LUM_COLUMNS_XYZ : of_two, 0);
        add(frame, points);
        for (int k = 0; k < 4; k++) {
            frame = follow(pool, frame);
            expect_early_move(frame, points);
        }
        lum_frame_release(frame);
        lum_frame_pool_free(pool);
    }
}

/* Its memory is free from the start. */
static void a_frame_that_nobody_holds_up_does_not_move(void **state)
{
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *frame = begin(pool, LUM_COLUMNS_XYZ, 0);
    add(frame, 400000);
    const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
    for (int k = 0; k < 4; k++) {
        lum_frame_release(frame);
        frame = begin(pool, LUM_COLUMNS_XYZ, 400000);
        add(frame, 400000);
        assert_ptr_equal(lum_frame_floats(frame, LUM_COLUMN_X), x);
    }
    lum_frame_release(frame);
    lum_frame_pool_free(pool);
}

/* The next ones begin in its memory, and leave it. */
static void a_short_frame_does_not_hold_up_others(void **state)
{
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *frame = begin(pool, LUM_COLUMNS_XYZ, 0);
    add(frame, 400000);
    frame = follow(pool, frame);
    expect_early_move(frame, 200000);
    lum_frame *long_one = begin(pool, LUM_COLUMNS_XYZ, 400000);
    add(long_one, 400000);
    lum_frame_release(frame);
    for (int k = 0; k < 4; k++) {
        long_one = follow(pool, long_one);
        expect_early_move(long_one, 400000);
    }
    lum_frame_release(long_one);
    lum_frame_pool_free(pool);
}

/* Two views of one stream: a caller keeps the frames of the small one. */
static void small_frames_leave_large_memory_to_others(void **state)
{
    lum_frame *kept[20];
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *large = begin(pool, LUM_COLUMNS_XYZ, 0);
    add(large, 2000000);
    for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
        large = follow(pool, large);
        kept[k] = begin(pool, LUM_COLUMNS_XYZ, k > 0 ? 10000 : 0);
        add(kept[k], 10);
        add(kept[k], 9990);
        add(large, 1999990);
        if (k > 0) {
            assert_in_range(kept[k]->store.columns[LUM_COLUMN_X].room, 10000,
                            8 * 65536);
        }
    }
    lum_frame_release(large);
    for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
        expect_points(kept[k]);
        lum_frame_release(kept[k]);
    }
    lum_frame_pool_free(pool);
}

static void a_frame_without_columns_needs_no_room(void **state)
{
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *frame = begin(pool, 0, 1000);
    assert_true(lum_frame_reserve_row(frame));
    assert_true(lum_frame_claim_room(frame, 1000));
    lum_frame_release(frame);
    lum_frame_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_move_once_as_soon_as_they_can),
        cmocka_unit_test(a_frame_that_nobody_holds_up_does_not_move),
        cmocka_unit_test(a_short_frame_does_not_hold_up_others),
        cmocka_unit_test(small_frames_leave_large_memory_to_others),
        cmocka_unit_test(a_frame_without_columns_needs_no_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
