#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/normal.h"

#include <math.h>

#define UNITS   8589934592.0 /* 2^33: all of the probability */
#define SIX     (LUM_NORMAL_SIGMAS * LUM_NORMAL_ONE)
#define STEP    (LUM_NORMAL_ONE / 320 + 1)
#define HALF    INT64_C(4294967288) /* up to six sigma */
#define HALF_UP (INT64_C(1) << 32)

/* The bell's share between 0 and x sigma. */
static double share_of(int64_t x)
{
    return erf((double)x / (double)LUM_NORMAL_ONE / sqrt(2.0)) / 2.0;
}

static void shares_are_those_of_the_bell(void **state)
{
    (void)state;
    for (int64_t x = -SIX; x <= SIX; x += STEP) {
        const double share = (double)lum_normal_cumulative(x) / UNITS;
        if (fabs(share - share_of(x)) > 2e-7) {
            fail_msg("%g sigma: %.9f, expected %.9f",
                     (double)x / (double)LUM_NORMAL_ONE, share, share_of(x));
        }
    }
}

/* Cells are a 32nd of a sigma wide: where one begins the table stands. */
static void the_table_is_the_bells_to_the_last_unit(void **state)
{
    (void)state;
    for (int64_t x = 0; x <= SIX; x += LUM_NORMAL_ONE / 32) {
        const int64_t share = llround(share_of(x) * UNITS);
        assert_true(lum_normal_cumulative(x) == share);
        assert_true(lum_normal_quantile(share) == x || share >= HALF);
    }
}

static void both_halves_are_alike(void **state)
{
    (void)state;
    assert_int_equal(lum_normal_cumulative(0), 0);
    assert_int_equal(lum_normal_quantile(0), 0);
    for (int64_t x = 1; x <= SIX; x += STEP) {
        const int64_t u = lum_normal_cumulative(x);
        assert_true(lum_normal_cumulative(-x) == -u);
        assert_true(lum_normal_quantile(-u) == -lum_normal_quantile(u));
    }
}

static void nothing_is_beyond_six_sigma(void **state)
{
    (void)state;
    assert_true(lum_normal_cumulative(SIX) == HALF);
    assert_true(lum_normal_cumulative(SIX + 1) == HALF);
    assert_true(lum_normal_cumulative(INT64_MAX) == HALF);
    assert_true(lum_normal_cumulative(-INT64_MAX) == -HALF);
    assert_true(lum_normal_cumulative(SIX - LUM_NORMAL_ONE / 32) < HALF);
    assert_true(lum_normal_quantile(HALF) == SIX);
    assert_true(lum_normal_quantile(HALF_UP) == SIX);
    assert_true(lum_normal_quantile(-HALF_UP) == -SIX);
    assert_true(lum_normal_quantile(HALF - 1) < SIX);
}

/* A quantile's own error is that of the share, divided by the density. */
static void a_quantile_is_where_its_share_ends(void **state)
{
    (void)state;
    for (int64_t u = -HALF; u <= HALF; u += HALF / 5000) {
        const double share = share_of(lum_normal_quantile(u));
        if (fabs(share - (double)u / UNITS) > 2e-7) {
            fail_msg("share %.9f: %.9f", (double)u / UNITS, share);
        }
    }
}

static uint64_t hash(uint64_t before, int64_t value)
{
    return (before ^ (uint64_t)value) * UINT64_C(0x100000001b3);
}

/* A Y-scan is the same whatever machine makes it: within the cells, at their
 * ends, and where the table ends. */
static void all_machines_make_the_same_integers(void **state)
{
    uint64_t made = UINT64_C(0xcbf29ce484222325);
    (void)state;
    for (int64_t x = 1; x < SIX + STEP; x += STEP / 7) {
        made = hash(made, lum_normal_cumulative(x));
        made = hash(made, lum_normal_quantile(x / 6 * 4));
    }
    for (int64_t x = 0; x <= SIX; x += LUM_NORMAL_ONE / 32) {
        for (int64_t beside = -9; beside <= 9; beside++) {
            const int64_t share = lum_normal_cumulative(x);
            made = hash(made, lum_normal_cumulative(x + beside));
            made = hash(made, lum_normal_quantile(share + beside));
        }
    }
    assert_true(made == UINT64_C(0x592ee2263b5727d7));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_are_those_of_the_bell),
        cmocka_unit_test(the_table_is_the_bells_to_the_last_unit),
        cmocka_unit_test(both_halves_are_alike),
        cmocka_unit_test(nothing_is_beyond_six_sigma),
        cmocka_unit_test(a_quantile_is_where_its_share_ends),
        cmocka_unit_test(all_machines_make_the_same_integers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
