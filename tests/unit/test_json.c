#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../tools/common/json.h"

#include <math.h>
#include <stdlib.h>

struct text {
    char *bytes;
    size_t len;
    struct json json;
};

static void begin(struct text *text)
{
    FILE *out = open_memstream(&text->bytes, &text->len);
    assert_non_null(out);
    json_init(&text->json, out);
}

static void expect(struct text *text, const char *expected)
{
    assert_int_equal(fclose(text->json.out), 0);
    assert_string_equal(text->bytes, expected);
    free(text->bytes);
}

static void values_are_parted_by_commas_at_every_depth(void **state)
{
    struct text t;
    (void)state;
    begin(&t);
    json_begin_line(&t.json, t.json.out);
    json_int(&t.json, "a", INT64_MIN);
    json_open_array(&t.json, "b");
    json_uint(&t.json, NULL, UINT64_MAX);
    json_open_object(&t.json, NULL);
    json_close_object(&t.json);
    json_bool(&t.json, NULL, true);
    json_close_array(&t.json);
    json_null(&t.json, "c");
    json_text(&t.json, "d", NULL);
    json_end_line(&t.json);
    expect(&t, "{\"a\": -9223372036854775808, \"b\": "
               "[18446744073709551615, {}, true], \"c\": null, \"d\": "
               "null}\n");
}

static void text_is_escaped_and_always_utf8(void **state)
{
    struct text t;
    (void)state;
    begin(&t);
    json_text(&t.json, NULL, "\"\\\n\x01 \xc3\xa4 \xff \xe2\x82");
    expect(&t, "\"\\\"\\\\\\u000a\\u0001 \xc3\xa4 \\ufffd \\ufffd\\ufffd\"");
}

static void only_the_shortest_encoding_of_a_real_character_is_utf8(void **state)
{
    static const struct {
        const char *text;
        const char *expected;
    } cases[] = {
        {"\xc1\xbf", "\"\\ufffd\\ufffd\""},
        {"\xe0\x9f\xbf", "\"\\ufffd\\ufffd\\ufffd\""},
        {"\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\""},
        {"\xf0\x8f\xbf\xbf", "\"\\ufffd\\ufffd\\ufffd\\ufffd\""},
        {"\xf4\x90\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\""},
        {"\xf5\x80\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\""},
        {"\xc2\x80\xe0\xa0\x80\xed\x9f\xbf\xf4\x8f\xbf\xbf",
         "\"\xc2\x80\xe0\xa0\x80\xed\x9f\xbf\xf4\x8f\xbf\xbf\""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct text t;
        begin(&t);
        json_text(&t.json, NULL, cases[i].text);
        expect(&t, cases[i].expected);
    }
}

static void reals_have_their_decimals_and_what_is_no_number_is_null(
    void **state)
{
    struct text t;
    (void)state;
    begin(&t);
    json_open_array(&t.json, NULL);
    json_real(&t.json, NULL, 1.25, 1);
    json_real(&t.json, NULL, -0.5, 3);
    json_real(&t.json, NULL, (double)NAN, 3);
    json_real(&t.json, NULL, (double)INFINITY, 0);
    json_close_array(&t.json);
    expect(&t, "[1.2, -0.500, null, null]");
}

static void members_have_lines_of_their_own_within_a_depth(void **state)
{
    struct text t;
    (void)state;
    begin(&t);
    t.json.lines = 2;
    t.json.keeps_bytes = true;
    json_open_object(&t.json, NULL);
    json_open_array(&t.json, "a");
    json_close_array(&t.json);
    json_open_array(&t.json, "b");
    json_open_object(&t.json, NULL);
    json_int(&t.json, "c", 1);
    json_int(&t.json, "d", 2);
    json_close_object(&t.json);
    json_text(&t.json, NULL, "\xff");
    json_close_array(&t.json);
    json_end_line(&t.json);
    expect(&t, "{\n  \"a\": [],\n  \"b\": [\n    {\"c\": 1, \"d\": 2},\n"
               "    \"\\u00ff\"\n  ]\n}\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_parted_by_commas_at_every_depth),
        cmocka_unit_test(text_is_escaped_and_always_utf8),
        cmocka_unit_test(
            only_the_shortest_encoding_of_a_real_character_is_utf8),
        cmocka_unit_test(
            reals_have_their_decimals_and_what_is_no_number_is_null),
        cmocka_unit_test(members_have_lines_of_their_own_within_a_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
