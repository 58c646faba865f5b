#define ZLIB_CONST /* what it reads is not changed */
#include "unpack.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* zlib's own sum and header checks, and the largest window. */
#define GZIP_WINDOW_BITS (16 + 15)

struct unpacker {
    z_stream z;
    lum_source *packed;
    bool in_member; /* has_begun and has not ended */
    uint64_t members;
};

static unsigned limited(size_t bytes)
{
    return bytes < UINT_MAX ? (unsigned)bytes : UINT_MAX;
}

static int64_t fail(const struct unpacker *u, const char *what,
                    lum_error *error)
{
    return lum_error_set(error, "%s at byte %llu of the compressed file", what,
                         (unsigned long long)lum_source_offset(u->packed));
}

/* The source's own failure, or what its end means. */
static int64_t end(const struct unpacker *u, lum_error *error)
{
    if (u->packed->has_failed) {
        *error = u->packed->error;
        return -1;
    }
    return u->in_member ? fail(u, "the gzip data are cut short", error) : 0;
}

/* Zeros may follow the last member, as on a tape. */
static void skip_zeros(const struct unpacker *u)
{
    while (u->members != 0 && lum_source_has(u->packed, 1) &&
           u->packed->at[0] == 0) {
        lum_source_take(u->packed, 1);
    }
}

static int inflate_some(struct unpacker *u)
{
    const unsigned in = limited(u->packed->left);
    u->z.next_in = u->packed->at;
    u->z.avail_in = in;
    const int result = inflate(&u->z, Z_NO_FLUSH);
    lum_source_take(u->packed, in - u->z.avail_in);
    return result;
}

/* Begins the next member, if there is one.
 * Returns 1; 0 at the end; -1 if it cannot. */
static int64_t begin_member(struct unpacker *u, lum_error *error)
{
    skip_zeros(u);
    if (!lum_source_has(u->packed, 1)) {
        return end(u, error);
    }
    if (u->members != 0 && inflateReset(&u->z) != Z_OK) {
        return fail(u, "zlib cannot go on", error);
    }
    u->in_member = true;
    return 1;
}

/* Returns whether there may be more. */
static int64_t step(struct unpacker *u, lum_error *error)
{
    if (!u->in_member) {
        const int64_t begun = begin_member(u, error);
        if (begun <= 0) {
            return begun;
        }
    }
    const bool has_input = lum_source_has(u->packed, 1);
    const unsigned room = u->z.avail_out;
    const int result = inflate_some(u);
    if (result == Z_STREAM_END) {
        u->in_member = false;
        u->members++;
        return 1;
    }
    if (result == Z_OK || result == Z_BUF_ERROR) {
        return has_input || u->z.avail_out < room ? 1 : end(u, error);
    }
    if (result == Z_MEM_ERROR) {
        return lum_error_set(error, "not enough memory to unpack it");
    }
    return fail(u,
                u->members == 0 || u->z.total_out != 0
                    ? "the gzip data are damaged"
                    : "other data follows the gzip data,",
                error);
}

static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    struct unpacker *u = context;
    const unsigned limit = limited(room);
    u->z.next_out = buffer;
    u->z.avail_out = limit;
    int64_t result = 1;
    while (result > 0 && u->z.avail_out == limit) {
        result = step(u, error);
    }
    return u->z.avail_out < limit ? (int64_t)(limit - u->z.avail_out) : result;
}

static void close_unpacker(void *context)
{
    struct unpacker *u = context;
    (void)inflateEnd(&u->z);
    free(u);
}

static int unpack(lum_source *packed, lum_source_functions *out)
{
    struct unpacker *u = calloc(1, sizeof *u);
    if (u == NULL || inflateInit2(&u->z, GZIP_WINDOW_BITS) != Z_OK) {
        free(u);
        return -1;
    }
    u->packed = packed;
    *out = (lum_source_functions){.struct_size = sizeof *out,
                                  .read = read_some,
                                  .close = close_unpacker,
                                  .context = u};
    return 0;
}

lum_unpacker *const lum_unpack_gzip = unpack;
