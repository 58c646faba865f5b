#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cloud/decimal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state;
}

/* printf rounds exact halves to even, we round them away from zero. */
static void expect_float(char *out, size_t size, float v, unsigned decimals)
{
    const double scaled = fabs((double)v) * lum_decimal_unit(decimals);
    if (isnan(v)) {
        snprintf(out, size, "nan;");
    } else if (scaled < 4e15 && scaled - floor(scaled) == 0.5) {
        const long long up = (long long)floor(scaled) + 1;
        const long long unit = lum_decimal_unit(decimals);
        snprintf(out, size, "%s%lld.%0*lld;", v < 0 ? "-" : "", up / unit,
                 (int)decimals, up % unit);
    } else {
        snprintf(out, size, "%.*f;", (int)decimals, (double)v);
        if (out[0] == '-' && strspn(out, "-0.;") == strlen(out)) {
            memmove(out, out + 1, strlen(out));
        }
    }
}

static void check_float(float v)
{
    for (unsigned decimals = 3; decimals <= LUM_DECIMALS_MAX; decimals++) {
        char want[96];
        char got[LUM_DECIMAL_ROOM];
        expect_float(want, sizeof want, v, decimals);
        char *end = lum_put_column(got, v, decimals, ';');
        assert_true((size_t)(end - got) + 8u <= sizeof got);
        *end = '\0';
        assert_string_equal(got, want);
    }
}

static void a_column_is_what_printf_prints_but_for_ties(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < 300000; i++) {
        const float v = (float)(int32_t)next(&seed) / 65536.0f;
        check_float(v);
        check_float(v / 1000.0f);
    }
}

static void floats_of_any_bits_are_what_printf_prints(void **state)
{
    (void)state;
    uint32_t seed = 2;
    for (int i = 0; i < 300000; i++) {
        const uint32_t bits = next(&seed);
        float v;
        memcpy(&v, &bits, sizeof v);
        check_float(v);
    }
}

static void limits_are_what_printf_prints(void **state)
{
    static const float values[] = {
        0.0f,      998.9999f,  998.99995f,    999.0f,     999.00005f,
        999.9999f, 999.99995f, 1000.0f,       9998.9995f, 9998.9999f,
        9999.0f,   9999.0005f, 9999.9995f,    9999.99f,   10000.0f,
        99999.99f, 214748.0f,  2147483648.0f, 1e10f,      9e13f,
        9.2e14f,   1e15f,      1e20f,         FLT_MAX,    FLT_MIN,
        INFINITY,  NAN,        1e-7f,         4.9e-5f,    5e-5f,
        5.1e-5f,   0.9999f,    0.99995f,      0.99999f,   0.999995f};
    (void)state;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        check_float(values[i]);
        check_float(-values[i]);
        check_float(nextafterf(values[i], INFINITY));
        check_float(nextafterf(values[i], -INFINITY));
    }
}

static void check_column(float v, unsigned decimals, const char *want)
{
    char got[LUM_DECIMAL_ROOM];
    *lum_put_column(got, v, decimals, '|') = '\0';
    assert_string_equal(got, want);
}

static void what_rounds_to_zero_has_no_sign(void **state)
{
    (void)state;
    check_column(-0.0f, 4, "0.0000|");
    check_column(-0.00004f, 4, "0.0000|");
    check_column(-0.00006f, 4, "-0.0001|");
    check_column(-0.000004f, 5, "0.00000|");
    check_column(-0.0004f, 3, "0.000|");
}

static void halves_round_away_from_zero(void **state)
{
    (void)state;
    check_column(0.03125f, 4, "0.0313|");
    check_column(-0.03125f, 4, "-0.0313|");
    check_column(0.0625f, 3, "0.063|");
    check_column(0.015625f, 5, "0.01563|");
    check_column(16384.03125f, 4, "16384.0313|");
}

static void check_fixed(int64_t scaled, unsigned decimals, const char *want)
{
    char got[LUM_DECIMAL_ROOM];
    *lum_put_fixed(got, scaled, decimals) = '\0';
    assert_string_equal(got, want);
}

static void fixed_decimals_hold_any_integer(void **state)
{
    (void)state;
    check_fixed(0, 4, "0.0000");
    check_fixed(-1, 4, "-0.0001");
    check_fixed(-1, 0, "-1");
    check_fixed(123456, 1, "12345.6");
    check_fixed(123456, 2, "1234.56");
    check_fixed(123456, 5, "1.23456");
    check_fixed(INT64_MAX, 5, "92233720368547.75807");
    check_fixed(INT64_MIN, 5, "-92233720368547.75808");
    check_fixed(INT64_MIN, 0, "-9223372036854775808");
}

static void check_seconds(int64_t ns, const char *want)
{
    char got[LUM_DECIMAL_ROOM];
    *lum_put_nanoseconds(got, ns) = '\0';
    assert_string_equal(got, want);
}

static void seconds_have_nanoseconds(void **state)
{
    (void)state;
    check_seconds(0, "0.000000000");
    check_seconds(99995874, "0.099995874");
    check_seconds(-1, "-0.000000001");
    check_seconds(INT64_MAX, "9223372036.854775807");
    check_seconds(INT64_MIN, "-9223372036.854775808");
}

static void check_integer(int64_t v)
{
    char want[32];
    char got[LUM_DECIMAL_ROOM];
    snprintf(want, sizeof want, "%lld", (long long)v);
    *lum_put_i64(got, v) = '\0';
    assert_string_equal(got, want);
    snprintf(want, sizeof want, "%llu", (unsigned long long)v);
    *lum_put_u64(got, (uint64_t)v) = '\0';
    assert_string_equal(got, want);
}

static void integers_of_every_length_are_right(void **state)
{
    (void)state;
    for (int64_t v = 0; v < 20000; v++) {
        check_integer(v);
    }
    for (uint64_t power = 1; power < UINT64_MAX / 10u; power *= 10u) {
        check_integer((int64_t)power);
        check_integer((int64_t)power - 1);
        check_integer(-(int64_t)power);
    }
    check_integer(INT64_MAX);
    check_integer(INT64_MIN);
    check_integer(-1);
}

static void numbers_of_three_digits_come_from_tables(void **state)
{
    (void)state;
    for (unsigned v = 0; v < 1000u; v++) {
        char want[16];
        char got[8] = "";
        snprintf(want, sizeof want, "%u", v);
        *lum_put_three(got, v) = '\0';
        assert_string_equal(got, want);
        snprintf(want, sizeof want, "%03u", v);
        lum_put_four(got, lum_full_digits[v]);
        assert_string_equal(got, want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_column_is_what_printf_prints_but_for_ties),
        cmocka_unit_test(floats_of_any_bits_are_what_printf_prints),
        cmocka_unit_test(limits_are_what_printf_prints),
        cmocka_unit_test(what_rounds_to_zero_has_no_sign),
        cmocka_unit_test(halves_round_away_from_zero),
        cmocka_unit_test(fixed_decimals_hold_any_integer),
        cmocka_unit_test(seconds_have_nanoseconds),
        cmocka_unit_test(integers_of_every_length_are_right),
        cmocka_unit_test(numbers_of_three_digits_come_from_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
