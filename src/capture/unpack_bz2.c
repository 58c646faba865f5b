/* bzip2 data, by libbz2: also several streams. */
#include "unpack.h"

#include <bzlib.h>
#include <limits.h>
#include <stdlib.h>

struct state {
    bz_stream stream;
    bool is_open; /* a stream is under way */
};

static void *make(void)
{
    return calloc(1, sizeof(struct state));
}

static void end_stream(struct state *b)
{
    if (b->is_open) {
        (void)BZ2_bzDecompressEnd(&b->stream);
        b->is_open = false;
    }
}

static bool begin_stream(struct state *b)
{
    b->stream = (bz_stream){.bzalloc = NULL};
    b->is_open = BZ2_bzDecompressInit(&b->stream, 0, 0) == BZ_OK;
    return b->is_open;
}

static unsigned limited(size_t len)
{
    return len < UINT_MAX ? (unsigned)len : UINT_MAX;
}

static bool step(void *state, lum_unpack_step *s)
{
    struct state *b = state;
    if (!b->is_open && !begin_stream(b)) {
        s->why = "not enough memory";
        return false;
    }
    bz_stream *z = &b->stream;
    const unsigned in_len = limited(s->in_len);
    const unsigned room = limited(s->room);
    z->next_in = (char *)s->in; /* which it only reads */
    z->avail_in = in_len;
    z->next_out = (char *)s->out;
    z->avail_out = room;
    const int result = BZ2_bzDecompress(z);
    s->taken = in_len - z->avail_in;
    s->given = room - z->avail_out;
    s->is_between = result == BZ_STREAM_END;
    if (s->is_between) {
        end_stream(b);
    } else if (result != BZ_OK) {
        s->why = result == BZ_MEM_ERROR ? "not enough memory"
                                        : "they are damaged: a check sum or a "
                                          "code is wrong";
        return false;
    }
    return true;
}

static void free_state(void *state)
{
    end_stream(state);
    free(state);
}

static const lum_unpacker unpacker = {"bzip2", make, step, free_state};

const lum_unpacker *const lum_unpack_bz2 = &unpacker;
