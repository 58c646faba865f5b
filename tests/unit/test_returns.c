#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/returns.h"

#include <stdlib.h>

#define UP(tof, pixel)   lum_word_make(tof, true, pixel)
#define DOWN(tof, pixel) lum_word_make(tof, false, pixel)

struct expected {
    uint32_t word;
    uint16_t number;
    uint16_t count;
    uint32_t width;
};

static void assert_returns(const struct expected *rows, size_t n)
{
    uint32_t *words = malloc((n ? n : 1u) * sizeof *words);
    lum_return *out = malloc((n ? n : 1u) * sizeof *out);
    assert_true(words != NULL && out != NULL);
    for (size_t i = 0; i < n; i++) {
        words[i] = rows[i].word;
        out[i] = (lum_return){0xffff, 0xffff, 0xffffffffu};
    }
    lum_returns_compute(words, n, out);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(out[i].number, rows[i].number);
        assert_int_equal(out[i].count, rows[i].count);
        assert_int_equal(out[i].width_tof, rows[i].width);
    }
    free(out);
    free(words);
}

#define ASSERT_RETURNS(...)                                                    \
    assert_returns((const struct expected[]){__VA_ARGS__},                     \
                   sizeof(const struct expected[]){__VA_ARGS__} /              \
                       sizeof(struct expected))

static void no_words_have_no_returns(void **state)
{
    (void)state;
    assert_returns(NULL, 0);
}

static void a_single_word_is_the_first_of_one(void **state)
{
    (void)state;
    ASSERT_RETURNS({UP(5, 0), 1, 1, 0});
    ASSERT_RETURNS({DOWN(5, 999), 1, 1, 0});
}

static void words_are_numbered_by_pixel_and_edge(void **state)
{
    (void)state;
    ASSERT_RETURNS({UP(10, 3), 1, 2, 5}, {DOWN(15, 3), 1, 3, 0},
                   {DOWN(40, 3), 2, 3, 0}, {UP(30, 3), 2, 2, 10},
                   {DOWN(50, 3), 3, 3, 0}, {UP(10, 4), 1, 1, 0},
                   {DOWN(9, 7), 1, 1, 0});
}

static void the_kth_falling_word_ends_the_kth_pulse(void **state)
{
    (void)state;
    /* all rising words first */
    ASSERT_RETURNS({UP(100, 1), 1, 3, 11}, {UP(200, 1), 2, 3, 22},
                   {UP(300, 1), 3, 3, 0}, {DOWN(111, 1), 1, 2, 0},
                   {DOWN(222, 1), 2, 2, 0});
    /* and all falling words first */
    ASSERT_RETURNS({DOWN(111, 1), 1, 2, 0}, {DOWN(222, 1), 2, 2, 0},
                   {UP(100, 1), 1, 1, 11});
}

static void a_width_that_is_not_positive_is_0(void **state)
{
    (void)state;
    ASSERT_RETURNS({UP(100, 1), 1, 1, 0}, {DOWN(100, 1), 1, 1, 0});
    ASSERT_RETURNS({UP(100, 1), 1, 1, 0}, {DOWN(99, 1), 1, 1, 0});
    ASSERT_RETURNS({UP(100, 1), 1, 1, 1}, {DOWN(101, 1), 1, 1, 0});
}

static void the_widest_pulse_spans_all_tofs(void **state)
{
    (void)state;
    ASSERT_RETURNS({UP(LUM_TOF_MIN, 1), 1, 1, 1048575},
                   {DOWN(LUM_TOF_MAX, 1), 1, 1, 0});
    ASSERT_RETURNS({UP(LUM_TOF_MAX, 1), 1, 1, 0},
                   {DOWN(LUM_TOF_MIN, 1), 1, 1, 0});
}

static void a_pulse_does_not_end_in_the_next_pixel(void **state)
{
    (void)state;
    ASSERT_RETURNS({UP(100, 1), 1, 1, 0}, {DOWN(150, 2), 1, 1, 0});
}

static void sixteen_bits_of_words_in_one_pixel_are_numbered(void **state)
{
    const size_t n = 65535;
    uint32_t *words = malloc(n * sizeof *words);
    lum_return *out = malloc(n * sizeof *out);
    (void)state;
    assert_true(words != NULL && out != NULL);
    for (size_t i = 0; i < n; i++) {
        words[i] = UP(7, 12);
    }
    lum_returns_compute(words, n, out);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(out[i].number, i + 1);
        assert_int_equal(out[i].count, n);
    }
    free(out);
    free(words);
}

/* The sentences of the protocol, word by word and quadratic. */
static lum_return look(const uint32_t *words, size_t n, size_t at)
{
    lum_return r = {1, 0, 0};
    unsigned falls = 0;
    const uint32_t w = words[at];
    for (size_t i = 0; i < n; i++) {
        if (lum_word_pixel(words[i]) == lum_word_pixel(w) &&
            lum_word_is_rising(words[i]) == lum_word_is_rising(w)) {
            r.number = (uint16_t)(r.number + (i < at));
            r.count++;
        }
    }
    for (size_t i = 0; i < n; i++) {
        if (lum_word_pixel(words[i]) == lum_word_pixel(w) &&
            !lum_word_is_rising(words[i]) && ++falls == r.number &&
            lum_word_is_rising(w) && lum_word_tof(words[i]) > lum_word_tof(w)) {
            r.width_tof = (uint32_t)(lum_word_tof(words[i]) - lum_word_tof(w));
        }
    }
    return r;
}

static void random_lines_agree_with_the_slow_reading(void **state)
{
    uint64_t seed = 1;
    (void)state;
    for (unsigned round = 0; round < 300; round++) {
        uint32_t words[60];
        lum_return out[60];
        const size_t n = next_random(&seed) % 61;
        uint32_t pixel = 0;
        for (size_t i = 0; i < n; i++) {
            pixel += next_random(&seed) % 4 == 0 ? 1u : 0u;
            words[i] = lum_word_make((int32_t)(next_random(&seed) % 200),
                                     next_random(&seed) % 2 == 0, pixel);
        }
        lum_returns_compute(words, n, out);
        for (size_t i = 0; i < n; i++) {
            const lum_return r = look(words, n, i);
            assert_int_equal(out[i].number, r.number);
            assert_int_equal(out[i].count, r.count);
            assert_int_equal(out[i].width_tof, r.width_tof);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_words_have_no_returns),
        cmocka_unit_test(a_single_word_is_the_first_of_one),
        cmocka_unit_test(words_are_numbered_by_pixel_and_edge),
        cmocka_unit_test(the_kth_falling_word_ends_the_kth_pulse),
        cmocka_unit_test(a_width_that_is_not_positive_is_0),
        cmocka_unit_test(the_widest_pulse_spans_all_tofs),
        cmocka_unit_test(a_pulse_does_not_end_in_the_next_pixel),
        cmocka_unit_test(sixteen_bits_of_words_in_one_pixel_are_numbered),
        cmocka_unit_test(random_lines_agree_with_the_slow_reading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
