#include "unpack.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAGIC_BYTES = 4,
    TAR_MARK_AT = 257
};

/* How compressed data begins: all of the first byte counts, or its upper
 * half. */
struct compression {
    const char *name;
    const char *magic;
    uint8_t first_mask;
    const lum_unpacker *const *unpacker;
    const char *library;
    const char *program; /* its -dc unpacks */
};

static const struct compression compressions[] = {
    {"gzip", "\x1f\x8b", 0xff, &lum_unpack_gzip, "zlib", "gzip"},
    {"zstd", "\x28\xb5\x2f\xfd", 0xff, &lum_unpack_zstd, "libzstd", "zstd"},
    /* A frame to be skipped, which some programs write first. */
    {"zstd", "\x50\x2a\x4d\x18", 0xf0, &lum_unpack_zstd, "libzstd", "zstd"},
    {"lz4", "\x04\x22\x4d\x18", 0xff, &lum_unpack_lz4, "liblz4", "lz4"},
    {"bz2", "BZh", 0xff, &lum_unpack_bz2, "libbz2", "bzip2"},
};

#define COMPRESSIONS (sizeof compressions / sizeof compressions[0])

static bool begins_with(lum_source *source, const uint8_t *magic, size_t len)
{
    return lum_source_has(source, len) && memcmp(source->at, magic, len) == 0;
}

static bool is_by(lum_source *source, const struct compression *c)
{
    const size_t len = strlen(c->magic);
    return lum_source_has(source, len) &&
           (source->at[0] & c->first_mask) == (uint8_t)c->magic[0] &&
           memcmp(source->at + 1, c->magic + 1, len - 1u) == 0;
}

/* NULL: it is not compressed in a way that is known. */
static const struct compression *find(lum_source *source)
{
    size_t i = 0;
    while (i < COMPRESSIONS && !is_by(source, &compressions[i])) {
        i++;
    }
    return i < COMPRESSIONS ? &compressions[i] : NULL;
}

const lum_unpacker *lum_unpack_named(const char *name, const char **library)
{
    for (size_t i = 0; i < COMPRESSIONS; i++) {
        if (strcmp(compressions[i].name, name) == 0) {
            *library = compressions[i].library;
            return *compressions[i].unpacker;
        }
    }
    *library = NULL;
    return NULL;
}

int lum_unpack(lum_source **source, lum_error *error)
{
    lum_source *packed = *source;
    lum_source_functions functions;
    const struct compression *c = find(packed);
    if (c == NULL || *c->unpacker == NULL) {
        return 0;
    }
    lum_source *s = NULL;
    if (lum_unpack_by(*c->unpacker, packed, &functions) == 0) {
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

/* What is not unpacked in any build. */
static const char *hint_of_others(lum_source *source)
{
    static const struct {
        uint8_t magic[MAGIC_BYTES];
        uint8_t len;
        const char *text;
    } known[] = {
        {{0xfd, '7', 'z', 'X'}, 4, "; it is compressed: use xz -dc"},
        {{'P', 'K', 3, 4}, 4, "; it is a zip archive: use unzip"},
        {{0x5d, 0, 0, 0}, 3, "; it is compressed: use xz -dc --format=lzma"},
        {{'7', 'z', 0xbc, 0xaf}, 4, "; it is a 7z archive: use 7z e"},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (begins_with(source, known[i].magic, known[i].len)) {
            return known[i].text;
        }
    }
    return "";
}

const char *lum_unpack_hint(lum_source *source, char out[LUM_UNPACK_HINT_BYTES])
{
    const struct compression *c = find(source);
    const char *text = hint_of_others(source);
    if (is_tar(source)) {
        text = "; it is an archive of files: unpack it by tar -xf";
    } else if (c != NULL && source->packed != NULL) {
        text = "; it is compressed twice: unpack it once with gzip -dc, zstd "
               "-dc, lz4 -dc or bzip2 -dc";
    }
    (void)snprintf(out, LUM_UNPACK_HINT_BYTES, "%s", text);
    if (text[0] == '\0' && c != NULL) {
        (void)snprintf(out, LUM_UNPACK_HINT_BYTES,
                       "; it is compressed, and this build has no %s: use %s "
                       "-dc",
                       c->library, c->program);
    }
    return out;
}

/* --- By a library that reads from memory to memory --- */

struct unpacker {
    const lum_unpacker *unpacker;
    void *state;
    lum_source *packed;
    bool is_between; /* no frame is under way */
    bool has_failed; /* what came before the failure is given first */
    lum_error failure;
};

static int64_t end(const struct unpacker *u, lum_error *error)
{
    if (u->packed->has_failed) {
        *error = u->packed->error;
        return -1;
    }
    if (u->is_between) {
        return 0;
    }
    return lum_error_set(
        error, "the %s data are cut short at byte %llu of the compressed file",
        u->unpacker->name, (unsigned long long)lum_source_offset(u->packed));
}

static void fail(struct unpacker *u, const char *why)
{
    u->has_failed = true;
    (void)lum_error_set(&u->failure,
                        "the %s data cannot be unpacked at byte %llu of the "
                        "compressed file: %s",
                        u->unpacker->name,
                        (unsigned long long)lum_source_offset(u->packed), why);
}

/* Returns 1 if there may be more. */
static int64_t step(struct unpacker *u, lum_unpack_step *s, lum_error *error)
{
    if (u->has_failed) {
        return lum_error_set(error, "%s", u->failure.text);
    }
    const bool has_input = lum_source_has(u->packed, 1);
    if (!has_input && u->is_between) {
        return end(u, error);
    }
    s->in = u->packed->at;
    s->in_len = u->packed->left;
    s->taken = 0;
    const bool is_good = u->unpacker->step(u->state, s);
    lum_source_take(u->packed, s->taken);
    if (!is_good) {
        fail(u, s->why);
        return 1;
    }
    u->is_between = s->is_between;
    return has_input || s->given != 0 || u->is_between ? 1 : end(u, error);
}

static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    struct unpacker *u = context;
    lum_unpack_step s = {
        .out = buffer, .room = room, .why = "they are damaged"};
    int64_t result = 1;
    while (result > 0 && s.given == 0) {
        result = step(u, &s, error);
    }
    return s.given != 0 ? (int64_t)s.given : result;
}

static void close_unpacker(void *context)
{
    struct unpacker *u = context;
    u->unpacker->free(u->state);
    free(u);
}

int lum_unpack_by(const lum_unpacker *unpacker, lum_source *packed,
                  lum_source_functions *out)
{
    struct unpacker *u = calloc(1, sizeof *u);
    void *state = u != NULL ? unpacker->make() : NULL;
    if (state == NULL) {
        free(u);
        return -1;
    }
    *u = (struct unpacker){.unpacker = unpacker,
                           .state = state,
                           .packed = packed,
                           .is_between = true};
    *out = (lum_source_functions){.struct_size = sizeof *out,
                                  .read = read_some,
                                  .close = close_unpacker,
                                  .context = u};
    return 0;
}
