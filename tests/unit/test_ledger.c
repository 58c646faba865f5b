#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumdump/ledger.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char golden[] = "lumdump keep 1\n"
                             "1 0 0\n"
                             "16 1048576 1700000600000000000\n"
                             "17 begun\n"
                             "999999999 18446744073709551615 "
                             "9223372036854775807\n"
                             "end\n";

static const struct ledger_file golden_files[] = {
    {1, true, 0, 0},
    {16, true, 1048576, INT64_C(1700000600000000000)},
    {17, false, 0, 0},
    {999999999, true, UINT64_MAX, INT64_MAX}};

#define GOLDEN_FILES (sizeof golden_files / sizeof golden_files[0])

/* From bytes of which the sanitizer guards the end. */
static enum ledger_text read_exact(struct ledger *ledger, const char *text,
                                   size_t len)
{
    char *exact = malloc(len > 0 ? len : 1u);
    assert_non_null(exact);
    memcpy(exact, text, len);
    *ledger = (struct ledger){0};
    const enum ledger_text result = ledger_read(ledger, exact, len);
    free(exact);
    return result;
}

static void assert_begins_as_golden(const struct ledger *ledger)
{
    assert_true(ledger->count <= GOLDEN_FILES);
    for (size_t i = 0; i < ledger->count; i++) {
        const struct ledger_file *f = &ledger->files[i];
        assert_int_equal(f->number, golden_files[i].number);
        assert_int_equal(f->is_whole, golden_files[i].is_whole);
        assert_true(f->bytes == golden_files[i].bytes);
        assert_true(f->last_ns == golden_files[i].last_ns);
    }
}

static void the_golden_text_is_read_and_written(void **state)
{
    struct ledger ledger;
    size_t len = 0;
    (void)state;
    assert_int_equal(read_exact(&ledger, golden, strlen(golden)), LEDGER_WHOLE);
    assert_int_equal(ledger.count, GOLDEN_FILES);
    assert_begins_as_golden(&ledger);
    char *text = ledger_write(&ledger, &len);
    assert_non_null(text);
    assert_int_equal(len, strlen(golden));
    assert_memory_equal(text, golden, len);
    free(text);
    ledger_free(&ledger);
}

/* What is left of it are files that it had, and no other number or size. */
static void every_truncation_is_damaged_and_a_part_of_the_whole(void **state)
{
    (void)state;
    for (size_t len = 0; len < strlen(golden); len++) {
        struct ledger ledger;
        assert_int_equal(read_exact(&ledger, golden, len), LEDGER_DAMAGED);
        assert_begins_as_golden(&ledger);
        ledger_free(&ledger);
    }
}

static enum ledger_text read_line(const char *line, size_t *count)
{
    char text[200];
    struct ledger ledger;
    (void)snprintf(text, sizeof text, "lumdump keep 1\n2 5 5\n%s\nend\n", line);
    const enum ledger_text result = read_exact(&ledger, text, strlen(text));
    *count = ledger.count;
    ledger_free(&ledger);
    return result;
}

static void each_field_has_its_limits(void **state)
{
    static const char *const good[] = {"3 0 0", "999999999 0 0", "3 begun",
                                       "3 18446744073709551615 0",
                                       "3 0 9223372036854775807"};
    static const char *const bad[] = {"0 0 0",      "1000000000 0 0",
                                      "2 0 0",      "1 0 0",
                                      "03 0 0",     "3 00 0",
                                      "3 0 01",     "-3 0 0",
                                      "3 -1 0",     "3 0 -1",
                                      "+3 0 0",     "3  0 0",
                                      "3 0 0 ",     "3 0",
                                      "3",          "",
                                      " 3 0 0",     "3 0 9223372036854775808",
                                      "3 0 0x",     "3 18446744073709551616 0",
                                      "3 begun ",   "3 begu",
                                      "3 0 0\r",    "99999999999999999999 0 0",
                                      "x-0003 0 0", "../3 0 0",
                                      "3\t0\t0",    "begun"};
    size_t count = 0;
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        assert_int_equal(read_line(good[i], &count), LEDGER_WHOLE);
        assert_int_equal(count, 2);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(read_line(bad[i], &count), LEDGER_DAMAGED);
        assert_int_equal(count, 1);
    }
}

static void what_follows_the_end_is_damage(void **state)
{
    struct ledger ledger;
    (void)state;
    assert_int_equal(read_exact(&ledger, "lumdump keep 1\nend\n3 0 0\n", 25),
                     LEDGER_DAMAGED);
    assert_int_equal(ledger.count, 0);
    ledger_free(&ledger);
}

static void other_texts_are_foreign(void **state)
{
    static const char *const texts[] = {
        "lumsdk\nprocess 12\n",  "lumdump keep 2\nend\n",  "\n", "end\n",
        "Lumdump keep 1\nend\n", "lumdump keep 1\r\nend\n"};
    struct ledger ledger;
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        assert_int_equal(read_exact(&ledger, texts[i], strlen(texts[i])),
                         LEDGER_FOREIGN);
        assert_int_equal(ledger.count, 0);
    }
    assert_int_equal(read_exact(&ledger, "lumdump keep 1\0end\n", 19),
                     LEDGER_FOREIGN);
}

static void numbers_only_rise(void **state)
{
    struct ledger ledger = {0};
    struct ledger_file file = {.number = 0};
    (void)state;
    assert_false(ledger_add(&ledger, &file));
    for (unsigned i = 1; i <= 100; i++) {
        file.number = 2u * i;
        assert_true(ledger_add(&ledger, &file));
        assert_false(ledger_add(&ledger, &file));
    }
    assert_int_equal(ledger_top(&ledger), 200);
    assert_null(ledger_find(&ledger, 3));
    assert_non_null(ledger_find(&ledger, 4));
    ledger_forget(&ledger, 4);
    ledger_forget(&ledger, 3);
    ledger_forget(&ledger, 200);
    assert_null(ledger_find(&ledger, 4));
    assert_int_equal(ledger.count, 98);
    assert_int_equal(ledger_top(&ledger), 198);
    file.number = LEDGER_NUMBER_MAX + 1u;
    assert_false(ledger_add(&ledger, &file));
    file.number = LEDGER_NUMBER_MAX;
    assert_true(ledger_add(&ledger, &file));
    ledger_free(&ledger);
    assert_int_equal(ledger_top(&ledger), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_golden_text_is_read_and_written),
        cmocka_unit_test(every_truncation_is_damaged_and_a_part_of_the_whole),
        cmocka_unit_test(each_field_has_its_limits),
        cmocka_unit_test(what_follows_the_end_is_damage),
        cmocka_unit_test(other_texts_are_foreign),
        cmocka_unit_test(numbers_only_rise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
