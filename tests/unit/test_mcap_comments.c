#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/comments.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RECORD_MAX 200u

static char seen[RECORD_MAX]; /* each text in brackets */

static void see(void *context, const uint8_t *text, size_t len)
{
    const size_t at = strlen(seen);
    (void)context;
    snprintf(seen + at, sizeof seen - at, "[%.*s]", (int)len,
             (const char *)text);
}

static size_t put(uint8_t *out, const char *text)
{
    const size_t n = strlen(text);
    out[0] = (uint8_t)n;
    memset(out + 1, 0, 3);
    memcpy(out + 4, text, n);
    return 4u + n;
}

/* A record with one pair before another. */
static size_t make(uint8_t out[RECORD_MAX], const char *name, const char *key,
                   const char *value)
{
    size_t n = put(out, name);
    const size_t map = n;
    n += 4u;
    n += put(out + n, "version");
    n += put(out + n, "1");
    n += put(out + n, key);
    n += put(out + n, value);
    memset(out + map, 0, 4);
    out[map] = (uint8_t)(n - map - 4u);
    return n;
}

static void expect(const char *name, const char *key, const char *value,
                   const char *want)
{
    uint8_t record[RECORD_MAX];
    const size_t n = make(record, name, key, value);
    seen[0] = '\0';
    lum_mcap_comments_read(record, n, see, NULL);
    assert_string_equal(seen, want);
}

static void each_document_is_a_text(void **state)
{
    (void)state;
    expect("lumsdk", "provenance", "# a\nb\n", "[# a\nb\n]");
    expect("lumsdk", "provenance", "a\n---\nb\n---\nc", "[a\n][b\n][c]");
    expect("lumsdk", "provenance", "a\n---\n---\nb", "[a\n][---\nb]");
    expect("lumsdk", "provenance", "a\n---", "[a\n---]");
    expect("lumsdk", "provenance", "a\n---\n", "[a\n]");
    expect("lumsdk", "provenance", "", "");
}

static void other_records_have_none(void **state)
{
    (void)state;
    expect("lumsdk2", "provenance", "a", "");
    expect("lumsdk", "origin", "a", "");
    expect("lumsdk", "provenance ", "a", "");
}

/* On the heap, so that a read behind the end is seen. */
static void a_record_cut_anywhere_gives_nothing(void **state)
{
    uint8_t record[RECORD_MAX];
    const size_t n = make(record, "lumsdk", "provenance", "text");
    (void)state;
    for (size_t len = 1; len < n; len++) {
        uint8_t *const cut = malloc(len);
        assert_non_null(cut);
        memcpy(cut, record, len);
        seen[0] = '\0';
        lum_mcap_comments_read(cut, len, see, NULL);
        assert_string_equal(seen, "");
        free(cut);
    }
}

static void lengths_beyond_the_record_are_nothing(void **state)
{
    static const size_t lengths[] = {0, 10, 14}; /* name, pairs, first key */
    uint8_t record[RECORD_MAX];
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        const size_t n = make(record, "lumsdk", "provenance", "text");
        memset(record + lengths[i], 0xff, 4);
        seen[0] = '\0';
        lum_mcap_comments_read(record, n, see, NULL);
        assert_string_equal(seen, "");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_document_is_a_text),
        cmocka_unit_test(other_records_have_none),
        cmocka_unit_test(a_record_cut_anywhere_gives_nothing),
        cmocka_unit_test(lengths_beyond_the_record_are_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
