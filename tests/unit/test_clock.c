#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/clock.h"

/* As numbers that may be below 0. */
static int64_t extend(int64_t before, uint64_t raw, unsigned bits)
{
    return lum_clock_us(lum_clock_extend((uint64_t)before, raw, bits), 1000);
}

static void a_clock_goes_on_over_its_wrap(void **state)
{
    (void)state;
    assert_true(extend(0xfffffff0, 0x10, 32) == 0x100000010);
    assert_true(extend(0xfff0, 0x10, 16) == 0x10010);
    assert_true(extend(0xf0, 0x10, 8) == 0x110);
}

static void a_clock_goes_back_over_its_wrap(void **state)
{
    (void)state;
    assert_true(extend(0x10, 0xfffffff0u, 32) == -0x10);
    assert_true(extend(0x100000010, 0xfffffff0u, 32) == 0xfffffff0);
    assert_true(extend(0x10, 0xfff0, 16) == -0x10);
    assert_true(extend(0x10, 0xf0, 8) == -0x10);
}

static void half_a_wrap_is_backwards(void **state)
{
    const int64_t half = INT64_C(0x80000000);
    (void)state;
    assert_true(extend(0, 0x7fffffffu, 32) == half - 1);
    assert_true(extend(0, 0x80000000u, 32) == -half);
    assert_true(extend(0, 0x80000001u, 32) == 1 - half);
    assert_true(extend(0, 0x7f, 8) == 127);
    assert_true(extend(0, 0x80, 8) == -128);
    assert_true(extend(0, 0x7fff, 16) == 32767);
    assert_true(extend(0, 0x8000, 16) == -32768);
}

static void every_byte_is_within_half_a_wrap(void **state)
{
    (void)state;
    for (int64_t before = -600; before < 600; before++) {
        for (uint32_t raw = 0; raw < 256; raw++) {
            const int64_t t = extend(before, raw, 8);
            assert_int_equal((uint64_t)t & 0xffu, raw);
            assert_true(t - before >= -128 && t - before <= 127);
        }
    }
}

static void a_negative_clock_is_extended_too(void **state)
{
    (void)state;
    assert_true(extend(-0x100000000, 5, 32) == -0x100000000 + 5);
    assert_true(extend(-1, 0, 32) == 0);
    assert_true(extend(-5000000000, 0, 32) == -4294967296);
}

static void without_a_clock_time_stands_still(void **state)
{
    (void)state;
    assert_true(extend(0, 1234, 0) == 0);
    assert_true(extend(-77, 0xffffffffu, 0) == -77);
}

static void bits_above_the_width_are_ignored(void **state)
{
    (void)state;
    assert_true(extend(0, 0xabcdef01u, 8) == 1);
    assert_true(extend(0, 0xabcd0001u, 16) == 1);
}

/* By thousands of ticks and what is left of them, which fit. */
static int64_t microseconds(int64_t ticks, int64_t unit_ns)
{
    const int64_t thousands = ticks / 1000 - (ticks % 1000 < 0 ? 1 : 0);
    return thousands * unit_ns + (ticks - 1000 * thousands) * unit_ns / 1000;
}

static void assert_microseconds(int64_t ticks, uint32_t unit_ns)
{
    assert_true(lum_clock_us((uint64_t)ticks, unit_ns) ==
                microseconds(ticks, unit_ns));
}

static void ticks_of_any_length_are_microseconds_rounded_down(void **state)
{
    static const uint32_t units[] = {
        1,    2,      7,       40,   999,    1000,      1001,
        1024, 999999, 1000000, 3333, 123457, 999999999, 1000000000};
    uint64_t some = 1;
    (void)state;
    for (size_t u = 0; u < sizeof units / sizeof units[0]; u++) {
        const int64_t most = units[u] <= 1000
                                 ? INT64_C(1) << 61
                                 : (INT64_C(1) << 61) / units[u] * 1000;
        for (int64_t ticks = -3000; ticks <= 3000; ticks++) {
            assert_microseconds(ticks, units[u]);
        }
        for (unsigned i = 0; i < 20000; i++) {
            some = some * UINT64_C(6364136223846793005) +
                   UINT64_C(1442695040888963407);
            const int64_t any = (int64_t)(some >> 1 >> i % 61u);
            const int64_t ticks = any % most;
            assert_microseconds(ticks, units[u]);
            assert_microseconds(-ticks, units[u]);
        }
    }
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
        cmocka_unit_test(ticks_of_any_length_are_microseconds_rounded_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
