#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame/frame_internal.h"

#define POINTS_MAX (1u << 24)
#define SPARE_MAX  4u

static lum_frame_pool *make_pool(void)
{
    lum_frame_pool *pool = lum_frame_pool_new(POINTS_MAX, SPARE_MAX);
    assert_non_null(pool);
    return pool;
}

static lum_frame *begin(lum_frame_pool *pool)
{
    lum_frame *frame = lum_frame_begin(pool, LUM_COLUMNS_XYZ);
    assert_non_null(frame);
    return frame;
}

static void add(lum_frame *frame, size_t points)
{
    assert_true(lum_frame_reserve_row(frame));
    if (!lum_frame_stays(frame, points)) {
        assert_true(lum_frame_move(frame, points));
        assert_true(lum_frame_stays(frame, points));
    }
    float *x = frame->store.columns[LUM_COLUMN_X].at;
    for (size_t i = 0; i < points; i++) {
        x[frame->count++] = (float)i;
    }
}

/* The next one, of which some points come before the memory is free. */
static lum_frame *follow(lum_frame_pool *pool, lum_frame *before, size_t early)
{
    lum_frame *frame = begin(pool);
    add(frame, early);
    lum_frame_release(before);
    return frame;
}

static void expect_first_points(const lum_frame *frame, size_t count)
{
    const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
    for (size_t i = 0; i < count; i++) {
        assert_true(x[i] == (float)i);
    }
}

/* Its first points are copied, and no others. */
static void frames_move_once_as_soon_as_they_can(void **state)
{
    static const size_t sizes[] = {1000,   65535,  65536,  65537,
                                   128000, 262144, 262145, 2000000};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        lum_frame_pool *pool = make_pool();
        lum_frame *frame = begin(pool);
        add(frame, sizes[i]);
        for (int k = 0; k < 8; k++) {
            frame = follow(pool, frame, 10);
            add(frame, 10);
            const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
            add(frame, sizes[i] - 20);
            if (k > 0) { /* the second one cannot know its size */
                assert_ptr_equal(lum_frame_floats(frame, LUM_COLUMN_X), x);
            }
            expect_first_points(frame, 10);
        }
        lum_frame_release(frame);
        lum_frame_pool_free(pool);
    }
}

/* Whose memory is free from the start. */
static void a_frame_that_nobody_holds_up_does_not_move(void **state)
{
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *frame = begin(pool);
    add(frame, 400000);
    for (int k = 0; k < 8; k++) {
        lum_frame_release(frame);
        frame = begin(pool);
        add(frame, 10);
        const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
        add(frame, 399990);
        assert_ptr_equal(lum_frame_floats(frame, LUM_COLUMN_X), x);
    }
    lum_frame_release(frame);
    lum_frame_pool_free(pool);
}

/* A small one, that the others may have at their begin, stays small. */
static void a_frame_that_ends_early_does_not_hold_up_others(void **state)
{
    (void)state;
    lum_frame_pool *pool = make_pool();
    lum_frame *frame = begin(pool);
    add(frame, 400000);
    frame = follow(pool, frame, 10);
    add(frame, 200000);
    for (int k = 0; k < 8; k++) {
        frame = follow(pool, frame, 10);
        add(frame, 10);
        const float *x = lum_frame_floats(frame, LUM_COLUMN_X);
        add(frame, 399980);
        if (k > 0) {
            assert_ptr_equal(lum_frame_floats(frame, LUM_COLUMN_X), x);
        }
    }
    lum_frame_release(frame);
    lum_frame_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_move_once_as_soon_as_they_can),
        cmocka_unit_test(a_frame_that_nobody_holds_up_does_not_move),
        cmocka_unit_test(a_frame_that_ends_early_does_not_hold_up_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
