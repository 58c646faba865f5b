#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/source_internal.h"

#include <stdlib.h>
#include <string.h>

enum {
    LEN = 1000000,
    FAILS_AT_ITS_END = -1,
    GIVES_TOO_MUCH = -2
};

/* A caller's source: pieces of given sizes, then an end. */
struct feed {
    const uint8_t *bytes;
    size_t len;
    size_t piece;
    int at_end;
    size_t given;
    int calls_after_end;
    int closed;
};

static int64_t read_feed(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    struct feed *f = context;
    size_t n = f->len - f->given;
    n = n < f->piece ? n : f->piece;
    n = n < room ? n : room;
    memcpy(buffer, f->bytes + f->given, n);
    f->given += n;
    if (n != 0) {
        return (int64_t)n;
    }
    f->calls_after_end++;
    if (f->at_end == FAILS_AT_ITS_END) {
        return lum_error_set(error, "the store is gone");
    }
    return f->at_end == GIVES_TOO_MUCH ? (int64_t)room + 1 : 0;
}

static void close_feed(void *context)
{
    ((struct feed *)context)->closed++;
}

static uint8_t *make_bytes(void)
{
    uint8_t *bytes = malloc(LEN);
    assert_non_null(bytes);
    for (size_t i = 0; i < LEN; i++) {
        bytes[i] = (uint8_t)(i * 31u + i / 251u);
    }
    return bytes;
}

static lum_source *source_of(struct feed *f)
{
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = read_feed,
                                            .close = close_feed,
                                            .context = f,
                                            .total = f->len};
    lum_source *s = lum_source_from_functions("feed", &functions, NULL);
    assert_non_null(s);
    return s;
}

/* Requested bytes are there in one piece, although they came in any pieces. */
static void any_sizes_come_in_order(void **state)
{
    uint8_t *bytes = make_bytes();
    const size_t pieces[] = {1, 7, 4096, 300000, LEN};
    (void)state;
    for (size_t i = 0; i < sizeof pieces / sizeof pieces[0]; i++) {
        struct feed f = {.bytes = bytes, .len = LEN, .piece = pieces[i]};
        lum_source *s = source_of(&f);
        size_t at = 0;
        for (size_t n = 1; at < LEN; n = n * 3u % 400009u) {
            const size_t want = n < LEN - at ? n : LEN - at;
            assert_true(lum_source_has(s, want));
            assert_int_equal(lum_source_offset(s), at);
            assert_memory_equal(s->at, bytes + at, want);
            lum_source_take(s, want);
            at += want;
        }
        assert_false(lum_source_has(s, 1));
        assert_false(lum_source_has(s, 1));
        assert_int_equal(f.calls_after_end, 1);
        assert_false(s->has_failed);
        lum_source_close(s);
        assert_int_equal(f.closed, 1);
    }
    free(bytes);
}

/* Bytes that were read but not taken are there again with more after them. */
static void what_is_not_taken_stays(void **state)
{
    uint8_t *bytes = make_bytes();
    struct feed f = {.bytes = bytes, .len = LEN, .piece = 1000};
    lum_source *s = source_of(&f);
    (void)state;
    for (size_t n = 1; n <= LEN; n += 9973) {
        assert_true(lum_source_has(s, n));
        assert_memory_equal(s->at, bytes, n);
    }
    assert_true(lum_source_has(s, LEN));
    assert_false(lum_source_has(s, LEN + 1));
    assert_int_equal(s->left, LEN);
    assert_memory_equal(s->at, bytes, LEN);
    lum_source_close(s);
    free(bytes);
}

static void memory_is_read_in_place(void **state)
{
    static const uint8_t bytes[] = {1, 2, 3};
    lum_source *s = lum_source_from_memory("three", bytes, sizeof bytes);
    (void)state;
    assert_non_null(s);
    assert_true(lum_source_has(s, 3));
    assert_ptr_equal(s->at, bytes);
    assert_false(lum_source_has(s, 4));
    lum_source_take(s, 3);
    assert_false(lum_source_has(s, 1));
    assert_int_equal(lum_source_offset(s), 3);
    lum_source_close(s);
    lum_source_close(NULL);
}

static void a_skip_may_go_beyond_what_fits(void **state)
{
    uint8_t *bytes = make_bytes();
    struct feed f = {.bytes = bytes, .len = LEN, .piece = 50000};
    lum_source *s = source_of(&f);
    (void)state;
    assert_true(lum_source_has(s, 10));
    assert_true(lum_source_skip(s, 5));
    assert_true(lum_source_skip(s, LEN - 6));
    assert_int_equal(lum_source_offset(s), LEN - 1);
    assert_true(lum_source_has(s, 1));
    assert_int_equal(s->at[0], bytes[LEN - 1]);
    assert_false(lum_source_skip(s, 2));
    lum_source_close(s);
    free(bytes);
}

static void a_failure_is_kept_behind_what_was_read(void **state)
{
    static const uint8_t bytes[] = {1, 2, 3};
    struct feed f = {bytes, 3, 2, FAILS_AT_ITS_END, 0, 0, 0};
    lum_source *s = source_of(&f);
    (void)state;
    assert_true(lum_source_has(s, 3));
    assert_false(s->has_failed);
    assert_false(lum_source_has(s, 4));
    assert_false(lum_source_has(s, 4));
    assert_int_equal(f.calls_after_end, 1);
    assert_true(s->has_failed);
    assert_string_equal(s->error.text, "the store is gone");
    assert_memory_equal(s->at, bytes, 3);
    lum_source_close(s);
}

static void a_function_that_gives_too_much_has_failed(void **state)
{
    struct feed f = {NULL, 0, 1, GIVES_TOO_MUCH, 0, 0, 0};
    lum_source *s = NULL;
    (void)state;
    f.bytes = (const uint8_t *)"";
    s = source_of(&f);
    assert_false(lum_source_has(s, 1));
    assert_true(s->has_failed);
    assert_non_null(strstr(s->error.text, "more bytes than"));
    lum_source_close(s);
}

static void more_than_a_window_is_not_held(void **state)
{
    struct feed f = {.bytes = (const uint8_t *)"x", .len = 1, .piece = 1};
    lum_source *s = source_of(&f);
    (void)state;
    assert_false(lum_source_has(s, LUM_SOURCE_WINDOW_MAX + 1u));
    assert_false(s->has_ended);
    assert_true(lum_source_has(s, 1));
    lum_source_close(s);
}

static void progress_knows_the_total_that_the_caller_gave(void **state)
{
    uint8_t *bytes = make_bytes();
    struct feed f = {.bytes = bytes, .len = LEN, .piece = LEN};
    lum_source *s = source_of(&f);
    uint64_t done = 1;
    uint64_t total = 0;
    (void)state;
    lum_source_progress(s, &done, &total);
    assert_int_equal(done, 0);
    assert_int_equal(total, LEN);
    assert_true(lum_source_skip(s, 70));
    lum_source_progress(s, &done, &total);
    assert_int_equal(done, 70);
    lum_source_close(s);
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_sizes_come_in_order),
        cmocka_unit_test(what_is_not_taken_stays),
        cmocka_unit_test(memory_is_read_in_place),
        cmocka_unit_test(a_skip_may_go_beyond_what_fits),
        cmocka_unit_test(a_failure_is_kept_behind_what_was_read),
        cmocka_unit_test(a_function_that_gives_too_much_has_failed),
        cmocka_unit_test(more_than_a_window_is_not_held),
        cmocka_unit_test(progress_knows_the_total_that_the_caller_gave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
