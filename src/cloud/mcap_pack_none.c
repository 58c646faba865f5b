/* A build without a libzstd that compresses. */
#include "mcap_pack.h"

const char *const lum_mcap_pack_name = NULL;

lum_mcap_packer *lum_mcap_packer_new(void)
{
    return NULL;
}

void lum_mcap_packer_free(lum_mcap_packer *packer)
{
    (void)packer;
}

void lum_mcap_pack(lum_mcap_packer *packer, const lum_bytes *chunk,
                   lum_bytes *out)
{
    (void)packer;
    (void)chunk;
    out->failed = true;
}
