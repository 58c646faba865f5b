#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/shell_word.h"

#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const struct {
    const char *name;
    const char *word;
} names[] = {
    {"a.pcap", "a.pcap"},
    {"/data/2026-11-22/a_b+c@d%e,f=g:h.pcap",
     "/data/2026-11-22/a_b+c@d%e,f=g:h.pcap"},
    {"my drive.pcap", "'my drive.pcap'"},
    {"it's.pcap", "'it'\\''s.pcap'"},
    {"'", "''\\'''"},
    {"~/a", "'~/a'"},
    {"$HOME;ls", "'$HOME;ls'"},
    {"-q", "./-q"},
    {"-my drive", "./'-my drive'"},
    {"stra\xc3\x9f"
     "e.pcap",
     "'stra\xc3\x9f"
     "e.pcap'"},
    {"", "''"},
};

static void a_word_is_quoted_where_it_must_be(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(names); i++) {
        char out[64];
        assert_ptr_equal(shell_word(names[i].name, out, sizeof out), out);
        assert_string_equal(out, names[i].word);
    }
}

static void a_word_fits_or_there_is_none(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(names); i++) {
        const size_t need = strlen(names[i].word) + 1;
        char out[64];
        memset(out, 'x', sizeof out);
        assert_non_null(shell_word(names[i].name, out, need));
        assert_string_equal(out, names[i].word);
        assert_int_equal(out[need], 'x');
        for (size_t room = 0; room < need; room++) {
            memset(out, 'x', sizeof out);
            assert_null(shell_word(names[i].name, out, room));
            assert_int_equal(out[room], 'x');
        }
    }
}

static void what_upsets_a_terminal_is_no_word(void **state)
{
    (void)state;
    char out[64];
    assert_null(shell_word("a\nb", out, sizeof out));
    assert_null(shell_word("a\x1b[2J", out, sizeof out));
    assert_null(shell_word("a\x7f", out, sizeof out));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_word_is_quoted_where_it_must_be),
        cmocka_unit_test(a_word_fits_or_there_is_none),
        cmocka_unit_test(what_upsets_a_terminal_is_no_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
