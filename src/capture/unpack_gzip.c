/* gzip data, by zlib: also several members, and zeros behind the last. */
#define ZLIB_CONST /* what it reads is not changed */
#include "unpack.h"

#include <limits.h>
#include <stdlib.h>
#include <zlib.h>

/* zlib's own sum and header checks, and the largest window. */
#define GZIP_WINDOW_BITS (16 + 15)

struct state {
    z_stream z;
    bool is_open; /* a member is under way */
    uint64_t members;
};

static void *make(void)
{
    struct state *g = calloc(1, sizeof *g);
    if (g != NULL && inflateInit2(&g->z, GZIP_WINDOW_BITS) != Z_OK) {
        free(g);
        return NULL;
    }
    return g;
}

static unsigned limited(size_t bytes)
{
    return bytes < UINT_MAX ? (unsigned)bytes : UINT_MAX;
}

/* Zeros may follow a member, as on a tape. False: there is nothing but these.
 */
static bool skip_zeros(const struct state *g, lum_unpack_step *s)
{
    while (g->members != 0 && s->taken < s->in_len && s->in[s->taken] == 0) {
        s->taken++;
    }
    return s->taken < s->in_len;
}

static const char *why_not(const struct state *g, int result)
{
    return result == Z_MEM_ERROR ? "not enough memory"
           : g->members == 0 || g->z.total_out != 0
               ? "they are damaged: a check sum or a code is wrong"
               : "other data follows the gzip data";
}

static bool step(void *state, lum_unpack_step *s)
{
    struct state *g = state;
    if (!g->is_open) {
        s->is_between = !skip_zeros(g, s);
        if (s->is_between) {
            return true;
        }
        g->is_open = true;
        (void)inflateReset(&g->z); /* fails without a state alone */
    }
    const unsigned in_len = limited(s->in_len - s->taken);
    const unsigned room = limited(s->room);
    g->z.next_in = s->in + s->taken;
    g->z.avail_in = in_len;
    g->z.next_out = s->out;
    g->z.avail_out = room;
    const int result = inflate(&g->z, Z_NO_FLUSH);
    s->taken += in_len - g->z.avail_in;
    s->given = room - g->z.avail_out;
    s->is_between = result == Z_STREAM_END;
    g->is_open = !s->is_between;
    g->members += s->is_between;
    s->why = why_not(g, result);
    return s->is_between || result == Z_OK || result == Z_BUF_ERROR;
}

static void free_state(void *state)
{
    struct state *g = state;
    (void)inflateEnd(&g->z);
    free(g);
}

static const lum_unpacker unpacker = {"gzip", make, step, free_state};

const lum_unpacker *const lum_unpack_gzip = &unpacker;
