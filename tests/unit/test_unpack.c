#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/unpack.h"

#include <stdlib.h>
#include <string.h>

/* "a capture" */
static const uint8_t gzip[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00,
                               0x02, 0x03, 0x4b, 0x54, 0x48, 0x4e, 0x2c, 0x28,
                               0x29, 0x2d, 0x4a, 0x05, 0x00, 0x84, 0x9a, 0xf5,
                               0x42, 0x09, 0x00, 0x00, 0x00};
static const uint8_t zstd[] = {0x28, 0xb5, 0x2f, 0xfd, 0x04, 0x58, 0x49, 0x00,
                               0x00, 0x61, 0x20, 0x63, 0x61, 0x70, 0x74, 0x75,
                               0x72, 0x65, 0xe0, 0x04, 0xec, 0xdf};

static const uint8_t lz4[] = {0x04, 0x22, 0x4d, 0x18, 0x64, 0x40, 0xa7,
                              0x09, 0x00, 0x00, 0x80, 0x61, 0x20, 0x63,
                              0x61, 0x70, 0x74, 0x75, 0x72, 0x65, 0x00,
                              0x00, 0x00, 0x00, 0x9a, 0xf0, 0x03, 0x10};
static const uint8_t bz2[] = {
    0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0xad, 0x32,
    0x3a, 0xb6, 0x00, 0x00, 0x00, 0x91, 0x80, 0x40, 0x00, 0x2a, 0x00, 0x56,
    0x00, 0x20, 0x00, 0x22, 0x1a, 0x7a, 0x86, 0x10, 0xc0, 0x84, 0x07, 0x6b,
    0xf7, 0x05, 0xdc, 0x91, 0x4e, 0x14, 0x24, 0x2b, 0x4c, 0x8e, 0xad, 0x80};

enum {
    TEXT = 9,
    KINDS = 4
};

/* Of one compression; none in a build without its library. */
struct kind {
    const lum_unpacker *unpacker;
    const uint8_t *bytes;
    size_t len;
    const char *name;
};

static size_t kinds_of(struct kind *out)
{
    const struct kind all[KINDS] = {
        {lum_unpack_gzip, gzip, sizeof gzip, "gzip"},
        {lum_unpack_zstd, zstd, sizeof zstd, "zstd"},
        {lum_unpack_lz4, lz4, sizeof lz4, "lz4"},
        {lum_unpack_bz2, bz2, sizeof bz2, "bzip2"}};
    size_t count = 0;
    for (size_t i = 0; i < KINDS; i++) {
        if (all[i].unpacker != NULL) {
            out[count++] = all[i];
        }
    }
    return count;
}

static lum_source *unpacked(const uint8_t *bytes, size_t len)
{
    lum_error error;
    lum_source *s = lum_source_from_memory("x", bytes, len);
    assert_non_null(s);
    assert_int_equal(lum_unpack(&s, &error), 0);
    return s;
}

static void expect_text(const char *text, const char *part)
{
    if (strstr(text, part) == NULL) {
        fail_msg("\"%s\" is not in \"%s\"", part, text);
    }
}

static void what_is_compressed_is_unpacked(void **state)
{
    struct kind kinds[KINDS];
    (void)state;
    for (size_t i = 0; i < kinds_of(kinds); i++) {
        uint64_t done = 0;
        uint64_t total = 0;
        lum_source *s = unpacked(kinds[i].bytes, kinds[i].len);
        assert_non_null(s->packed);
        assert_true(lum_source_has(s, TEXT));
        assert_memory_equal(s->at, "a capture", TEXT);
        assert_false(lum_source_has(s, TEXT + 1));
        assert_false(s->has_failed);
        lum_source_progress(s, &done, &total);
        assert_int_equal(done, kinds[i].len);
        assert_int_equal(total, kinds[i].len);
        lum_source_close(s);
    }
}

static void what_is_not_compressed_stays(void **state)
{
    (void)state;
    for (size_t len = 0; len < 4; len++) {
        lum_source *s = unpacked((const uint8_t *)"\x1f\x8c\x28\xb5", len);
        assert_null(s->packed);
        assert_int_equal(s->left, len);
        lum_source_close(s);
    }
}

static void parts_behind_one_another_are_one(void **state)
{
    struct kind kinds[KINDS];
    (void)state;
    for (size_t i = 0; i < kinds_of(kinds); i++) {
        uint8_t *bytes = malloc(3u * kinds[i].len);
        assert_non_null(bytes);
        for (size_t k = 0; k < 3; k++) {
            memcpy(bytes + k * kinds[i].len, kinds[i].bytes, kinds[i].len);
        }
        lum_source *s = unpacked(bytes, 3u * kinds[i].len);
        assert_true(lum_source_has(s, 3u * TEXT));
        assert_memory_equal(s->at, "a capturea capturea capture", 3u * TEXT);
        assert_false(lum_source_has(s, 3u * TEXT + 1u));
        assert_false(s->has_failed);
        lum_source_close(s);
        free(bytes);
    }
}

/* The readable part is given, and the byte where it broke. */
static void every_truncation_is_told(void **state)
{
    struct kind kinds[KINDS];
    (void)state;
    for (size_t i = 0; i < kinds_of(kinds); i++) {
        for (size_t len = 4; len < kinds[i].len; len++) {
            uint8_t *exact = malloc(len);
            assert_non_null(exact);
            memcpy(exact, kinds[i].bytes, len);
            lum_source *s = unpacked(exact, len);
            assert_false(lum_source_has(s, TEXT + 1));
            assert_true(s->left <= TEXT);
            assert_memory_equal(s->at, "a capture", s->left);
            assert_true(s->has_failed);
            expect_text(s->error.text, kinds[i].name);
            expect_text(s->error.text, "cut short at byte");
            lum_source_close(s);
            free(exact);
        }
    }
}

/* What nothing depends on: time, system and window; which bits of a stream's
 * end are not used. */
static bool is_idle(const struct kind *k, size_t at)
{
    if (k->bytes == gzip) {
        return at < 10u;
    }
    return (k->bytes == zstd && at == 5u) ||
           (k->bytes == bz2 && at == k->len - 1u);
}

/* All have a sum of what they hold. */
static void every_damage_is_told(void **state)
{
    struct kind kinds[KINDS];
    (void)state;
    for (size_t i = 0; i < kinds_of(kinds); i++) {
        uint8_t *bytes = malloc(kinds[i].len);
        assert_non_null(bytes);
        for (size_t at = 4; at < kinds[i].len; at++) {
            if (is_idle(&kinds[i], at)) {
                continue;
            }
            memcpy(bytes, kinds[i].bytes, kinds[i].len);
            bytes[at] ^= 0x55u;
            lum_source *s = unpacked(bytes, kinds[i].len);
            (void)lum_source_has(s, 1000);
            if (!s->has_failed) {
                fail_msg("%s: byte %zu", kinds[i].name, at);
            }
            lum_source_close(s);
        }
        free(bytes);
    }
}

static void behind_gzip_zeros_may_follow_and_nothing_else(void **state)
{
    uint8_t bytes[sizeof gzip + 100] = {0};
    (void)state;
    if (lum_unpack_gzip == NULL) {
        skip();
    }
    memcpy(bytes, gzip, sizeof gzip);
    lum_source *s = unpacked(bytes, sizeof bytes);
    assert_false(lum_source_has(s, TEXT + 1));
    assert_int_equal(s->left, TEXT);
    assert_false(s->has_failed);
    lum_source_close(s);
    bytes[sizeof bytes - 5u] = 'x';
    s = unpacked(bytes, sizeof bytes);
    assert_false(lum_source_has(s, TEXT + 1));
    assert_int_equal(s->left, TEXT);
    assert_true(s->has_failed);
    expect_text(s->error.text, "other data follows the gzip data");
    assert_null(strstr(s->error.text, "damaged"));
    lum_source_close(s);
}

/* A failure of its source is its own failure. */
static int64_t break_off(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    size_t *given = context;
    (void)room;
    if (*given != 0) {
        return lum_error_set(error, "the store is gone");
    }
    *given = 12;
    memcpy(buffer, gzip, *given);
    return (int64_t)*given;
}

static void a_failure_beneath_is_told(void **state)
{
    size_t given = 0;
    lum_error error;
    (void)state;
    if (lum_unpack_gzip == NULL) {
        skip();
    }
    lum_source *s = lum_source_from_functions(
        "x",
        &(lum_source_functions){.struct_size = sizeof(lum_source_functions),
                                .read = break_off,
                                .context = &given},
        NULL);
    assert_non_null(s);
    assert_int_equal(lum_unpack(&s, &error), 0);
    assert_false(lum_source_has(s, TEXT));
    assert_true(s->has_failed);
    assert_string_equal(s->error.text, "the store is gone");
    lum_source_close(s);
}

static void a_build_without_a_library_says_what_to_do(void **state)
{
    static const struct {
        const uint8_t *bytes;
        size_t len;
        const char *says;
    } packed[] = {{gzip, sizeof gzip, "no zlib: use gzip -dc"},
                  {zstd, sizeof zstd, "no libzstd: use zstd -dc"},
                  {lz4, sizeof lz4, "no liblz4: use lz4 -dc"},
                  {bz2, sizeof bz2, "no libbz2: use bzip2 -dc"}};
    char hint[LUM_UNPACK_HINT_BYTES];
    (void)state;
    for (size_t i = 0; i < KINDS; i++) {
        lum_source *s =
            lum_source_from_memory("x", packed[i].bytes, packed[i].len);
        assert_non_null(s);
        expect_text(lum_unpack_hint(s, hint), packed[i].says);
        lum_source_close(s);
    }
}

static void a_compression_has_a_name_and_a_library(void **state)
{
    static const char *const names[] = {"gzip", "zstd", "lz4", "bz2"};
    const lum_unpacker *const unpackers[] = {lum_unpack_gzip, lum_unpack_zstd,
                                             lum_unpack_lz4, lum_unpack_bz2};
    const char *library = NULL;
    (void)state;
    for (size_t i = 0; i < KINDS; i++) {
        assert_ptr_equal(lum_unpack_named(names[i], &library), unpackers[i]);
        assert_non_null(library);
    }
    assert_null(lum_unpack_named("xz", &library));
    assert_null(library);
}

static void what_was_compressed_twice_is_told_so(void **state)
{
    /* the text above, compressed twice */
    static const uint8_t twice[] = {
        0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0x93, 0xef,
        0xe6, 0x60, 0x00, 0x01, 0x26, 0x66, 0xef, 0x10, 0x0f, 0x3f, 0x1d, 0x0d,
        0x4d, 0x5d, 0x2f, 0x56, 0x86, 0x96, 0x59, 0x5f, 0x9d, 0x38, 0x81, 0x82,
        0x00, 0xe4, 0x57, 0x8e, 0x95, 0x1d, 0x00, 0x00, 0x00};
    char hint[LUM_UNPACK_HINT_BYTES];
    (void)state;
    if (lum_unpack_gzip == NULL) {
        skip();
    }
    lum_source *s = unpacked(twice, sizeof twice);
    assert_true(lum_source_has(s, sizeof gzip));
    assert_memory_equal(s->at, gzip, sizeof gzip);
    expect_text(lum_unpack_hint(s, hint), "compressed twice");
    expect_text(lum_unpack_hint(s, hint), "gzip -dc");
    lum_source_close(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_compressed_is_unpacked),
        cmocka_unit_test(what_is_not_compressed_stays),
        cmocka_unit_test(parts_behind_one_another_are_one),
        cmocka_unit_test(every_truncation_is_told),
        cmocka_unit_test(every_damage_is_told),
        cmocka_unit_test(behind_gzip_zeros_may_follow_and_nothing_else),
        cmocka_unit_test(a_failure_beneath_is_told),
        cmocka_unit_test(a_build_without_a_library_says_what_to_do),
        cmocka_unit_test(a_compression_has_a_name_and_a_library),
        cmocka_unit_test(what_was_compressed_twice_is_told_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
