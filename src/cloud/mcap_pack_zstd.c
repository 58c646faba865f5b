/* Compression of the chunks of an MCAP file by libzstd, in threads. */
#include "mcap_pack.h"

#include "base/thread_pool.h"

#include <stdlib.h>
#include <zstd.h>

/* Higher ones are several times slower, and measured points hardly get
 * smaller. */
#define LEVEL 1

const char *const lum_mcap_pack_name = "zstd";

struct lum_mcap_packer {
    const lum_crc32 *crc;
    lum_thread_pool *pool;
    lum_mcap_packing *jobs[LUM_MCAP_THREADS_MAX];
};

static void *begin(void *context)
{
    (void)context;
    return ZSTD_createCCtx();
}

static void end(void *tools)
{
    (void)ZSTD_freeCCtx(tools);
}

static void compress(void *context, size_t place, void *tools)
{
    const lum_mcap_packer *packer = context;
    lum_mcap_packing *job = packer->jobs[place];
    const lum_bytes *chunk = job->chunk;
    lum_bytes *out = &job->packed;
    job->crc = lum_crc32_add(packer->crc, 0, chunk->at, chunk->len);
    out->len = 0;
    const size_t room = ZSTD_compressBound(chunk->len);
    unsigned char *to = lum_bytes_extend(out, room);
    if (to == NULL) {
        return;
    }
    const size_t n =
        ZSTD_compressCCtx(tools, to, room, chunk->at, chunk->len, LEVEL);
    out->failed = ZSTD_isError(n) != 0;
    out->len = out->failed ? 0 : n;
}

lum_mcap_packer *lum_mcap_packer_new(const lum_crc32 *crc)
{
    lum_mcap_packer *packer = calloc(1, sizeof *packer);
    if (packer == NULL) {
        return NULL;
    }
    packer->crc = crc;
    packer->pool = lum_thread_pool_new(
        &(lum_thread_pool_work){.places = LUM_MCAP_THREADS_MAX,
                                .waking = 1,
                                .context = packer,
                                .begin = begin,
                                .work = compress,
                                .end = end});
    if (packer->pool == NULL) {
        free(packer);
        return NULL;
    }
    return packer;
}

void lum_mcap_packer_set_threads(lum_mcap_packer *packer, unsigned threads)
{
    lum_thread_pool_set_threads(packer->pool, threads);
}

void lum_mcap_packer_free(lum_mcap_packer *packer)
{
    if (packer != NULL) {
        lum_thread_pool_free(packer->pool);
        free(packer);
    }
}

void lum_mcap_packer_give(lum_mcap_packer *packer, lum_mcap_packing *job)
{
    job->place = lum_thread_pool_next(packer->pool);
    packer->jobs[job->place] = job;
    lum_thread_pool_give(packer->pool);
}

bool lum_mcap_packer_is_done(lum_mcap_packer *packer,
                             const lum_mcap_packing *job, bool waits)
{
    return lum_thread_pool_is_done(packer->pool, job->place, waits);
}
