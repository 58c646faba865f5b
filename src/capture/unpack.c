#include "unpack.h"

#include <string.h>

enum {
    MAGIC_BYTES = 4,
    TAR_MARK_AT = 257
};

static bool begins_with(lum_source *source, const uint8_t *magic, size_t len)
{
    return lum_source_has(source, len) && memcmp(source->at, magic, len) == 0;
}

static bool is_gzip(lum_source *source)
{
    static const uint8_t magic[] = {0x1f, 0x8b};
    return begins_with(source, magic, sizeof magic);
}

/* A frame, or one to be skipped, which some programs write first. */
static bool is_zstd(lum_source *source)
{
    static const uint8_t magic[] = {0x28, 0xb5, 0x2f, 0xfd};
    static const uint8_t skipped[] = {0x2a, 0x4d, 0x18};
    return begins_with(source, magic, sizeof magic) ||
           (lum_source_has(source, MAGIC_BYTES) &&
            (source->at[0] & 0xf0u) == 0x50u &&
            memcmp(source->at + 1, skipped, sizeof skipped) == 0);
}

/* NULL: it is not compressed, or not in a way that this build reads. */
static lum_unpacker *unpacker_of(lum_source *source)
{
    if (is_gzip(source)) {
        return lum_unpack_gzip;
    }
    return is_zstd(source) ? lum_unpack_zstd : NULL;
}

int lum_unpack(lum_source **source, lum_error *error)
{
    lum_source *packed = *source;
    lum_source_functions functions;
    lum_unpacker *const unpacker = unpacker_of(packed);
    if (unpacker == NULL) {
        return 0;
    }
    lum_source *s = NULL;
    if (unpacker(packed, &functions) == 0) {
        s = lum_source_from_functions(packed->name, &functions, NULL);
        if (s == NULL) {
            functions.close(functions.context);
        }
    }
    if (s == NULL) {
        return lum_error_set(error, "%s: not enough memory to unpack it",
                             packed->name);
    }
    s->packed = packed;
    s->go_on = packed->go_on;
    *source = s;
    return 0;
}

/* The first member's header has its name and, behind it, the archive's mark. */
static bool is_tar(lum_source *source)
{
    static const char mark[] = {'u', 's', 't', 'a', 'r'};
    return lum_source_has(source, TAR_MARK_AT + sizeof mark) &&
           memcmp(source->at + TAR_MARK_AT, mark, sizeof mark) == 0;
}

const char *lum_unpack_hint(lum_source *source)
{
    static const struct {
        uint8_t magic[MAGIC_BYTES];
        uint8_t len;
        const char *text;
    } known[] = {
        {{0xfd, '7', 'z', 'X'}, 4, "; it is compressed: use xz -dc"},
        {{'B', 'Z', 'h', 0}, 3, "; it is compressed: use bzip2 -dc"},
        {{0x04, 0x22, 0x4d, 0x18}, 4, "; it is compressed: use lz4 -dc"},
        {{'P', 'K', 3, 4}, 4, "; it is a zip archive: use unzip"},
        {{0x5d, 0, 0, 0}, 3, "; it is compressed: use xz -dc --format=lzma"},
        {{'7', 'z', 0xbc, 0xaf}, 4, "; it is a 7z archive: use 7z e"},
    };
    if (is_tar(source)) {
        return "; it is an archive of files: unpack it by tar -xf";
    }
    if (source->packed != NULL && (is_gzip(source) || is_zstd(source))) {
        return "; it is compressed twice: unpack it once with gzip -dc or zstd "
               "-dc";
    }
    if (is_gzip(source)) {
        return "; it is compressed, and this build has no zlib: use gzip -dc";
    }
    if (is_zstd(source)) {
        return "; it is compressed, and this build has no libzstd: use zstd "
               "-dc";
    }
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (begins_with(source, known[i].magic, known[i].len)) {
            return known[i].text;
        }
    }
    return "";
}
