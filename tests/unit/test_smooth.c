#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/smooth.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PIXELS LUM_LINE_PIXELS

/* A line without words, and what becomes of its angles. Each array has a piece
 * of the heap, so that the sanitizer guards its end. */
struct scene {
    lum_line line;
    lum_angle *angles;
    uint32_t *marks;
    lum_angle *out;
    uint32_t random;
};

#define LINE_BYTES (PIXELS * sizeof(lum_angle))

static void *allocate(size_t n, size_t size)
{
    void *p = calloc(n, size);
    assert_non_null(p);
    return p;
}

static struct scene *scene_new(void)
{
    struct scene *s = allocate(1, sizeof *s);
    s->angles = allocate(PIXELS, sizeof *s->angles);
    s->out = allocate(PIXELS, sizeof *s->out);
    s->marks = allocate(LUM_PIXEL_MARK_WORDS, sizeof *s->marks);
    s->line = (lum_line){
        .angles = s->angles, .angle_marks = s->marks, .angle_count = PIXELS};
    s->random = 1;
    return s;
}

static void scene_free(struct scene *s)
{
    free(s->angles);
    free(s->out);
    free(s->marks);
    free(s);
}

static void mark(struct scene *s, unsigned first, unsigned end, bool on)
{
    for (unsigned p = first; p < end; p++) {
        const uint32_t bit = (uint32_t)1 << (p % 32u);
        s->marks[p / 32u] =
            on ? s->marks[p / 32u] | bit : s->marks[p / 32u] & ~bit;
    }
}

static int16_t random_raw(struct scene *s)
{
    s->random = s->random * 1664525u + 1013904223u;
    return (int16_t)((int32_t)(s->random >> 16) - 32768);
}

static void fill_randomly(struct scene *s, unsigned first, unsigned end)
{
    for (unsigned p = first; p < end; p++) {
        s->angles[p] = (lum_angle){random_raw(s), random_raw(s)};
    }
}

static void smooth(struct scene *s, uint32_t window, uint32_t order)
{
    lum_smooth filter;
    assert_int_equal(lum_smooth_init(&filter, window, order), LUM_OK);
    memset(s->out, 0x55, LINE_BYTES);
    lum_smooth_line(&filter, &s->line, s->out);
}

static void assert_unchanged(const struct scene *s, unsigned first,
                             unsigned end)
{
    assert_memory_equal(s->out + first, s->angles + first,
                        (end - first) * sizeof s->out[0]);
}

/* Weights as the literature has them, of the reading at a pixel. */
struct golden {
    uint32_t window;
    uint32_t order;
    unsigned pixel; /* that holds the one reading */
    int32_t reading;
    unsigned first; /* pixel of the expected values */
    int16_t expected[25];
    unsigned count;
};

static const struct golden goldens[] = {
    {5, 2, 500, 3500, 498, {-300, 1200, 1700, 1200, -300}, 5},
    {5, 3, 500, 3500, 498, {-300, 1200, 1700, 1200, -300}, 5},
    {7, 2, 500, 2100, 497, {-200, 300, 600, 700, 600, 300, -200}, 7},
    {7, 4, 500, 2310, 497, {50, -300, 750, 1310, 750, -300, 50}, 7},
    {9, 3, 500, 2310, 496, {-210, 140, 390, 540, 590, 540, 390, 140, -210}, 9},
    {25,
     2,
     500,
     5175,
     488,
     {-253, -138, -33, 62,  147, 222, 287, 342, 387, 422, 447,  462, 467,
      462,  447,  422, 387, 342, 287, 222, 147, 62,  -33, -138, -253},
     25},
    {3, 0, 500, 300, 498, {0, 100, 100, 100, 0}, 5},
    /* at the ends */
    {5, 2, 0, 3500, 0, {3100, 900, -300, 0, 0}, 5},
    {5, 2, 4, 3500, 0, {300, -500, -300, 1200, 1700}, 5},
    {5, 2, 999, 3500, 995, {0, 0, -300, 900, 3100}, 5},
    {5, 1, 0, 1000, 0, {600, 400, 200, 0, 0}, 5},
};

static void weights_are_those_of_the_literature(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof goldens / sizeof goldens[0]; i++) {
        const struct golden *g = &goldens[i];
        struct scene *s = scene_new();
        mark(s, 0, PIXELS, true);
        s->angles[g->pixel].azimuth = (int16_t)g->reading;
        s->angles[g->pixel].elevation = (int16_t)-g->reading;
        smooth(s, g->window, g->order);
        for (unsigned k = 0; k < g->count; k++) {
            assert_int_equal(s->out[g->first + k].azimuth, g->expected[k]);
            assert_int_equal(s->out[g->first + k].elevation, -g->expected[k]);
        }
        scene_free(s);
    }
}

/* Solve the n equations a x = b; a is symmetric, positive. Returns x[0]. */
static double solve(double a[6][6], double b[6], unsigned n)
{
    for (unsigned i = n; i-- > 0;) {
        for (unsigned row = 0; row < i; row++) {
            const double share = a[row][i] / a[i][i];
            for (unsigned column = 0; column <= i; column++) {
                a[row][column] -= share * a[i][column];
            }
            b[row] -= share * b[i];
        }
    }
    return b[0] / a[0][0];
}

/* The polynomial of least squares through n readings, at one of them: powers of
 * the distance from it, whose constant is asked for. */
static double fit_at(const lum_angle *in, unsigned n, unsigned order,
                     unsigned at, bool elevation)
{
    double a[6][6] = {{0}};
    double b[6] = {0};
    for (unsigned i = 0; i < n; i++) {
        const double x = ((double)i - (double)at) / (double)n;
        const double y = elevation ? in[i].elevation : in[i].azimuth;
        double powers[11] = {1.0};
        for (unsigned k = 1; k <= 2 * order; k++) {
            powers[k] = powers[k - 1] * x;
        }
        for (unsigned row = 0; row <= order; row++) {
            b[row] += powers[row] * y;
            for (unsigned column = 0; column <= order; column++) {
                a[row][column] += powers[row + column];
            }
        }
    }
    return solve(a, b, order + 1u);
}

static double clamp(double value)
{
    return fmax(-32768.0, fmin(32767.0, value));
}

/* Compare some pixels of a run with the definition. */
static void assert_run(const struct scene *s, unsigned first, unsigned end,
                       unsigned window, unsigned order)
{
    const unsigned n = end - first < window ? end - first : window;
    for (unsigned p = first; p < end; p += p < first + 40u ? 3u : 11u) {
        const unsigned ahead =
            p - first < window / 2u ? p - first : window / 2u;
        const unsigned low = p - ahead;
        const unsigned begin = low + n > end ? end - n : low;
        const lum_angle *in = s->angles + begin;
        if (end - first <= order + 1u) {
            assert_unchanged(s, p, p + 1u);
            continue;
        }
        assert_true(fabs(clamp(fit_at(in, n, order, p - begin, false)) -
                         s->out[p].azimuth) < 0.52);
        assert_true(fabs(clamp(fit_at(in, n, order, p - begin, true)) -
                         s->out[p].elevation) < 0.52);
    }
}

/* Of random readings, which agree with no polynomial. */
static void every_window_and_order_is_the_least_squares_fit(void **state)
{
    static const unsigned gaps[][2] = {{0, 3},     {150, 151}, {160, 334},
                                       {338, 339}, {370, 380}, {500, 502},
                                       {565, 567}, {998, 999}};
    struct scene *s = scene_new();
    (void)state;
    mark(s, 0, PIXELS, true);
    fill_randomly(s, 0, PIXELS);
    for (unsigned i = 0; i < 8; i++) {
        mark(s, gaps[i][0], gaps[i][1], false);
    }
    for (uint32_t window = 1; window <= LUM_SMOOTH_WINDOW_MAX; window += 2) {
        for (uint32_t order = 0; order <= 5 && order < window; order++) {
            smooth(s, window, order);
            for (unsigned i = 0; i < 8; i++) {
                const unsigned end = i < 7 ? gaps[i + 1][0] : PIXELS;
                assert_unchanged(s, gaps[i][0], gaps[i][1]);
                assert_run(s, gaps[i][1], end, window, order);
            }
        }
    }
    scene_free(s);
}

/* Pixels over which p over k, a polynomial of order k, is a raw value. */
static unsigned fill_binomials(struct scene *s, unsigned k)
{
    unsigned p = 0;
    for (; p < PIXELS; p++) {
        double value = 1.0;
        for (unsigned i = 0; i < k; i++) {
            value = value * (double)(p - i) / (double)(i + 1u);
            value = p < k ? 0.0 : value;
        }
        if (value > 32767.0) {
            break;
        }
        s->angles[p] = (lum_angle){(int16_t)value, (int16_t)(7 - value)};
    }
    return p;
}

static void polynomials_up_to_the_order_stay_as_they_are(void **state)
{
    (void)state;
    for (unsigned degree = 0; degree <= LUM_SMOOTH_ORDER_MAX; degree++) {
        struct scene *s = scene_new();
        mark(s, 0, fill_binomials(s, degree), true);
        for (uint32_t window = 7; window <= LUM_SMOOTH_WINDOW_MAX;
             window += 2) {
            for (uint32_t order = degree; order <= 5; order++) {
                smooth(s, window, order);
                assert_unchanged(s, 0, PIXELS);
            }
        }
        scene_free(s);
    }
}

static void steep_lines_keep_their_ends(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    mark(s, 0, PIXELS, true);
    for (int p = 0; p < (int)PIXELS; p++) {
        s->angles[p] =
            (lum_angle){(int16_t)(65 * p - 32500), (int16_t)(32500 - 65 * p)};
    }
    smooth(s, LUM_SMOOTH_WINDOW, LUM_SMOOTH_ORDER(LUM_SMOOTH_WINDOW));
    assert_unchanged(s, 0, PIXELS);
    smooth(s, LUM_SMOOTH_WINDOW_MAX, 1);
    assert_unchanged(s, 0, PIXELS);
    scene_free(s);
}

static void gaps_are_never_bridged(void **state)
{
    struct scene *s = scene_new();
    lum_angle before[PIXELS];
    (void)state;
    fill_randomly(s, 0, PIXELS);
    mark(s, 0, 334, true);
    mark(s, 335, PIXELS, true);
    smooth(s, 63, 2);
    memcpy(before, s->out, sizeof before);
    /* whatever lies in the gap or beyond it */
    fill_randomly(s, 334, PIXELS);
    smooth(s, 63, 2);
    assert_memory_equal(s->out, before, 334 * sizeof before[0]);
    assert_memory_not_equal(s->out + 335, before + 335, 100 * sizeof before[0]);
    assert_unchanged(s, 334, 335);
    mark(s, 335, PIXELS, false);
    smooth(s, 63, 2);
    assert_memory_equal(s->out, before, 334 * sizeof before[0]);
    scene_free(s);
}

static void short_runs_get_what_their_length_allows(void **state)
{
    (void)state;
    for (uint32_t order = 0; order <= LUM_SMOOTH_ORDER_MAX; order++) {
        struct scene *s = scene_new();
        fill_randomly(s, 0, PIXELS);
        /* of order + 1 pixels, of one more, of the line's last one */
        mark(s, 100, 100 + order + 1, true);
        mark(s, 200, 200 + order + 2, true);
        mark(s, PIXELS - 1, PIXELS, true);
        smooth(s, 31, order);
        assert_unchanged(s, 0, 200);
        assert_unchanged(s, 200 + order + 2, PIXELS);
        assert_memory_not_equal(s->out + 200, s->angles + 200,
                                (order + 2) * sizeof s->out[0]);
        assert_run(s, 200, 200 + order + 2, 31, order);
        scene_free(s);
    }
}

static void a_line_without_angles_stays_as_it_is(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    fill_randomly(s, 0, PIXELS);
    s->marks[LUM_PIXEL_MARK_WORDS - 1] = 0xffffff00u; /* behind the last */
    s->line.angle_count = 0;
    smooth(s, 31, 2);
    assert_unchanged(s, 0, PIXELS);
    scene_free(s);
}

static void the_ends_of_the_scale_are_kept(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    mark(s, 0, PIXELS, true);
    for (unsigned p = 0; p < PIXELS; p++) {
        s->angles[p] = (p / 100u) % 2u ? (lum_angle){INT16_MAX, INT16_MIN}
                                       : (lum_angle){INT16_MIN, INT16_MAX};
    }
    smooth(s, 31, 2); /* overshoots by a tenth */
    for (unsigned p = 0; p < PIXELS; p++) {
        if (p % 100u >= 16 && p % 100u < 84) {
            assert_unchanged(s, p, p + 1);
        }
    }
    assert_int_equal(s->out[110].azimuth, INT16_MAX);
    assert_int_equal(s->out[110].elevation, INT16_MIN);
    assert_int_equal(s->out[210].azimuth, INT16_MIN);
    assert_int_equal(s->out[210].elevation, INT16_MAX);
    scene_free(s);
}

static void a_line_can_be_smoothed_in_place(void **state)
{
    struct scene *s = scene_new();
    lum_smooth filter;
    (void)state;
    fill_randomly(s, 0, PIXELS);
    mark(s, 5, 700, true);
    smooth(s, 21, 3);
    assert_int_equal(lum_smooth_init(&filter, 21, 3), LUM_OK);
    lum_smooth_line(&filter, &s->line, s->angles);
    assert_memory_equal(s->angles, s->out, LINE_BYTES);
    scene_free(s);
}

static void off_changes_nothing(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    fill_randomly(s, 0, PIXELS);
    mark(s, 0, PIXELS, true);
    smooth(s, 1, 0);
    assert_unchanged(s, 0, PIXELS);
    smooth(s, 3, 2);
    assert_unchanged(s, 0, PIXELS);
    smooth(s, 5, 4);
    assert_unchanged(s, 0, PIXELS);
    scene_free(s);
}

static void other_windows_and_orders_are_refused(void **state)
{
    static const uint32_t bad[][2] = {
        {0, 0},   {2, 0},    {30, 2},      {64, 2},          {65, 2},
        {1, 1},   {3, 3},    {5, 5},       {7, 6},           {63, 6},
        {257, 2}, {31, 256}, {0x10001, 2}, {31, UINT32_MAX}, {UINT32_MAX, 2}};
    lum_smooth filter;
    lum_smooth before;
    (void)state;
    memset(&filter, 0x55, sizeof filter);
    memcpy(&before, &filter, sizeof before);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(lum_smooth_init(&filter, bad[i][0], bad[i][1]),
                         LUM_E_VALUE);
    }
    assert_memory_equal(&filter, &before, sizeof before);
}

static void every_window_has_an_order(void **state)
{
    lum_smooth filter;
    (void)state;
    for (uint32_t window = 1; window <= LUM_SMOOTH_WINDOW_MAX; window += 2) {
        assert_int_equal(
            lum_smooth_init(&filter, window, LUM_SMOOTH_ORDER(window)), LUM_OK);
    }
    assert_int_equal(LUM_SMOOTH_ORDER(3u), 1);
    assert_int_equal(LUM_SMOOTH_ORDER(LUM_SMOOTH_WINDOW), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_those_of_the_literature),
        cmocka_unit_test(every_window_and_order_is_the_least_squares_fit),
        cmocka_unit_test(polynomials_up_to_the_order_stay_as_they_are),
        cmocka_unit_test(steep_lines_keep_their_ends),
        cmocka_unit_test(gaps_are_never_bridged),
        cmocka_unit_test(short_runs_get_what_their_length_allows),
        cmocka_unit_test(a_line_without_angles_stays_as_it_is),
        cmocka_unit_test(the_ends_of_the_scale_are_kept),
        cmocka_unit_test(a_line_can_be_smoothed_in_place),
        cmocka_unit_test(off_changes_nothing),
        cmocka_unit_test(other_windows_and_orders_are_refused),
        cmocka_unit_test(every_window_has_an_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
