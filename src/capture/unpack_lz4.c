/* lz4 data, by liblz4: also several frames. */
#include "unpack.h"

#include <lz4frame.h>

static void *make(void)
{
    LZ4F_dctx *context = NULL;
    return LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))
               ? NULL
               : context;
}

static bool step(void *state, lum_unpack_step *s)
{
    size_t given = s->room;
    size_t taken = s->in_len;
    const size_t result =
        LZ4F_decompress(state, s->out, &given, s->in, &taken, NULL);
    if (LZ4F_isError(result)) {
        s->why = LZ4F_getErrorName(result);
        return false;
    }
    s->taken = taken;
    s->given = given;
    s->is_between = result == 0;
    return true;
}

static void free_context(void *state)
{
    (void)LZ4F_freeDecompressionContext(state);
}

static const lum_unpacker unpacker = {"lz4", make, step, free_context};

const lum_unpacker *const lum_unpack_lz4 = &unpacker;
