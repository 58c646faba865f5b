#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/key_rule.h"
#include "support.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const lum_key_word sizes[] = {{"small", -1}, {"large", 3}, {NULL, 0}};

static const lum_key_rule range = {
    .min = -25, .max = 1500, .decimals = 1, .unit = "m"};
static const lum_key_rule whole = {.min = 1, .max = 9, .whole = true};
static const lum_key_rule above = {.min = 1, .max = 9, .decimals = 3};
static const lum_key_rule word = {.words = sizes, .min = 0, .max = -1};
static const lum_key_rule both = {.words = sizes,
                                  .min = 8,
                                  .max = 64,
                                  .whole = true,
                                  .unit = "B",
                                  .allowed = "a size from 8 to 64"};
static const lum_key_rule pair = {
    .words = sizes, .min = 2, .max = 9, .pair = true};
static const lum_key_rule rare = {
    .words = sizes, .min = 2, .max = 9, .rare = true, .usual = 77};
static const lum_key_rule single = {.min = 5, .max = 5, .whole = true};

static const char *read_text(const lum_key_rule *rule, const char *text,
                             bool is_quoted, int64_t *out)
{
    return lum_key_rule_read(
        rule, (lum_key_given){text, strlen(text), is_quoted}, out);
}

static void assert_read(const lum_key_rule *rule, const char *text,
                        int64_t expected)
{
    int64_t number = 77;
    const char *why = read_text(rule, text, false, &number);
    if (why != NULL || number != expected) {
        fail_msg("<%s> %s", text, why != NULL ? why : "is another number");
    }
}

static void assert_refused(const lum_key_rule *rule, const char *text,
                           const char *expected)
{
    int64_t number = 77;
    const char *why = read_text(rule, text, false, &number);
    if (why == NULL) {
        fail_msg("<%s> is read", text);
    }
    assert_string_equal(why, expected);
    assert_true(number == 77);
}

static void numbers_are_held_to_their_range(void **state)
{
    (void)state;
    assert_read(&range, "-2.5", -25);
    assert_read(&range, "150", 1500);
    assert_refused(&range, "-2.6", "is out of range");
    assert_refused(&range, "150.1", "is out of range");
    assert_refused(&range, "99999999999999999999", "is out of range");
    assert_read(&single, "5", 5);
    assert_refused(&single, "4", "is out of range");
    assert_refused(&single, "6", "is out of range");
}

static void what_is_no_such_number_says_why(void **state)
{
    (void)state;
    assert_refused(&range, "far", "is not a decimal number");
    assert_refused(&whole, "1.0", "is not a whole number in digits");
    assert_refused(&whole, "01",
                   "begins with 0, which some read as octal; leave the 0 out");
    assert_refused(&word, "huge", "is not known");
    assert_refused(&word, "3", "is not known");
}

static void words_stand_for_numbers(void **state)
{
    (void)state;
    assert_read(&word, "small", -1);
    assert_read(&word, "large", 3);
    assert_read(&both, "large", 3);
    assert_read(&both, "8", 8);
    assert_refused(&both, "larg", "is not a decimal number");
    assert_refused(&both, "larger", "is not a decimal number");
    assert_refused(&both, "Large", "is not a decimal number");
    assert_refused(&both, "3", "is out of range");
}

static void a_word_may_be_quoted_but_no_number(void **state)
{
    (void)state;
    int64_t number = 77;
    assert_null(read_text(&both, "small", true, &number));
    assert_true(number == -1);
    assert_string_equal(read_text(&both, "9", true, &number),
                        "is text; write a number, without quotes");
    assert_string_equal(read_text(&word, "9", true, &number), "is not known");
}

static void both_numbers_of_a_pair_are_held_to_their_range(void **state)
{
    (void)state;
    int64_t number = 77;
    assert_read(&pair, "[2, 9]", LUM_KEY_PAIR(2, 9));
    assert_read(&pair, "[2, 2]", LUM_KEY_PAIR(2, 2));
    assert_read(&pair, "small", -1);
    assert_refused(&pair, "[1, 9]", "is out of range");
    assert_refused(&pair, "[10, 10]", "is out of range");
    assert_refused(&pair, "[3, 1]", "is out of range");
    assert_refused(&pair, "[10, 3]", "is out of range");
    assert_refused(&pair, "[2, 10]", "is out of range");
    assert_refused(&pair, "[3, 2]", "has the higher number first");
    assert_refused(&pair, "(2, 9]", "is not [LOW, HIGH], two whole numbers");
    assert_string_equal(read_text(&pair, "[2, 9]", true, &number),
                        "is text; write [LOW, HIGH], without quotes");
    assert_true(number == 77);
}

static void a_text_need_not_end(void **state)
{
    (void)state;
    int64_t number = 0;
    assert_null(
        lum_key_rule_read(&word, (lum_key_given){"larger", 5, false}, &number));
    assert_true(number == 3);
    assert_null(
        lum_key_rule_read(&both, (lum_key_given){"123", 2, false}, &number));
    assert_true(number == 12);
    assert_null(lum_key_rule_read(&pair, (lum_key_given){"[2,  9]]", 7, false},
                                  &number));
    assert_true(number == LUM_KEY_PAIR(2, 9));
}

/* Nothing behind it is looked at. */
static void a_pair_that_is_cut_is_none(void **state)
{
    static const char given[] = "[2,  9]]";
    const size_t end = strlen(given) - 1;
    (void)state;
    for (size_t len = 0; len <= end + 1; len++) {
        char *const text = (char *)exact_copy(given, len);
        int64_t number = 77;
        const char *const why = lum_key_rule_read(
            &pair, (lum_key_given){text, len, false}, &number);
        if (len == end) {
            assert_null(why);
            assert_true(number == LUM_KEY_PAIR(2, 9));
        } else {
            assert_string_equal(why, "is not [LOW, HIGH], two whole numbers");
            assert_true(number == 77);
        }
        free(text);
    }
}

static void assert_value(const lum_key_rule *rule, int64_t number,
                         const char *expected)
{
    char out[32];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_rule_add_value(rule, number, &text);
    assert_string_equal(out, expected);
}

static void values_are_written_as_they_are_read(void **state)
{
    (void)state;
    assert_value(&range, -25, "-2.5");
    assert_value(&whole, 4, "4");
    assert_value(&word, 3, "large");
    assert_value(&both, -1, "small");
    assert_value(&both, 12, "12");
    assert_true(lum_key_rule_is_word(&both, 3));
    assert_true(lum_key_rule_is_word(&both, -1));
    assert_false(lum_key_rule_is_word(&both, 0));
    assert_false(lum_key_rule_is_word(&both, 12));
    assert_false(lum_key_rule_is_word(&range, 0));
}

static void assert_allowed(const lum_key_rule *rule, const char *expected)
{
    char out[64];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_rule_add_allowed(rule, &text);
    assert_string_equal(out, expected);
}

static void what_is_allowed_is_said(void **state)
{
    (void)state;
    assert_allowed(&range, "-2.5 to 150 m");
    assert_allowed(&whole, "1 to 9");
    assert_allowed(&above, "above 0, at most 0.009");
    assert_allowed(&single, "5 to 5");
    assert_allowed(&word, "small or large");
    assert_allowed(&both, "small or large, or a size from 8 to 64");
    assert_true(lum_key_rule_takes_numbers(&both));
    assert_true(lum_key_rule_takes_numbers(&single));
    assert_true(lum_key_rule_takes_numbers(&rare));
    assert_false(lum_key_rule_takes_numbers(&word));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_held_to_their_range),
        cmocka_unit_test(what_is_no_such_number_says_why),
        cmocka_unit_test(words_stand_for_numbers),
        cmocka_unit_test(a_word_may_be_quoted_but_no_number),
        cmocka_unit_test(both_numbers_of_a_pair_are_held_to_their_range),
        cmocka_unit_test(a_text_need_not_end),
        cmocka_unit_test(a_pair_that_is_cut_is_none),
        cmocka_unit_test(values_are_written_as_they_are_read),
        cmocka_unit_test(what_is_allowed_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
