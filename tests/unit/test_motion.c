#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "points/motion.h"

#include <math.h>

#define COUNT 37u /* no multiple of any vector */

static void pixels_become_times(void **state)
{
    float times[COUNT];
    (void)state;
    for (unsigned i = 0; i < COUNT; i++) {
        times[i] = (float)(27u * i);
    }
    lum_motion_times(times, COUNT, -2000000, 1562000);
    for (unsigned i = 0; i < COUNT; i++) {
        const double ns = -2000000.0 + 27.0 * i * 1562.0;
        assert_true(fabs((double)times[i] - ns * 1e-9) < 2e-9);
    }
}

static void times_of_a_motion_are_counted(void **state)
{
    const lum_motion motion = {.from_s = 10.0f, .to_s = 20.0f};
    float times[COUNT];
    (void)state;
    for (unsigned i = 0; i < COUNT; i++) {
        times[i] = (float)i;
    }
    times[12] = NAN;
    assert_int_equal(lum_motion_count(&motion, times, COUNT), 9);
    assert_int_equal(lum_motion_count(&motion, times, 0), 0);
    assert_int_equal(lum_motion_count(&motion, times, 11), 1);
}

static void points_move_by_their_times(void **state)
{
    /* Turned to the left by a right angle, and 4 m/s forwards. */
    const lum_motion motion = {
        .from_s = 1.0f,
        .to_s = 2.0f,
        .matrix = {0, -1, 0, 100, 1, 0, 0, 200, 0, 0, 1, 300},
        .slope = {0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0.5f, 0}};
    float from[4][COUNT];
    float x[COUNT];
    float y[COUNT];
    float z[COUNT];
    float *const out[3] = {x, y, z};
    (void)state;
    for (unsigned i = 0; i < COUNT; i++) {
        from[0][i] = (float)i;
        from[1][i] = (float)(2u * i);
        from[2][i] = (float)(4u * i);
        from[3][i] = 1.0f + 0.015625f * (float)i;
    }
    const lum_motion_points points = {from[0], from[1], from[2], from[3]};
    lum_motion_move(&motion, &points, COUNT, out);
    for (unsigned i = 0; i < COUNT; i++) {
        const float s = 0.015625f * (float)i;
        const float right[] = {100.0f - (float)(2u * i) + 4.0f * s,
                               200.0f + (float)i,
                               300.0f + (float)(4u * i) * (1.0f + 0.5f * s)};
        for (unsigned row = 0; row < 3; row++) {
            assert_true(fabsf(out[row][i] - right[row]) < 1e-4f);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_become_times),
        cmocka_unit_test(times_of_a_motion_are_counted),
        cmocka_unit_test(points_move_by_their_times)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
