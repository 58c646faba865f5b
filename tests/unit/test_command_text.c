#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "command_table.h"
#include "support.h"

#include "lum/host/command_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static lum_result parse(const char *text, lum_command *out, size_t *left)
{
    const size_t len = strlen(text);
    char *exact = (char *)exact_copy(text, len);
    const char *at = exact;
    *left = len;
    const lum_result r = lum_command_parse(&at, left, out);
    assert_ptr_equal(at, exact + (len - *left));
    free(exact);
    return r;
}

static int is_in_table(size_t row, int value)
{
    if (table[row].min < 0) {
        return value == 0;
    }
    return value >= table[row].min && value <= table[row].max &&
           (value - table[row].min) % table[row].step == 0;
}

static void every_number_is_read_or_refused(void **state)
{
    (void)state;
    for (size_t row = 2; row < LUM_COMMANDS; row++) {
        for (int value = 0; value <= 1200; value++) {
            char text[16];
            lum_command out = {LUM_COMMAND_LASER_OFF, 4711};
            size_t left = 0;
            snprintf(text, sizeof text, "%d%c", value, table[row].letter);
            const lum_result r = parse(text, &out, &left);
            if (is_in_table(row, value)) {
                assert_int_equal(r, LUM_OK);
                assert_int_equal(out.id, table[row].id);
                assert_int_equal(out.value, value);
                assert_int_equal(left, 0);
            } else {
                assert_int_equal(r, LUM_E_VALUE);
                assert_int_equal(out.value, 4711);
                assert_int_equal(left, strlen(text));
            }
        }
    }
}

static void what_is_not_a_command_is_refused(void **state)
{
    static const char *const texts[] = {
        "p",   "U",   "D",   "x",    "5",    "55",  " u",  "u ",   "+5p",
        "-5p", "05p", "00p", "5 p",  "5.0p", "Of",  "of",  "0u",   "1d",
        "00f", "5P",  "u,d", "5pp",  "u\n",  "p5",  "ud",  "5p6g", "\xff",
        "5p ", " ",   "0",   "150H", "0x5p", "5pu", "f0f", "1/p",  "1:p",
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        lum_command out = {LUM_COMMAND_YSCAN, 4711};
        size_t left = 0;
        assert_int_equal(parse(texts[i], &out, &left), LUM_E_MALFORMED);
        assert_true(out.id == LUM_COMMAND_YSCAN && out.value == 4711);
        assert_int_equal(left, strlen(texts[i]));
    }
}

static void a_number_past_every_width_is_out_of_range(void **state)
{
    static const char *const texts[] = {
        "65536p",
        "65546p",
        "131072f",
        "4294967296p",
        "4294967297f",
        "18446744073709551616p",
        "99999999999999999999999999999999h",
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        lum_command out = {LUM_COMMAND_YSCAN, 4711};
        size_t left = 0;
        assert_int_equal(parse(texts[i], &out, &left), LUM_E_VALUE);
        assert_int_equal(out.value, 4711);
    }
}

static void one_space_parts_commands(void **state)
{
    static const char text[] = "u 55p 0f 150h d";
    static const lum_command golden[] = {{LUM_COMMAND_LASER_ON, 0},
                                         {LUM_COMMAND_POWER, 55},
                                         {LUM_COMMAND_LINE_MODE, 0},
                                         {LUM_COMMAND_HOLDOFF, 150},
                                         {LUM_COMMAND_LASER_OFF, 0}};
    const char *at = text;
    size_t left = sizeof text - 1;
    lum_command out;
    (void)state;
    for (size_t i = 0; i < 5; i++) {
        assert_int_equal(lum_command_parse(&at, &left, &out), LUM_OK);
        assert_int_equal(out.id, golden[i].id);
        assert_int_equal(out.value, golden[i].value);
    }
    assert_int_equal(lum_command_parse(&at, &left, &out), LUM_END);
    assert_int_equal(left, 0);
}

static void a_second_space_stands_before_no_command(void **state)
{
    static const char text[] = "u  d";
    const char *at = text;
    size_t left = sizeof text - 1;
    lum_command out;
    lum_result r = LUM_OK;
    (void)state;
    do {
        r = lum_command_parse(&at, &left, &out);
    } while (r == LUM_OK);
    assert_int_equal(r, LUM_E_MALFORMED);
}

static void every_truncation_of_a_command_is_refused(void **state)
{
    static const char text[] = "150h";
    (void)state;
    for (size_t n = 0; n < sizeof text - 1; n++) {
        char *exact = (char *)exact_copy(text, n);
        const char *at = exact;
        size_t left = n;
        lum_command out = {LUM_COMMAND_YSCAN, 4711};
        assert_int_equal(lum_command_parse(&at, &left, &out),
                         n == 0 ? LUM_END : LUM_E_MALFORMED);
        assert_ptr_equal(at, exact);
        assert_int_equal(out.value, 4711);
        free(exact);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_number_is_read_or_refused),
        cmocka_unit_test(what_is_not_a_command_is_refused),
        cmocka_unit_test(a_number_past_every_width_is_out_of_range),
        cmocka_unit_test(one_space_parts_commands),
        cmocka_unit_test(a_second_space_stands_before_no_command),
        cmocka_unit_test(every_truncation_of_a_command_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
