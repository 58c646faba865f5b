#include "unpack.h"

#include <stdlib.h>
#include <zstd.h>

struct unpacker {
    ZSTD_DStream *stream;
    lum_source *packed;
    bool in_frame;
};

static int64_t end(const struct unpacker *u, lum_error *error)
{
    if (u->packed->has_failed) {
        *error = u->packed->error;
        return -1;
    }
    if (!u->in_frame) {
        return 0;
    }
    return lum_error_set(
        error,
        "the zstd data are cut short at byte %llu of the compressed file",
        (unsigned long long)lum_source_offset(u->packed));
}

/* Returns 1 if there may be more. */
static int64_t step(struct unpacker *u, ZSTD_outBuffer *out, lum_error *error)
{
    const bool has_input = lum_source_has(u->packed, 1);
    if (!has_input && !u->in_frame) {
        return end(u, error);
    }
    ZSTD_inBuffer in = {u->packed->at, u->packed->left, 0};
    const size_t result = ZSTD_decompressStream(u->stream, out, &in);
    lum_source_take(u->packed, in.pos);
    if (ZSTD_isError(result)) {
        return lum_error_set(error,
                             "the zstd data are damaged at byte %llu of the "
                             "compressed file (%s)",
                             (unsigned long long)lum_source_offset(u->packed),
                             ZSTD_getErrorName(result));
    }
    u->in_frame = result != 0;
    return has_input || out->pos != 0 || !u->in_frame ? 1 : end(u, error);
}

static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    struct unpacker *u = context;
    ZSTD_outBuffer out = {buffer, room, 0};
    int64_t result = 1;
    while (result > 0 && out.pos == 0) {
        result = step(u, &out, error);
    }
    return out.pos != 0 ? (int64_t)out.pos : result;
}

static void close_unpacker(void *context)
{
    struct unpacker *u = context;
    (void)ZSTD_freeDStream(u->stream);
    free(u);
}

static int unpack(lum_source *packed, lum_source_functions *out)
{
    struct unpacker *u = calloc(1, sizeof *u);
    ZSTD_DStream *stream = ZSTD_createDStream();
    if (u == NULL || stream == NULL) {
        (void)ZSTD_freeDStream(stream);
        free(u);
        return -1;
    }
    u->stream = stream;
    u->packed = packed;
    *out = (lum_source_functions){.struct_size = sizeof *out,
                                  .read = read_some,
                                  .close = close_unpacker,
                                  .context = u};
    return 0;
}

lum_unpacker *const lum_unpack_zstd = unpack;
