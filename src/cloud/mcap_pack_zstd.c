#define _POSIX_C_SOURCE 200809L
#include "mcap_pack.h"

#include "base/thread.h"

#include <pthread.h>
#include <stdlib.h>
#include <zstd.h>

/* Higher ones are several times slower, and measured points hardly get
 * smaller. */
#define LEVEL 1

const char *const lum_mcap_pack_name = "zstd";

struct lum_mcap_packer {
    const lum_crc32 *crc;
    ZSTD_CCtx *context; /* of the caller */
    pthread_t threads[LUM_MCAP_THREADS_MAX];
    unsigned thread_count;
    unsigned thread_max;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    lum_mcap_packing *jobs[LUM_MCAP_THREADS_MAX]; /* a ring */
    uint64_t given;
    uint64_t claimed;
    bool stops;
};

/* --- Compressing --- */

static void make(const lum_mcap_packer *packer, ZSTD_CCtx *context,
                 lum_mcap_packing *job)
{
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
        ZSTD_compressCCtx(context, to, room, chunk->at, chunk->len, LEVEL);
    out->failed = ZSTD_isError(n) != 0;
    out->len = out->failed ? 0 : n;
}

/* --- The threads --- */

/* The lock is held before and after. */
static void make_next(lum_mcap_packer *packer, ZSTD_CCtx *context)
{
    lum_mcap_packing *job =
        packer->jobs[packer->claimed++ % LUM_MCAP_THREADS_MAX];
    (void)pthread_mutex_unlock(&packer->lock);
    make(packer, context, job);
    (void)pthread_mutex_lock(&packer->lock);
    job->is_made = true;
    (void)pthread_cond_broadcast(&packer->changed);
}

static void work(lum_mcap_packer *packer, ZSTD_CCtx *context)
{
    (void)pthread_mutex_lock(&packer->lock);
    while (!packer->stops) {
        if (packer->claimed < packer->given) {
            make_next(packer, context);
        } else {
            (void)pthread_cond_wait(&packer->changed, &packer->lock);
        }
    }
    (void)pthread_mutex_unlock(&packer->lock);
}

/* Without memory the others do its work, and the caller, who waits for it. */
static void *run(void *argument)
{
    ZSTD_CCtx *context = ZSTD_createCCtx();
    if (context != NULL) {
        work(argument, context);
    }
    (void)ZSTD_freeCCtx(context);
    return NULL;
}

/* One more with each job. If the system has none, the caller does the work. */
static void start_another(lum_mcap_packer *packer)
{
    if (packer->thread_count == packer->thread_max) {
        return;
    }
    if (lum_thread_start(&packer->threads[packer->thread_count], run, packer) ==
        0) {
        packer->thread_count++;
    } else {
        packer->thread_max = packer->thread_count;
    }
}

/* --- For the caller --- */

lum_mcap_packer *lum_mcap_packer_new(const lum_crc32 *crc)
{
    lum_mcap_packer *packer = calloc(1, sizeof *packer);
    if (packer == NULL) {
        return NULL;
    }
    packer->crc = crc;
    packer->context = ZSTD_createCCtx();
    (void)pthread_mutex_init(&packer->lock, NULL);
    (void)pthread_cond_init(&packer->changed, NULL);
    if (packer->context == NULL) {
        lum_mcap_packer_free(packer);
        return NULL;
    }
    return packer;
}

void lum_mcap_packer_set_threads(lum_mcap_packer *packer, unsigned threads)
{
    packer->thread_max = threads;
}

void lum_mcap_packer_free(lum_mcap_packer *packer)
{
    if (packer == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&packer->lock);
    packer->stops = true;
    (void)pthread_cond_broadcast(&packer->changed);
    (void)pthread_mutex_unlock(&packer->lock);
    for (unsigned i = 0; i < packer->thread_count; i++) {
        (void)pthread_join(packer->threads[i], NULL);
    }
    (void)pthread_cond_destroy(&packer->changed);
    (void)pthread_mutex_destroy(&packer->lock);
    (void)ZSTD_freeCCtx(packer->context);
    free(packer);
}

void lum_mcap_packer_give(lum_mcap_packer *packer, lum_mcap_packing *job)
{
    start_another(packer);
    (void)pthread_mutex_lock(&packer->lock);
    job->is_made = false;
    packer->jobs[packer->given++ % LUM_MCAP_THREADS_MAX] = job;
    (void)pthread_cond_broadcast(&packer->changed);
    if (packer->thread_count == 0) {
        make_next(packer, packer->context);
    }
    (void)pthread_mutex_unlock(&packer->lock);
}

/* Who waits works. */
bool lum_mcap_packer_is_done(lum_mcap_packer *packer,
                             const lum_mcap_packing *job, bool waits)
{
    (void)pthread_mutex_lock(&packer->lock);
    while (waits && !job->is_made) {
        if (packer->claimed < packer->given) {
            make_next(packer, packer->context);
        } else {
            (void)pthread_cond_wait(&packer->changed, &packer->lock);
        }
    }
    const bool is_done = job->is_made;
    (void)pthread_mutex_unlock(&packer->lock);
    return is_done;
}
