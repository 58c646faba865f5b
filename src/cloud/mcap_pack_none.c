/* A build without a libzstd that compresses. */
#include "mcap_pack.h"

const char *const lum_mcap_pack_name = NULL;

lum_mcap_packer *lum_mcap_packer_new(const lum_crc32 *crc)
{
    (void)crc;
    return NULL;
}

void lum_mcap_packer_set_threads(lum_mcap_packer *packer, unsigned threads)
{
    (void)packer;
    (void)threads;
}

void lum_mcap_packer_free(lum_mcap_packer *packer)
{
    (void)packer;
}

void lum_mcap_packer_give(lum_mcap_packer *packer, lum_mcap_packing *job)
{
    (void)packer;
    job->packed.failed = true;
}

bool lum_mcap_packer_is_done(lum_mcap_packer *packer,
                             const lum_mcap_packing *job, bool waits)
{
    (void)packer;
    (void)job;
    (void)waits;
    return true;
}
