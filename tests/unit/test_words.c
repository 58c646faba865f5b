#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../tools/common/printable.h"
#include "../tools/lumctl/line_words.h"

#include <stdio.h>

#define MAX 4

struct cut {
    const char *text;
    int count;
    const char *words[MAX];
};

static void a_line_is_cut_at_white_space_outside_quotes(void **state)
{
    static const struct cut cases[] = {
        {"", 0, {NULL}},
        {" \t ", 0, {NULL}},
        {"status", 1, {"status"}},
        {"  power\t50 ", 2, {"power", "50"}},
        {"send \"50p 15y\"", 2, {"send", "50p 15y"}},
        {"send '50p \"u'", 2, {"send", "50p \"u"}},
        {"a\"b c\"d", 1, {"ab cd"}},
        {"send \"\"", 2, {"send", ""}},
        {"a b c d", 4, {"a", "b", "c", "d"}},
        {"a b c d e", -1, {NULL}},
        {"send \"50p", -1, {NULL}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[64];
        char *words[MAX] = {NULL};
        (void)snprintf(text, sizeof text, "%s", cases[i].text);
        assert_int_equal(words_cut(text, words, MAX), cases[i].count);
        for (int k = 0; k < cases[i].count; k++) {
            assert_string_equal(words[k], cases[i].words[k]);
        }
    }
}

static void trimming_takes_white_space_off_both_ends(void **state)
{
    static const char *const cases[][2] = {
        {"", ""}, {"  ", ""}, {" a b\r\n", "a b"}, {"a", "a"}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[16];
        (void)snprintf(text, sizeof text, "%s", cases[i][0]);
        words_trim(text);
        assert_string_equal(text, cases[i][1]);
    }
}

static void what_a_terminal_would_obey_is_not_printed(void **state)
{
    const uint8_t bytes[] = {'a', 0x1b, '[', 0x7f, 0xc3, '\n', ' ', '~'};
    char text[16];
    char cut[4];
    (void)state;
    assert_string_equal(printable(bytes, sizeof bytes, text, sizeof text),
                        "a?[??? ~");
    assert_string_equal(printable(bytes, sizeof bytes, cut, sizeof cut), "a?[");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_is_cut_at_white_space_outside_quotes),
        cmocka_unit_test(trimming_takes_white_space_off_both_ends),
        cmocka_unit_test(what_a_terminal_would_obey_is_not_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
