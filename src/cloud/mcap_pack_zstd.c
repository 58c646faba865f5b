#include "mcap_pack.h"

#include <zstd.h>

/* Higher ones are several times slower, and measured points hardly get
 * smaller. */
#define LEVEL 1

const char *const lum_mcap_pack_name = "zstd";

static ZSTD_CCtx *context_of(lum_mcap_packer *packer)
{
    return (ZSTD_CCtx *)packer;
}

lum_mcap_packer *lum_mcap_packer_new(void)
{
    return (lum_mcap_packer *)ZSTD_createCCtx();
}

void lum_mcap_packer_free(lum_mcap_packer *packer)
{
    (void)ZSTD_freeCCtx(context_of(packer));
}

void lum_mcap_pack(lum_mcap_packer *packer, const lum_bytes *chunk,
                   lum_bytes *out)
{
    out->len = 0;
    const size_t room = ZSTD_compressBound(chunk->len);
    unsigned char *to = lum_bytes_extend(out, room);
    if (to == NULL) {
        return;
    }
    const size_t n = ZSTD_compressCCtx(context_of(packer), to, room, chunk->at,
                                       chunk->len, LEVEL);
    out->failed = ZSTD_isError(n) != 0;
    out->len = out->failed ? 0 : n;
}
