/* zstd data, by libzstd: also several frames. */
#include "unpack.h"

#include <zstd.h>

static void *make(void)
{
    return ZSTD_createDStream();
}

static bool step(void *state, lum_unpack_step *s)
{
    ZSTD_inBuffer in = {s->in, s->in_len, 0};
    ZSTD_outBuffer out = {s->out, s->room, 0};
    const size_t result = ZSTD_decompressStream(state, &out, &in);
    s->taken = in.pos;
    s->given = out.pos;
    s->is_between = result == 0;
    if (ZSTD_isError(result)) {
        s->why = ZSTD_getErrorName(result);
        return false;
    }
    return true;
}

static void free_stream(void *state)
{
    (void)ZSTD_freeDStream(state);
}

static const lum_unpacker unpacker = {"zstd", make, step, free_stream};

const lum_unpacker *const lum_unpack_zstd = &unpacker;
