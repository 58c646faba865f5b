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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_are_those_of_the_bell),
        cmocka_unit_test(both_halves_are_alike),
        cmocka_unit_test(nothing_is_beyond_six_sigma),
        cmocka_unit_test(a_quantile_is_where_its_share_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
