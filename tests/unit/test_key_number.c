#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/key_rule.h"
#include "support.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define UNTOUCHED    INT64_C(0x5a5a5a5a5a5a5a5a)

/* Of exactly these bytes: a sanitizer guards the next one. */
static lum_key_number parse(const char *text, int decimals, bool whole,
                            int64_t *out)
{
    const size_t len = strlen(text);
    uint8_t *copy = exact_copy(text, len);
    const lum_key_number result =
        lum_key_number_parse((const char *)copy, len, decimals, whole, out);
    free(copy);
    return result;
}

static void assert_number(const char *text, int decimals, int64_t expected)
{
    int64_t number = UNTOUCHED;
    const lum_key_number result = parse(text, decimals, false, &number);
    if (result != LUM_KEY_NUMBER_FINE || number != expected) {
        fail_msg("<%s>: %d, %" PRId64 ", not %" PRId64, text, (int)result,
                 number, expected);
    }
}

static void assert_refused(const char *text, bool whole,
                           lum_key_number expected)
{
    int64_t number = UNTOUCHED;
    const lum_key_number result = parse(text, 0, whole, &number);
    if (result != expected || number != UNTOUCHED) {
        fail_msg("<%s>: %d, not %d", text, (int)result, (int)expected);
    }
}

static void numbers_are_read_in_units_of_their_decimals(void **state)
{
    (void)state;
    assert_number("0", 0, 0);
    assert_number("9", 0, 9);
    assert_number("-17", 0, -17);
    assert_number("+17", 0, 17);
    assert_number("13.25", 3, 13250);
    assert_number("-0.25", 6, -250000);
    assert_number(".5", 1, 5);
    assert_number("5.", 1, 50);
    assert_number("7", 12, INT64_C(7000000000000));
    assert_number("0.000000000001", 12, 1);
    assert_number("90210", 1, 902100);
}

static void exponents_move_the_point(void **state)
{
    (void)state;
    assert_number("3.0e8", 0, 300000000);
    assert_number("3E+2", 0, 300);
    assert_number("25e-1", 1, 25);
    assert_number("12.5e1", 0, 125);
    assert_number("5e-4", 6, 500);
    assert_number("0.00012e10", 0, 1200000);
    assert_number("1e12", 0, INT64_C(1000000000000));
    assert_number("1e-12", 12, 1);
}

/* Half away from zero; the digit behind the last decides. */
static void what_is_below_a_unit_is_rounded(void **state)
{
    (void)state;
    assert_number("1.4", 0, 1);
    assert_number("1.5", 0, 2);
    assert_number("-1.5", 0, -2);
    assert_number("1.49999", 0, 1);
    assert_number("0.5", 0, 1);
    assert_number("-0.5", 0, -1);
    assert_number("0.4999", 0, 0);
    assert_number("0.05", 0, 0);
    assert_number("0.09", 0, 0);
    assert_number("9e-1", 0, 1);
    assert_number("9e-2", 0, 0);
    assert_number("99e-3", 0, 0);
    assert_number("12345e-9", 6, 12);
    assert_number("19.9995", 3, 20000);
    assert_number("1234e-2", 0, 12);
    assert_number("1250e-2", 0, 13);
}

static void numbers_of_all_64_bits_but_the_last_are_read(void **state)
{
    (void)state;
    assert_number("922337203685477579.9", 1, INT64_C(9223372036854775799));
    assert_refused("9223372036854775800", false, LUM_KEY_NUMBER_TOO_LARGE);
    assert_number("9223372036854775799", 0, INT64_C(9223372036854775799));
    assert_number("-9223372036854775799", 0, -INT64_C(9223372036854775799));
    assert_number("9223372036854775799.5", 0, INT64_C(9223372036854775800));
    assert_refused("9223372036854775810", false, LUM_KEY_NUMBER_TOO_LARGE);
    assert_refused("9999999999999999999", false, LUM_KEY_NUMBER_TOO_LARGE);
    assert_refused("-9999999999999999999", false, LUM_KEY_NUMBER_TOO_LARGE);
    assert_refused("1e19", false, LUM_KEY_NUMBER_TOO_LARGE);
    assert_refused("1e400", false, LUM_KEY_NUMBER_TOO_LARGE);
}

/* As far as the digits go; none of it takes longer than they are many. */
static void exponents_of_any_size_are_read(void **state)
{
    (void)state;
    assert_number("0e999999999999999999999999", 0, 0);
    assert_number("0.0e99", 0, 0);
    assert_number("1e-999999999999999999999999", 12, 0);
    assert_number("-5e-999999", 12, 0);
    assert_refused("1e999999999999999999999999", false,
                   LUM_KEY_NUMBER_TOO_LARGE);
    assert_refused("0.0001e99999999999999999999", false,
                   LUM_KEY_NUMBER_TOO_LARGE);
}

/* An exponent is read to its last digit where it still matters. */
static void a_million_zeros_can_be_undone(void **state)
{
    (void)state;
    const size_t zeros = 999999;
    char *text = calloc(zeros + 32, 1);
    assert_non_null(text);
    text[0] = '.';
    memset(text + 1, '0', zeros);
    memcpy(text + 1 + zeros, "7e1000000", 10);
    assert_number(text, 0, 7);
    memcpy(text + 1 + zeros, "7e999999", 9);
    assert_number(text, 0, 1);
    memcpy(text + 1 + zeros, "7e999998", 9);
    assert_number(text, 0, 0);
    memcpy(text + 1 + zeros, "7e9999999", 10);
    assert_refused(text, false, LUM_KEY_NUMBER_TOO_LARGE);
    free(text);
}

static void what_is_no_number_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "",     "-",    "+",     ".",     "-.",  "e5",   ".e5", "1e",
        "1e+",  "1e-",  "1ex",   "--1",   "+-1", "1-",   " 1",  "1 ",
        "1.2.", "1..2", "0x10",  "1_000", "1,5", "nan",  "inf", "1e5.",
        "1e5e", "1f",   "1e5e5", "/",     ":",   "1/",   "1:",  "*1",
        ",1",   "1d5",  "1D5",   "1F5",   "1f5", "1e,1", "1e/", "1e:"};
    for (size_t i = 0; i < COUNT(texts); i++) {
        assert_refused(texts[i], false, LUM_KEY_NUMBER_NONE);
        assert_refused(texts[i], true, LUM_KEY_NUMBER_NONE);
    }
}

/* What follows the text is not looked at. */
static void a_number_ends_with_its_text(void **state)
{
    (void)state;
    static const struct {
        size_t len;
        int64_t number;
    } rows[] = {{1, 1}, {2, 12}, {3, 12}, {4, 13}, {7, 1270000}};
    int64_t number = UNTOUCHED;
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(
            lum_key_number_parse("12.7e+5", rows[i].len, 0, false, &number),
            LUM_KEY_NUMBER_FINE);
        assert_true(number == rows[i].number);
    }
    assert_int_equal(lum_key_number_parse("12.7e+5", 5, 0, false, &number),
                     LUM_KEY_NUMBER_NONE);
    assert_int_equal(lum_key_number_parse("12.7e+5", 6, 0, false, &number),
                     LUM_KEY_NUMBER_NONE);
    assert_int_equal(lum_key_number_parse("1", 0, 0, false, &number),
                     LUM_KEY_NUMBER_NONE);
    assert_int_equal(lum_key_number_parse("-1", 1, 0, false, &number),
                     LUM_KEY_NUMBER_NONE);
}

static void a_whole_number_has_neither_point_nor_exponent(void **state)
{
    (void)state;
    int64_t number = 0;
    assert_int_equal(parse("-14", 0, true, &number), LUM_KEY_NUMBER_FINE);
    assert_true(number == -14);
    assert_refused("14.", true, LUM_KEY_NUMBER_NOT_WHOLE);
    assert_refused("14.0", true, LUM_KEY_NUMBER_NOT_WHOLE);
    assert_refused("14e0", true, LUM_KEY_NUMBER_NOT_WHOLE);
    assert_refused("14E1", true, LUM_KEY_NUMBER_NOT_WHOLE);
    assert_refused("01.5", true, LUM_KEY_NUMBER_NOT_WHOLE);
}

static void a_leading_zero_is_refused(void **state)
{
    (void)state;
    assert_refused("014", true, LUM_KEY_NUMBER_LEADING_ZERO);
    assert_refused("-014", false, LUM_KEY_NUMBER_LEADING_ZERO);
    assert_refused("00", false, LUM_KEY_NUMBER_LEADING_ZERO);
    assert_refused("00.5", false, LUM_KEY_NUMBER_LEADING_ZERO);
    assert_number("10", 0, 10);
    assert_number("0.25", 2, 25);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_in_units_of_their_decimals),
        cmocka_unit_test(exponents_move_the_point),
        cmocka_unit_test(what_is_below_a_unit_is_rounded),
        cmocka_unit_test(numbers_of_all_64_bits_but_the_last_are_read),
        cmocka_unit_test(exponents_of_any_size_are_read),
        cmocka_unit_test(a_million_zeros_can_be_undone),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(a_number_ends_with_its_text),
        cmocka_unit_test(a_whole_number_has_neither_point_nor_exponent),
        cmocka_unit_test(a_leading_zero_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
