/* Rows by vectors against those of plain C: the same bytes, and as many as
 * vectors can make. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cloud/text_columns.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROWS 61u /* no multiple of what is made at once */

static const lum_text_style styles[] = {{',', false}, {' ', true}};

static const lum_sample usual = {.x = 161.51f,
                                 .y = -8.91f,
                                 .z = 8.42f,
                                 .range = 161.97f,
                                 .azimuth = 26.84f,
                                 .elevation = -2.97f,
                                 .pulse_width = 2.665f,
                                 .pixel = 68,
                                 .return_number = 1,
                                 .number_of_returns = 1,
                                 .edge = 1};

static float *floats_of(lum_sample *sample)
{
    return &sample->x;
}

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Behind every second line: of one copy, and of more. */
static const char tails[2][32] = {",3\n", ",18446744073709551615,-7\n"};

static void begin_line(lum_text_line *text, uint32_t line, char separator)
{
    const lum_line_samples of = {.struct_size = sizeof of,
                                 .frame = 12,
                                 .timestamp_us = 5000000 + (int64_t)line,
                                 .line = line,
                                 .eye = 1};
    lum_text_line_begin(text, &of, separator);
    if (line % 2u == 0) {
        text->tail = tails[line / 2u % 2u];
        text->tail_bytes = strlen(text->tail);
    }
}

/* Compares up to ROWS rows. taken: how many vectors are expected to make before
 * they stop; SIZE_MAX: any number. */
static void check_rows(const lum_sample *samples, size_t n, size_t taken)
{
    static char want[ROWS * LUM_TEXT_ROW_ROOM];
    static char got[ROWS * LUM_TEXT_ROW_ROOM];
    for (size_t i = 0; i < sizeof styles / sizeof styles[0]; i++) {
        lum_text_line text;
        size_t done = 0;
        char *end = want;
        begin_line(&text, (uint32_t)n, styles[i].separator);
        for (size_t k = 0; k < n; k++) {
            end = lum_put_text_row(end, &text, &samples[k], styles[i]);
        }
        const size_t bytes = (size_t)(end - want);
        assert_int_equal(
            lum_put_text_rows(got, &text, samples, n, styles[i]) - got, bytes);
        assert_memory_equal(got, want, bytes);
        end = lum_put_vector_rows(got, &text, samples, n, styles[i], &done);
        assert_memory_equal(got, want, (size_t)(end - got));
        assert_true(taken == SIZE_MAX || done == taken);
    }
}

static void check_one(const lum_sample *sample, bool is_short)
{
    check_rows(sample, 1, is_short ? 1u : 0u);
}

static bool is_short(float v)
{
    return fabsf(v) <= 999.0f; /* no number is not */
}

static void limits_of_each_float_are_the_same(void **state)
{
    static const float values[] = {
        0.0f,     4.9e-6f,    5e-6f,    5.1e-6f,   4.9e-5f,    5e-5f,
        4.9e-4f,  5e-4f,      0.03125f, 0.015625f, 0.0625f,    0.99995f,
        0.99999f, 0.999995f,  0.9995f,  9.9999f,   9.99995f,   9.999995f,
        10.0f,    99.99995f,  99.9999f, 99.9995f,  99.999995f, 100.0f,
        998.999f, 998.99995f, 999.0f,   999.0001f, 1000.0f,    FLT_MIN,
        FLT_MAX,  INFINITY,   NAN,      16.5f,     123.456f};
    (void)state;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        const float near[] = {values[i], nextafterf(values[i], INFINITY),
                              nextafterf(values[i], -INFINITY)};
        for (size_t k = 0; k < 42u; k++) {
            lum_sample sample = usual;
            const float v = near[k % 3u];
            floats_of(&sample)[k / 6u] = k / 3u % 2u == 0 ? v : -v;
            check_one(&sample, is_short(v));
        }
    }
}

static void any_floats_are_the_same(void **state)
{
    uint32_t seed = 3;
    (void)state;
    for (unsigned round = 0; round < 2000u; round++) {
        lum_sample samples[ROWS];
        for (size_t i = 0; i < ROWS; i++) {
            samples[i] = usual;
            for (size_t k = 0; k < 7u; k++) {
                const float v = (float)((int32_t)next(&seed) - 8388608);
                floats_of(&samples[i])[k] =
                    v * (round % 2u == 0 ? 1e-4f : 1.1e-5f) * 0.999f;
            }
        }
        check_rows(samples, ROWS, round % 2u == 0 ? SIZE_MAX : ROWS);
    }
}

static void floats_of_any_bits_are_the_same(void **state)
{
    uint32_t seed = 4;
    (void)state;
    for (unsigned round = 0; round < 200000u; round++) {
        lum_sample sample = usual;
        const uint32_t bits = next(&seed) << 16 ^ next(&seed);
        const size_t at = round % 7u;
        memcpy(floats_of(&sample) + at, &bits, sizeof bits);
        check_one(&sample, is_short(floats_of(&sample)[at]));
    }
}

/* Hundred-thousandths are made of two groups of four digits: each of them, and
 * many of both. */
static void every_digit_is_the_same(void **state)
{
    lum_sample samples[ROWS];
    size_t n = 0;
    (void)state;
    for (uint32_t i = 0; i < 120000u; i++) {
        const uint32_t v = i < 10000u   ? i
                           : i < 20000u ? (i - 10000u) * 9990u
                                        : (i - 20000u) * 999u;
        const double value = v / 100000.0;
        samples[n] = usual;
        samples[n].x = -(float)value;
        samples[n].azimuth = (float)value;
        samples[n].pulse_width = (float)value;
        samples[n].pixel = (uint16_t)(i % 1000u);
        if (++n == ROWS) {
            check_rows(samples, n, n);
            n = 0;
        }
    }
}

static void integers_at_their_limits_are_the_same(void **state)
{
    static const uint16_t counts[] = {0,    1,     8,     9,     10,    15,
                                      16,   22,    99,    255,   256,   999,
                                      4095, 32767, 32768, 65525, 65530, 65535};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
            lum_sample sample = usual;
            sample.return_number = counts[i];
            sample.number_of_returns = counts[k];
            sample.edge = (uint8_t)(i & 1u);
            check_one(&sample, counts[i] < 10 && counts[k] < 10);
        }
    }
    for (uint32_t pixel = 0; pixel <= UINT16_MAX; pixel++) {
        lum_sample sample = usual;
        sample.pixel = (uint16_t)pixel;
        check_one(&sample, pixel < 1000u);
    }
}

/* Only 0 is no edge, and nobody has to set the padding. */
static void edges_and_padding_are_the_same(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 256u; i++) {
        lum_sample sample = usual;
        sample.edge = (uint8_t)i;
        check_one(&sample, i < 2u);
        sample.edge = 1;
        sample.pad = (uint8_t)i;
        check_one(&sample, i == 0);
    }
}

static void a_long_row_may_stand_anywhere(void **state)
{
    (void)state;
    for (size_t n = 1; n <= ROWS; n++) {
        for (size_t at = 0; at < n; at++) {
            lum_sample samples[ROWS];
            for (size_t i = 0; i < n; i++) {
                samples[i] = usual;
                samples[i].pixel = (uint16_t)i;
            }
            check_rows(samples, n, n);
            samples[at].range = 1234.5f;
            check_rows(samples, n, at);
        }
    }
}

static void long_columns_of_a_line_are_the_same(void **state)
{
    char want[LUM_TEXT_ROW_ROOM];
    char got[LUM_TEXT_ROW_ROOM];
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .frame = INT64_MAX,
                                   .timestamp_us = INT64_MAX - 1,
                                   .line = UINT32_MAX,
                                   .eye = 1};
    lum_text_line text;
    (void)state;
    lum_text_line_begin(&text, &line, ',');
    const char *end = lum_put_text_row(want, &text, &usual, styles[0]);
    assert_int_equal(lum_put_text_rows(got, &text, &usual, 1, styles[0]) - got,
                     end - want);
    assert_memory_equal(got, want, (size_t)(end - want));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_of_each_float_are_the_same),
        cmocka_unit_test(any_floats_are_the_same),
        cmocka_unit_test(floats_of_any_bits_are_the_same),
        cmocka_unit_test(every_digit_is_the_same),
        cmocka_unit_test(integers_at_their_limits_are_the_same),
        cmocka_unit_test(edges_and_padding_are_the_same),
        cmocka_unit_test(a_long_row_may_stand_anywhere),
        cmocka_unit_test(long_columns_of_a_line_are_the_same),
    };
    if (!lum_text_has_vectors()) {
        (void)puts("no vectors of this kind here");
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
