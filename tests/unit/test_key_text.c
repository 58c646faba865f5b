#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/key_rule.h"

#include <string.h>

#define ROOM 96

static void assert_number(int64_t number, int decimals, const char *expected)
{
    char out[ROOM];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_text_add_number(&text, number, decimals);
    assert_string_equal(out, expected);
    assert_int_equal(text.len, strlen(expected));
}

static void assert_quoted(const char *bytes, size_t len, const char *expected)
{
    char out[ROOM];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_text_add(&text, "it: ");
    lum_key_text_add_quoted(&text, bytes, len);
    assert_memory_equal(out, "it: ", 4);
    assert_string_equal(out + 4, expected);
}

static void a_text_begins_empty(void **state)
{
    (void)state;
    char out[2] = {'x', 'x'};
    const lum_key_text text = lum_key_text_begin(out, sizeof out);
    assert_int_equal(out[0], '\0');
    assert_int_equal(out[1], 'x');
    assert_int_equal(text.len, 0);
    assert_int_equal(text.size, 2);
    out[0] = 'x';
    assert_int_equal(lum_key_text_begin(out, 1).size, 1);
    assert_int_equal(out[0], '\0');
    out[0] = 'x';
    assert_int_equal(lum_key_text_begin(out, 0).size, 0);
    assert_int_equal(out[0], 'x');
}

static void what_does_not_fit_is_counted(void **state)
{
    (void)state;
    char out[8];
    memset(out, 'x', sizeof out);
    lum_key_text text = lum_key_text_begin(out, 5);
    lum_key_text_add(&text, "abc");
    lum_key_text_add_bytes(&text, "defg", 3);
    assert_string_equal(out, "abcd");
    assert_int_equal(out[5], 'x');
    assert_int_equal(text.len, 6);
    lum_key_text nothing = lum_key_text_begin(NULL, 0);
    lum_key_text_add(&nothing, "abc");
    lum_key_text_add_number(&nothing, -25, 1);
    lum_key_text_add_quoted(&nothing, "\n", 1);
    assert_int_equal(nothing.len, 11);
}

static void numbers_have_no_zeros_at_their_end(void **state)
{
    (void)state;
    assert_number(0, 0, "0");
    assert_number(0, 12, "0");
    assert_number(7, 0, "7");
    assert_number(10, 0, "10");
    assert_number(-1, 0, "-1");
    assert_number(-360, 0, "-360");
    assert_number(13000, 3, "13");
    assert_number(12500, 3, "12.5");
    assert_number(1, 3, "0.001");
    assert_number(10, 3, "0.01");
    assert_number(100, 3, "0.1");
    assert_number(-250000, 6, "-0.25");
    assert_number(-100, 1, "-10");
    assert_number(99, 1, "9.9");
    assert_number(1, 12, "0.000000000001");
    assert_number(INT64_C(1000000000000), 12, "1");
    assert_number(INT64_MAX, 0, "9223372036854775807");
    assert_number(INT64_MIN, 0, "-9223372036854775808");
    assert_number(INT64_MIN, 12, "-9223372.036854775808");
}

static void what_is_no_plain_ascii_is_quoted_as_hex(void **state)
{
    (void)state;
    assert_quoted("", 0, "");
    assert_quoted("a b", 3, "a b");
    assert_quoted("abc", 2, "ab");
    assert_quoted(" ~", 2, " ~");
    assert_quoted("\x1f\x7f", 2, "\\x1f\\x7f");
    assert_quoted("\n\xff\x80", 3, "\\x0a\\xff\\x80");
    assert_quoted("a\0b", 3, "a\\x00b");
    assert_quoted("\xc3\xa9", 2, "\\xc3\\xa9");
}

static void long_quotations_are_cut(void **state)
{
    (void)state;
    char bytes[ROOM];
    char expected[ROOM];
    memset(bytes, 'q', sizeof bytes);
    memset(expected, 'q', sizeof expected);
    expected[55] = '\0';
    assert_quoted(bytes, 55, expected);
    expected[55] = 'q';
    expected[56] = '\0';
    assert_quoted(bytes, 56, expected);
    memcpy(expected + 56, "...", 4);
    assert_quoted(bytes, 57, expected);
    assert_quoted(bytes, ROOM, expected);
}

static void a_length_is_that_before_the_end(void **state)
{
    (void)state;
    assert_int_equal(lum_key_text_length(""), 0);
    assert_int_equal(lum_key_text_length("a"), 1);
    assert_int_equal(lum_key_text_length("abc\0def"), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_begins_empty),
        cmocka_unit_test(what_does_not_fit_is_counted),
        cmocka_unit_test(numbers_have_no_zeros_at_their_end),
        cmocka_unit_test(what_is_no_plain_ascii_is_quoted_as_hex),
        cmocka_unit_test(long_quotations_are_cut),
        cmocka_unit_test(a_length_is_that_before_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
