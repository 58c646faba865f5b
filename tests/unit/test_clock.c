#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/clock.h"

static void a_clock_goes_on_over_its_wrap(void **state)
{
    (void)state;
    assert_true(lum_clock_extend(0xfffffff0, 0x10, 4) == 0x100000010);
    assert_true(lum_clock_extend(0xfff0, 0x10, 2) == 0x10010);
    assert_true(lum_clock_extend(0xf0, 0x10, 1) == 0x110);
}

static void a_clock_goes_back_over_its_wrap(void **state)
{
    (void)state;
    assert_true(lum_clock_extend(0x10, 0xfffffff0u, 4) == -0x10);
    assert_true(lum_clock_extend(0x100000010, 0xfffffff0u, 4) == 0xfffffff0);
    assert_true(lum_clock_extend(0x10, 0xfff0, 2) == -0x10);
    assert_true(lum_clock_extend(0x10, 0xf0, 1) == -0x10);
}

static void half_a_wrap_is_backwards(void **state)
{
    const int64_t half = INT64_C(0x80000000);
    (void)state;
    assert_true(lum_clock_extend(0, 0x7fffffffu, 4) == half - 1);
    assert_true(lum_clock_extend(0, 0x80000000u, 4) == -half);
    assert_true(lum_clock_extend(0, 0x80000001u, 4) == 1 - half);
    assert_true(lum_clock_extend(0, 0x7f, 1) == 127);
    assert_true(lum_clock_extend(0, 0x80, 1) == -128);
    assert_true(lum_clock_extend(0, 0x7fff, 2) == 32767);
    assert_true(lum_clock_extend(0, 0x8000, 2) == -32768);
}

static void every_byte_is_within_half_a_wrap(void **state)
{
    (void)state;
    for (int64_t before = -600; before < 600; before++) {
        for (uint32_t raw = 0; raw < 256; raw++) {
            const int64_t t = lum_clock_extend(before, raw, 1);
            assert_int_equal((uint64_t)t & 0xffu, raw);
            assert_true(t - before >= -128 && t - before <= 127);
        }
    }
}

static void a_negative_clock_is_extended_too(void **state)
{
    (void)state;
    assert_true(lum_clock_extend(-0x100000000, 5, 4) == -0x100000000 + 5);
    assert_true(lum_clock_extend(-1, 0, 4) == 0);
    assert_true(lum_clock_extend(-5000000000, 0, 4) == -4294967296);
}

static void without_a_clock_time_stands_still(void **state)
{
    (void)state;
    assert_true(lum_clock_extend(0, 1234, 0) == 0);
    assert_true(lum_clock_extend(-77, 0xffffffffu, 0) == -77);
}

static void bits_above_the_width_are_ignored(void **state)
{
    (void)state;
    assert_true(lum_clock_extend(0, 0xabcdef01u, 1) == 1);
    assert_true(lum_clock_extend(0, 0xabcd0001u, 2) == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_clock_goes_on_over_its_wrap),
        cmocka_unit_test(a_clock_goes_back_over_its_wrap),
        cmocka_unit_test(half_a_wrap_is_backwards),
        cmocka_unit_test(every_byte_is_within_half_a_wrap),
        cmocka_unit_test(a_negative_clock_is_extended_too),
        cmocka_unit_test(without_a_clock_time_stands_still),
        cmocka_unit_test(bits_above_the_width_are_ignored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
