#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/yscan_plan.h"

#include <stdlib.h>
#include <string.h>

/* Elevations, with a mark behind the last that nothing may touch. */
#define MARK 0x5a5a5a5a

static int32_t *room_for(size_t n)
{
    int32_t *out = malloc((n + 1) * sizeof *out);
    assert_non_null(out);
    for (size_t i = 0; i <= n; i++) {
        out[i] = MARK;
    }
    return out;
}

static size_t count_within(const int32_t *udeg, size_t n, int32_t min,
                           int32_t max)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        count += udeg[i] >= min && udeg[i] <= max;
    }
    return count;
}

static void assert_falls(const int32_t *udeg, size_t n, int32_t min,
                         int32_t max, int32_t step)
{
    assert_int_equal(udeg[n], MARK);
    assert_true(udeg[0] <= max && udeg[n - 1] >= min);
    for (size_t i = 1; i < n; i++) {
        assert_true((int64_t)udeg[i - 1] - udeg[i] >= step);
    }
}

static void an_even_line_stands_in_the_middle_of_its_share(void **state)
{
    static const int32_t want[] = {2000000,  0,        -2000000,
                                   -4000000, -6000000, MARK};
    int32_t out[] = {MARK, MARK, MARK, MARK, MARK, MARK};
    (void)state;
    assert_int_equal(lum_yscan_uniform(-7000000, 3000000, out, 5), LUM_OK);
    assert_memory_equal(out, want, sizeof want);
    assert_int_equal(lum_yscan_uniform(-3, 8, out, 1), LUM_OK);
    assert_int_equal(out[0], 3);
    assert_int_equal(lum_yscan_uniform(-8, 3, out, 1), LUM_OK);
    assert_int_equal(out[0], -3);
    assert_int_equal(lum_yscan_uniform(-1, 0, out, 1), LUM_OK);
    assert_int_equal(out[0], -1);
}

static void assert_even(int32_t min, int32_t max, size_t n)
{
    int32_t *out = room_for(n);
    const int64_t span = (int64_t)max - min;
    assert_int_equal(lum_yscan_uniform(min, max, out, n), LUM_OK);
    assert_falls(out, n, min, max, span >= (int64_t)n ? 1 : 0);
    for (size_t i = 1; i < n; i++) {
        const int64_t gap = (int64_t)out[i - 1] - out[i];
        assert_in_range(gap, span / (int64_t)n, span / (int64_t)n + 1);
    }
    free(out);
}

static void even_lines_fall_evenly(void **state)
{
    static const size_t counts[] = {1, 2, 64, 640, 32767};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        assert_even(-17000000, 3000000, counts[i]);
        assert_even(-90000000, 90000000, counts[i]);
        assert_even(INT32_MIN, INT32_MAX, counts[i]);
        assert_even(0, (int32_t)counts[i], counts[i]);
        assert_even(5, 6, counts[i]);
    }
}

static void an_even_distribution_outside_its_limits_is_refused(void **state)
{
    int32_t out = MARK;
    (void)state;
    assert_int_equal(lum_yscan_uniform(3, 3, &out, 1), LUM_E_VALUE);
    assert_int_equal(lum_yscan_uniform(4, 3, &out, 1), LUM_E_VALUE);
    assert_int_equal(lum_yscan_uniform(3, 4, &out, 0), LUM_E_VALUE);
    assert_int_equal(lum_yscan_uniform(3, 4, &out, 32768), LUM_E_VALUE);
    assert_int_equal(out, MARK);
}

/* Quantiles of the normal distribution at 0.05, 0.15 ... 0.95. */
static void a_bell_of_ten_lines_has_the_quantiles_of_the_bell(void **state)
{
    static const int32_t want[] = {1644854,  1036433,  674490,  385320,
                                   125661,   -125661,  -385320, -674490,
                                   -1036433, -1644854, MARK};
    int32_t *out = room_for(10);
    (void)state;
    assert_int_equal(
        lum_yscan_gaussian(-90000000, 90000000, 0, 1000000, out, 10), LUM_OK);
    for (size_t i = 0; i < 10; i++) {
        assert_in_range(out[i] - want[i] + 2, 0, 4);
    }
    assert_int_equal(out[10], MARK);
    free(out);
}

static void a_wide_bell_has_its_shares_and_is_symmetric(void **state)
{
    enum {
        N = 32767
    };
    int32_t *out = room_for(N);
    (void)state;
    assert_int_equal(
        lum_yscan_gaussian(-80000000, 80000000, 0, 5000000, out, N), LUM_OK);
    assert_falls(out, N, -80000000, 80000000, 1);
    assert_in_range(count_within(out, N, -5000000, 5000000), 22369 - 1,
                    22369 + 1);
    assert_in_range(count_within(out, N, -10000000, 10000000), 31276 - 1,
                    31276 + 1);
    assert_in_range(count_within(out, N, -15000000, 15000000), 32679 - 1,
                    32679 + 1);
    assert_int_equal(out[N / 2], 0);
    for (size_t i = 0; i < N; i++) {
        assert_in_range(out[i] + out[N - 1 - i] + 1, 0, 2);
    }
    free(out);
}

/* A bell as wide as can be is flat over a short span, the narrowest holds all
 * lines within its six sigma. */
static void the_limits_of_a_bell_s_width_hold(void **state)
{
    int32_t *out = room_for(640);
    int32_t *even = room_for(640);
    (void)state;
    assert_int_equal(
        lum_yscan_gaussian(-1000000, 1000000, 0, 90000000, out, 640), LUM_OK);
    assert_int_equal(lum_yscan_uniform(-1000000, 1000000, even, 640), LUM_OK);
    for (size_t i = 0; i < 640; i++) {
        assert_in_range(out[i] - even[i] + 50, 0, 100);
    }
    assert_int_equal(
        lum_yscan_gaussian(-90000000, 90000000, 7, 10000, out, 640), LUM_OK);
    assert_falls(out, 640, 7 - 60000, 7 + 60000, 1);
    assert_int_equal(
        lum_yscan_gaussian(INT32_MIN, INT32_MAX, 0, 10000, out, 640), LUM_OK);
    assert_falls(out, 640, -60000, 60000, 1);
    free(even);
    free(out);
}

static void assert_bell_falls(int32_t min, int32_t max, int32_t center,
                              int32_t sigma, size_t n)
{
    int32_t *out = room_for(n);
    assert_int_equal(lum_yscan_gaussian(min, max, center, sigma, out, n),
                     LUM_OK);
    assert_falls(out, n, min, max, (int64_t)max - min >= (int64_t)n ? 1 : 0);
    free(out);
}

static void a_bell_falls_wherever_it_stands(void **state)
{
    static const size_t counts[] = {1, 2, 64, 640, 32767};
    static const int32_t sigmas[] = {10000, 999983, 90000000};
    static const int32_t spans[][2] = {{-17000000, 3000000},
                                       {0, 1},
                                       {0, 32767},
                                       {0, 32766},
                                       {-90000000, 90000000},
                                       {INT32_MIN, INT32_MAX}};
    (void)state;
    for (size_t i = 0; i < 6u * 3u * 5u; i++) {
        const int32_t min = spans[i % 6][0];
        const int32_t max = spans[i % 6][1];
        const int32_t sigma = sigmas[i / 6 % 3];
        assert_bell_falls(min, max, min, sigma, counts[i / 18]);
        assert_bell_falls(min, max, max, sigma, counts[i / 18]);
        assert_bell_falls(min, max, min / 2 + max / 2, sigma, counts[i / 18]);
    }
}

/* Half a bell, cut off at its middle: all of its lines below, 68 % of them
 * within sigma. */
static void a_bell_is_cut_off_at_the_end_of_the_span(void **state)
{
    int32_t *out = room_for(1000);
    (void)state;
    assert_int_equal(
        lum_yscan_gaussian(-17000000, 3000000, 3000000, 2000000, out, 1000),
        LUM_OK);
    assert_falls(out, 1000, -17000000, 3000000, 1);
    assert_in_range(count_within(out, 1000, 1000000, 3000000), 682, 684);
    free(out);
}

/* As many in the middle as there are microdegrees, and a bell's tail. */
static void lines_that_fall_together_part(void **state)
{
    enum {
        N = 30000
    };
    int32_t *out = room_for(N);
    (void)state;
    assert_int_equal(lum_yscan_gaussian(0, 40000, 40000, 10000, out, N),
                     LUM_OK);
    for (int32_t i = 0; i < 29900; i++) {
        assert_int_equal(out[i], 40000 - i);
    }
    assert_falls(out, N, 0, 40000, 1);
    assert_true(out[N - 1] < 5000);
    free(out);
}

static uint64_t hash_of_bell(int32_t min, int32_t max, int32_t center,
                             int32_t sigma)
{
    enum {
        N = 32767
    };
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    int32_t *out = room_for(N);
    assert_int_equal(lum_yscan_gaussian(min, max, center, sigma, out, N),
                     LUM_OK);
    for (size_t i = 0; i < N; i++) {
        hash = (hash ^ (uint32_t)out[i]) * UINT64_C(0x100000001b3);
    }
    free(out);
    return hash;
}

static void all_machines_make_the_same_bell(void **state)
{
    (void)state;
    assert_true(hash_of_bell(-90000000, 90000000, 5000000, 20000000) ==
                UINT64_C(0xe60ef59d5006125));
    assert_true(hash_of_bell(-90000000, 90000000, 7, 90000000) ==
                UINT64_C(0x65f6b086c646caeb));
    assert_true(hash_of_bell(INT32_MIN, INT32_MAX, -1, 90000000) ==
                UINT64_C(0x710e0495d8f9d4ee));
}

static void a_bell_outside_its_limits_is_refused(void **state)
{
    static const struct {
        int32_t min, max, center, sigma;
        size_t n;
    } bad[] = {
        {10, 10, 10, 10000, 1},   {11, 10, 10, 10000, 1},
        {-10, 10, -11, 10000, 1}, {-10, 10, 11, 10000, 1},
        {-10, 10, 0, 9999, 1},    {-10, 10, 0, 90000001, 1},
        {-10, 10, 0, 10000, 0},   {-10, 10, 0, 10000, 32768},
    };
    int32_t out = MARK;
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(lum_yscan_gaussian(bad[i].min, bad[i].max,
                                            bad[i].center, bad[i].sigma, &out,
                                            bad[i].n),
                         LUM_E_VALUE);
    }
    assert_int_equal(out, MARK);
}

static void regions_share_the_lines_by_weight(void **state)
{
    static const lum_yscan_region regions[] = {{1000000, 3000000, 1},
                                               {-2000000, 1000000, 6},
                                               {-17000000, -9000000, 3}};
    static const int32_t want[] = {2000000,   750000,    250000,   -250000,
                                   -750000,   -1250000,  -1750000, -10333333,
                                   -13000000, -15666667, MARK};
    int32_t *out = room_for(10);
    (void)state;
    assert_int_equal(lum_yscan_regions(regions, 3, out, 10), LUM_OK);
    assert_memory_equal(out, want, sizeof want);
    free(out);
}

static void a_share_of_half_a_line_goes_to_the_upper_region(void **state)
{
    static const lum_yscan_region halves[] = {{0, 4000000, 5},
                                              {-4000000, 0, 5}};
    static const int32_t want[] = {3000000, 1000000, -2000000, MARK};
    int32_t *out = room_for(3);
    (void)state;
    assert_int_equal(lum_yscan_regions(halves, 2, out, 3), LUM_OK);
    assert_memory_equal(out, want, sizeof want);
    free(out);
}

static void assert_shares(const uint32_t *weights, size_t count, size_t n)
{
    lum_yscan_region regions[LUM_YSCAN_REGIONS_MAX];
    int32_t *out = room_for(n);
    uint64_t all = 0;
    size_t sum = 0;
    for (size_t i = 0; i < count; i++) {
        const int32_t top = -(int32_t)i * 1000000;
        regions[i] = (lum_yscan_region){top - 1000000, top, weights[i]};
        all += weights[i];
    }
    assert_int_equal(lum_yscan_regions(regions, count, out, n), LUM_OK);
    assert_falls(out, n, -16000000, 0, 1);
    for (size_t i = 0; i < count; i++) {
        const size_t got =
            count_within(out, n, regions[i].min_udeg, regions[i].max_udeg);
        const uint64_t floor = weights[i] * n / all;
        assert_true(got >= 1);
        assert_true(got >= floor || got + count >= floor);
        sum += got;
    }
    assert_int_equal(sum, n);
    free(out);
}

static void every_region_gets_a_line_and_they_add_up(void **state)
{
    static const uint32_t first[16] = {1000000, 1, 1, 1, 1, 1, 1, 1,
                                       1,       1, 1, 1, 1, 1, 1, 1};
    static const uint32_t last[16] = {1, 1, 1, 1, 1, 1, 1, 1,
                                      1, 1, 1, 1, 1, 1, 1, 1000000};
    static const uint32_t thin[3] = {1000, 1, 1000};
    static const uint32_t mixed[16] = {7, 1, 1000, 3, 1, 1, 999999, 1,
                                       2, 5, 1,    1, 8, 1, 1,      13};
    (void)state;
    for (size_t n = 16; n < 40; n++) {
        assert_shares(first, 16, n);
        assert_shares(last, 16, n);
        assert_shares(mixed, 16, n);
    }
    assert_shares(first, 16, 32767);
    assert_shares(last, 16, 32767);
    assert_shares(mixed, 16, 640);
    assert_shares(thin, 3, 3);
    assert_shares(thin, 3, 10);
    assert_shares(mixed, 1, 1);
    assert_shares(mixed, 2, 2);
}

static void regions_outside_their_limits_are_refused(void **state)
{
    static const lum_yscan_region good[2] = {{0, 10, 1}, {-10, 0, 1}};
    static const lum_yscan_region bad[][2] = {
        {{-10, 0, 1}, {0, 10, 1}},  {{0, 10, 1}, {-10, 1, 1}},
        {{10, 10, 1}, {-10, 0, 1}}, {{0, 10, 1}, {0, -10, 1}},
        {{0, 10, 0}, {-10, 0, 1}},  {{0, 10, 1}, {-10, 0, 1000001}},
        {{0, 10, 1}, {-10, 0, 0}},  {{0, 10, 1000001}, {-10, 0, 1}},
    };
    lum_yscan_region many[LUM_YSCAN_REGIONS_MAX + 1];
    int32_t *out = room_for(40);
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(lum_yscan_regions(bad[i], 2, out, 40), LUM_E_VALUE);
    }
    for (size_t i = 0; i <= LUM_YSCAN_REGIONS_MAX; i++) {
        many[i] = (lum_yscan_region){-(int32_t)i, 1 - (int32_t)i, 1};
    }
    assert_int_equal(
        lum_yscan_regions(many, LUM_YSCAN_REGIONS_MAX + 1, out, 40),
        LUM_E_VALUE);
    assert_int_equal(lum_yscan_regions(good, 0, out, 40), LUM_E_VALUE);
    assert_int_equal(lum_yscan_regions(good, 2, out, 1), LUM_E_VALUE);
    assert_int_equal(lum_yscan_regions(good, 2, out, 0), LUM_E_VALUE);
    assert_int_equal(lum_yscan_regions(good, 2, out, 32768), LUM_E_VALUE);
    assert_int_equal(out[0], MARK);
    assert_int_equal(lum_yscan_regions(good, 2, out, 2), LUM_OK);
    assert_int_equal(lum_yscan_regions(many, LUM_YSCAN_REGIONS_MAX, out, 40),
                     LUM_OK);
    free(out);
}

static void assert_makes(const lum_yscan_shape *shape, int32_t first,
                         int32_t last)
{
    int32_t out[2] = {MARK, MARK};
    assert_int_equal(lum_yscan_make(shape, -17000000, 3000000, out, 2), LUM_OK);
    assert_int_equal(out[0], first);
    assert_int_equal(out[1], last);
}

static void a_shape_s_open_ends_are_the_span_s(void **state)
{
    lum_yscan_shape shape = {LUM_YSCAN_UNIFORM, INT32_MIN, INT32_MAX,  0,
                             90000000,          1,         {{0, 8, 1}}};
    int32_t out = MARK;
    (void)state;
    assert_makes(&shape, -2000000, -12000000);
    shape.min_udeg = -1000000;
    assert_makes(&shape, 2000000, 0);
    shape.max_udeg = 1000000;
    assert_makes(&shape, 500000, -500000);
    shape.min_udeg = INT32_MIN;
    assert_makes(&shape, -3500000, -12500000);
    shape.kind = LUM_YSCAN_REGIONS;
    assert_makes(&shape, 6, 2);
    shape.kind = LUM_YSCAN_GAUSSIAN;
    shape.max_udeg = INT32_MAX;
    assert_int_equal(lum_yscan_make(&shape, -9, 9, &out, 1), LUM_OK);
    assert_int_equal(out, 0);
    shape.max_udeg = 5;
    assert_int_equal(lum_yscan_make(&shape, -9, 9, &out, 1), LUM_OK);
    assert_int_equal(out, -2);
    shape.min_udeg = -3;
    assert_int_equal(lum_yscan_make(&shape, -9, 9, &out, 1), LUM_OK);
    assert_int_equal(out, 1);
    shape.kind = (lum_yscan_kind)3;
    assert_int_equal(lum_yscan_make(&shape, -9, 9, &out, 1), LUM_E_VALUE);
}

static lum_calibration typical(void)
{
    lum_calibration c;
    lum_calibration_default(&c);
    return c;
}

static void the_span_is_the_whole_of_the_raw_scale(void **state)
{
    static const int32_t udeg[] = {3000000,  2999999,  2999695,   -2000000,
                                   -7000000, -7000305, -16999999, -17000000};
    static const int16_t want[] = {32767, 32767, 32767,  16384,
                                   0,     -1,    -32768, -32768};
    const lum_calibration c = typical();
    lum_layout layout;
    int16_t out[8] = {0};
    size_t at = 77;
    (void)state;
    lum_layout_default(&layout);
    assert_int_equal(lum_yscan_encode(&c.eye[0], &layout, udeg, 8, out, &at),
                     LUM_OK);
    assert_memory_equal(out, want, sizeof want);
    assert_int_equal(at, 77);
    assert_int_equal(lum_yscan_encode(&c.eye[0], &layout, NULL, 0, NULL, NULL),
                     LUM_OK);
}

static lum_layout with_lsb(uint64_t lsb_pdeg)
{
    lum_profile profile;
    lum_layout layout;
    lum_profile_default(&profile);
    profile.angle_lsb_pdeg = lsb_pdeg;
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    return layout;
}

static void a_fixed_lsb_counts_from_the_middle_of_the_span(void **state)
{
    static const int32_t udeg[] = {3000000, -7000000, -7000500, -17000000};
    static const int16_t want[] = {10000, 0, -1, -10000};
    const lum_calibration c = typical();
    const lum_layout layout = with_lsb(1000000000);
    const lum_layout fine = with_lsb(305175781);
    const lum_layout too_fine = with_lsb(200000000);
    int16_t out[4] = {0};
    size_t at = 77;
    (void)state;
    assert_int_equal(lum_yscan_encode(&c.eye[1], &layout, udeg, 4, out, &at),
                     LUM_OK);
    assert_memory_equal(out, want, sizeof want);
    assert_int_equal(lum_yscan_encode(&c.eye[1], &fine, udeg, 4, out, &at),
                     LUM_E_VALUE);
    assert_int_equal(at, 0);
    assert_int_equal(
        lum_yscan_encode(&c.eye[1], &too_fine, udeg + 1, 3, out, &at),
        LUM_E_VALUE);
    assert_int_equal(at, 2);
    assert_memory_equal(out, want, sizeof want);
}

static void a_fixed_lsb_ends_with_the_raw_scale(void **state)
{
    static const struct {
        int32_t udeg;
        lum_result want;
        int16_t raw;
    } cases[] = {{-7000000 + 3276700, LUM_OK, 32767},
                 {-7000000 + 3276800, LUM_E_VALUE, 0},
                 {-7000000 - 3276800, LUM_OK, -32768},
                 {-7000000 - 3276900, LUM_E_VALUE, 0}};
    const lum_calibration c = typical();
    const lum_layout layout = with_lsb(100000000);
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        int16_t out = 0;
        assert_int_equal(
            lum_yscan_encode(&c.eye[0], &layout, &cases[i].udeg, 1, &out, NULL),
            cases[i].want);
        assert_int_equal(out, cases[i].raw);
    }
}

static void the_first_elevation_at_fault_is_named(void **state)
{
    static const struct {
        int32_t udeg[4];
        size_t at; /* 4: none */
    } cases[] = {
        {{3000000, 0, -1, -17000000}, 4},
        {{-17000000, -1, 0, 3000000}, 4},
        {{0, 0, 0, 0}, 4},
        {{1, 1, 0, 0}, 4},
        {{0, 0, 1, 1}, 4},
        {{3000001, 0, -1, -2}, 0},
        {{3, 2, 1, -17000001}, 3},
        {{3, 2, 3, 1}, 2},
        {{1, 2, 2, 1}, 3},
        {{5, 5, 4, 5}, 3},
    };
    const lum_calibration c = typical();
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int16_t out[4] = {77, 77, 77, 77};
        size_t at = 4;
        const lum_result r =
            lum_yscan_encode(&c.eye[0], &layout, cases[i].udeg, 4, out, &at);
        assert_int_equal(r, cases[i].at == 4 ? LUM_OK : LUM_E_VALUE);
        assert_int_equal(at, cases[i].at);
        assert_true(r == LUM_OK || (out[0] == 77 && out[3] == 77));
        assert_int_equal(
            lum_yscan_encode(&c.eye[0], &layout, cases[i].udeg, 4, out, NULL),
            r);
    }
}

static void every_raw_value_comes_back_from_its_elevation(void **state)
{
    const lum_calibration c = typical();
    const lum_layout layouts[2] = {with_lsb(0), with_lsb(300000000)};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        for (int32_t raw = -32768; raw <= 32767; raw++) {
            int16_t back = 0;
            const int32_t udeg =
                lum_yscan_elevation(&c.eye[0], &layouts[i], (int16_t)raw);
            assert_int_equal(
                lum_yscan_encode(&c.eye[0], &layouts[i], &udeg, 1, &back, NULL),
                LUM_OK);
            assert_int_equal(back, raw);
        }
    }
}

static void an_elevation_that_32_bits_cannot_hold_is_the_nearest(void **state)
{
    const lum_calibration c = typical();
    const lum_layout layout = with_lsb(LUM_ANGLE_LSB_MAX_PDEG);
    (void)state;
    assert_int_equal(lum_yscan_elevation(&c.eye[0], &layout, 32767), INT32_MAX);
    assert_int_equal(lum_yscan_elevation(&c.eye[0], &layout, -32768),
                     INT32_MIN);
    assert_int_equal(lum_yscan_elevation(&c.eye[0], &layout, 9), 2000000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_line_stands_in_the_middle_of_its_share),
        cmocka_unit_test(even_lines_fall_evenly),
        cmocka_unit_test(an_even_distribution_outside_its_limits_is_refused),
        cmocka_unit_test(a_bell_of_ten_lines_has_the_quantiles_of_the_bell),
        cmocka_unit_test(a_wide_bell_has_its_shares_and_is_symmetric),
        cmocka_unit_test(the_limits_of_a_bell_s_width_hold),
        cmocka_unit_test(a_bell_falls_wherever_it_stands),
        cmocka_unit_test(a_bell_is_cut_off_at_the_end_of_the_span),
        cmocka_unit_test(lines_that_fall_together_part),
        cmocka_unit_test(all_machines_make_the_same_bell),
        cmocka_unit_test(a_bell_outside_its_limits_is_refused),
        cmocka_unit_test(regions_share_the_lines_by_weight),
        cmocka_unit_test(a_share_of_half_a_line_goes_to_the_upper_region),
        cmocka_unit_test(every_region_gets_a_line_and_they_add_up),
        cmocka_unit_test(regions_outside_their_limits_are_refused),
        cmocka_unit_test(a_shape_s_open_ends_are_the_span_s),
        cmocka_unit_test(the_span_is_the_whole_of_the_raw_scale),
        cmocka_unit_test(a_fixed_lsb_counts_from_the_middle_of_the_span),
        cmocka_unit_test(a_fixed_lsb_ends_with_the_raw_scale),
        cmocka_unit_test(the_first_elevation_at_fault_is_named),
        cmocka_unit_test(every_raw_value_comes_back_from_its_elevation),
        cmocka_unit_test(an_elevation_that_32_bits_cannot_hold_is_the_nearest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
