#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/key_table.h"

#include <stdbool.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* 33 letters, one more than is held against the known ones. */
#define LONG "abcdefghijklmnopqrstuvwxyzabcdefg"

static const lum_key_rule whole = {.min = 1, .max = 9, .whole = true};
static const lum_key_rule hidden = {
    .min = 0, .max = 1, .whole = true, .refusal = "not from a file"};

static const lum_key_entry entries[] = {
    {"range", 0, &whole},         {"port", 1, &whole},
    {"port.at", 1, &whole},       {"port.width", 2, &whole},
    {"ports", 3, &whole},         {"laser.on", 4, &hidden},
    {"laser.power", 5, &whole},   {"secret", 6, &hidden},
    {"deep.er.still", 7, &whole}, {LONG, 8, &whole},
};
static const lum_key_table table = {entries, COUNT(entries)};

static void a_path_is_within_a_mapping(void **state)
{
    (void)state;
    assert_string_equal(lum_key_within("port.at", "port"), "at");
    assert_string_equal(lum_key_within("deep.er.still", "deep"), "er.still");
    assert_string_equal(lum_key_within("deep.er.still", "deep.er"), "still");
    assert_string_equal(lum_key_within("port.at", ""), "port.at");
    assert_null(lum_key_within("port", "port"));
    assert_null(lum_key_within("ports", "port"));
    assert_null(lum_key_within("por", "port"));
    assert_null(lum_key_within("range", "port"));
}

static void assert_found(const char *path, const char *name, size_t expected)
{
    assert_int_equal(lum_key_table_find(&table, path, name, strlen(name)),
                     expected);
}

static void the_first_entry_of_a_key_is_found(void **state)
{
    (void)state;
    assert_found("", "range", 0);
    assert_found("", "port", 1);
    assert_found("", "ports", 4);
    assert_found("port", "at", 2);
    assert_found("port", "width", 3);
    assert_found("", "laser", 5);
    assert_found("deep", "er", 8);
    assert_found("deep.er", "still", 8);
    assert_found("", "por", COUNT(entries));
    assert_found("", "", COUNT(entries));
    assert_found("port", "wide", COUNT(entries));
    assert_found("range", "at", COUNT(entries));
    assert_int_equal(lum_key_table_find(&table, "", "ports", 4), 1);
}

static void an_entry_has_exactly_its_path(void **state)
{
    (void)state;
    assert_ptr_equal(lum_key_table_entry(&table, "range"), &entries[0]);
    assert_ptr_equal(lum_key_table_entry(&table, "port"), &entries[1]);
    assert_ptr_equal(lum_key_table_entry(&table, "port.width"), &entries[3]);
    assert_ptr_equal(lum_key_table_entry(&table, LONG), &entries[9]);
    assert_null(lum_key_table_entry(&table, "laser"));
    assert_null(lum_key_table_entry(&table, "rang"));
    assert_null(lum_key_table_entry(&table, "ranges"));
    assert_null(lum_key_table_entry(&table, ""));
}

static void a_mapping_has_keys_below_it(void **state)
{
    (void)state;
    assert_true(lum_key_table_is_mapping(&table, ""));
    assert_true(lum_key_table_is_mapping(&table, "port"));
    assert_true(lum_key_table_is_mapping(&table, "laser"));
    assert_true(lum_key_table_is_mapping(&table, "deep.er"));
    assert_false(lum_key_table_is_mapping(&table, "range"));
    assert_false(lum_key_table_is_mapping(&table, LONG));
    assert_false(lum_key_table_is_mapping(&table, "other"));
    static const lum_key_entry first[] = {{"only.one", 0, &whole}};
    static const lum_key_table single = {first, COUNT(first)};
    assert_true(lum_key_table_is_mapping(&single, "only"));
}

static void assert_names(const char *path, const char *expected)
{
    char out[128];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_table_add_names(&table, path, &text);
    assert_string_equal(out, expected);
}

static void keys_that_may_be_given_are_named_once(void **state)
{
    (void)state;
    assert_names("", "range, port, ports, deep, " LONG);
    assert_names("port", "at, width");
    assert_names("laser", "power");
    assert_names("range", "");
}

static void assert_value(const char *path, const char *expected)
{
    char out[128];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_table_refuse_value(&table, path, "is wrong", &text);
    assert_string_equal(out, expected);
}

static void what_a_path_takes_is_said(void **state)
{
    (void)state;
    assert_value("range", "is wrong; allowed: 1 to 9");
    assert_value("laser", "is wrong; allowed: a mapping of power");
    assert_value("port",
                 "is wrong; allowed: 1 to 9, or a mapping of at, width");
}

#define HERE " allowed here: range, port, ports, deep, " LONG

static void assert_key(const char *name, const char *expected)
{
    char out[256];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    lum_key_table_refuse_key(&table, "", name, strlen(name), &text);
    assert_string_equal(out, expected);
}

static void the_nearest_key_is_proposed(void **state)
{
    (void)state;
    assert_key("rage", "unknown key 'rage'; did you mean 'range'?" HERE);
    assert_key("rannge", "unknown key 'rannge'; did you mean 'range'?" HERE);
    assert_key("rango", "unknown key 'rango'; did you mean 'range'?" HERE);
    assert_key("ragne", "unknown key 'ragne';" HERE);
    assert_key("Xange", "unknown key 'Xange'; did you mean 'range'?" HERE);
    assert_key("ange", "unknown key 'ange'; did you mean 'range'?" HERE);
    assert_key("orange", "unknown key 'orange'; did you mean 'range'?" HERE);
    assert_key("xxxrange", "unknown key 'xxxrange';" HERE);
    assert_key("rangexy", "unknown key 'rangexy';" HERE);
    assert_key("prts", "unknown key 'prts'; did you mean 'ports'?" HERE);
    assert_key("por", "unknown key 'por'; did you mean 'port'?" HERE);
    assert_key("po", "unknown key 'po';" HERE);
    assert_key("", "unknown key '';" HERE);
    assert_key("secrets", "unknown key 'secrets';" HERE);
}

static void of_keys_as_near_the_first_is_proposed(void **state)
{
    static const lum_key_entry names[] = {{"abcdefghij", 0, &whole},
                                          {"a", 1, &whole}};
    static const lum_key_table few = {names, COUNT(names)};
    char out[128];
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    (void)state;
    lum_key_table_refuse_key(&few, "", "abcdefghijk", 11, &text);
    assert_string_equal(out, "unknown key 'abcdefghijk'; did you mean "
                             "'abcdefghij'? allowed here: abcdefghij, a");
    assert_key("portx", "unknown key 'portx'; did you mean 'port'?" HERE);
    assert_key("portss", "unknown key 'portss'; did you mean 'ports'?" HERE);
}

/* At most two letters, and a third of either key's. */
static void what_is_far_is_not_proposed(void **state)
{
    (void)state;
    static const lum_key_entry names[] = {{"abcdef", 0, &whole},
                                          {"abcdefghij", 1, &whole}};
    static const lum_key_table few = {names, COUNT(names)};
    static const struct {
        const char *name;
        const char *says;
    } rows[] = {
        {"abcdxx", "; did you mean 'abcdef'? "},
        {"abcxxx", "; "},
        {"abcdexxxij", "; "},
        {"abcdefghxx", "; did you mean 'abcdefghij'? "},
        {"abcdefghijxx", "; did you mean 'abcdefghij'? "},
        {"abcdefghijxxx", "; "},
        {"abcd", "; "},
        {"abcde", "; did you mean 'abcdef'? "},
        {"xbcdefghij", "; did you mean 'abcdefghij'? "},
        {"bcdefghij", "; did you mean 'abcdefghij'? "},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char out[128];
        lum_key_text text = lum_key_text_begin(out, sizeof out);
        lum_key_table_refuse_key(&few, "", rows[i].name, strlen(rows[i].name),
                                 &text);
        const char *says =
            out + strlen("unknown key ''") + strlen(rows[i].name);
        assert_memory_equal(says, rows[i].says, strlen(rows[i].says));
        assert_string_equal(says + strlen(rows[i].says),
                            "allowed here: abcdef, abcdefghij");
    }
}

/* Keys of up to 32 letters are compared; of a known one no more. */
static void long_keys_are_compared_as_far_as_there_is_room(void **state)
{
    (void)state;
    assert_key("abcdefghijklmnopqrstuvwxyzabcdef",
               "unknown key 'abcdefghijklmnopqrstuvwxyzabcdef'; did you mean "
               "'" LONG "'?" HERE);
    assert_key("abcdefghijklmnopqrstuvwxyzabcd",
               "unknown key 'abcdefghijklmnopqrstuvwxyzabcd'; did you mean "
               "'" LONG "'?" HERE);
    assert_key("abcdefgh--klmnopqrstuvwxyzabcdef",
               "unknown key 'abcdefgh--klmnopqrstuvwxyzabcdef'; did you mean "
               "'" LONG "'?" HERE);
    assert_key("abcdefghijklmnopqrstuvwxyzabcdexy",
               "unknown key 'abcdefghijklmnopqrstuvwxyzabcdexy';" HERE);
}

static void a_value_is_read_or_the_reason_said(void **state)
{
    (void)state;
    char out[128];
    int64_t number = 77;
    lum_key_text text = lum_key_text_begin(out, sizeof out);
    assert_true(lum_key_table_read(
        &table, &entries[1], (lum_key_given){"42", 1, false}, &number, &text));
    assert_true(number == 4);
    assert_string_equal(out, "");
    assert_false(lum_key_table_read(
        &table, &entries[1], (lum_key_given){"42", 2, false}, &number, &text));
    assert_true(number == 4);
    assert_string_equal(out, "'42' is out of range; allowed: 1 to 9, or a "
                             "mapping of at, width");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_path_is_within_a_mapping),
        cmocka_unit_test(the_first_entry_of_a_key_is_found),
        cmocka_unit_test(an_entry_has_exactly_its_path),
        cmocka_unit_test(a_mapping_has_keys_below_it),
        cmocka_unit_test(keys_that_may_be_given_are_named_once),
        cmocka_unit_test(what_a_path_takes_is_said),
        cmocka_unit_test(the_nearest_key_is_proposed),
        cmocka_unit_test(of_keys_as_near_the_first_is_proposed),
        cmocka_unit_test(what_is_far_is_not_proposed),
        cmocka_unit_test(long_keys_are_compared_as_far_as_there_is_room),
        cmocka_unit_test(a_value_is_read_or_the_reason_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
