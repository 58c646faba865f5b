#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "command_table.h"
#include "lum/command.h"

#include <stdio.h>

static int is_in_table(size_t row, int value)
{
    if (table[row].min < 0) {
        return value == 0;
    }
    return value >= table[row].min && value <= table[row].max &&
           (value - table[row].min) % table[row].step == 0;
}

static void every_value_is_written_or_refused(void **state)
{
    (void)state;
    assert_int_equal(sizeof table / sizeof table[0], LUM_COMMANDS);
    for (size_t row = 0; row < LUM_COMMANDS; row++) {
        for (int value = 0; value <= 65535; value++) {
            const lum_command in = {table[row].id, (uint16_t)value};
            char out[LUM_COMMAND_TEXT_BYTES] = "?????";
            size_t len = 77;
            const lum_result r = lum_command_format(&in, out, &len);
            if (!is_in_table(row, value)) {
                assert_int_equal(r, LUM_E_VALUE);
                assert_true(len == 77 && out[0] == '?');
                continue;
            }
            char golden[16] = "";
            const int has_value = table[row].min >= 0;
            const int n = has_value ? snprintf(golden, sizeof golden, "%d%c",
                                               value, table[row].letter)
                                    : snprintf(golden, sizeof golden, "%c",
                                               table[row].letter);
            assert_int_equal(r, LUM_OK);
            assert_int_equal(len, n);
            assert_memory_equal(out, golden, len);
        }
    }
}

/* Tools read the table: without a value every entry is 0 and the step 1. */
static void the_table_of_commands_is_the_manuals(void **state)
{
    (void)state;
    for (size_t row = 0; row < LUM_COMMANDS; row++) {
        const lum_command_spec *spec = &lum_command_specs[table[row].id];
        const int has_value = table[row].min >= 0;
        assert_int_equal(spec->letter, table[row].letter);
        assert_int_equal(spec->has_value, has_value);
        assert_int_equal(spec->min, has_value ? table[row].min : 0);
        assert_int_equal(spec->max, has_value ? table[row].max : 0);
        assert_int_equal(spec->step, table[row].step);
    }
}

static void an_unknown_id_has_no_text(void **state)
{
    const lum_command beyond = {LUM_COMMANDS, 0};
    char out[LUM_COMMAND_TEXT_BYTES];
    size_t len = 77;
    (void)state;
    assert_int_equal(lum_command_format(&beyond, out, &len), LUM_E_VALUE);
    assert_int_equal(len, 77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_value_is_written_or_refused),
        cmocka_unit_test(the_table_of_commands_is_the_manuals),
        cmocka_unit_test(an_unknown_id_has_no_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
