/** @file
 * A pool of threads that do jobs, in the order in which they were given, beside
 * the thread that gives them, which helps while they are behind. Internal.
 *
 * The jobs are the user's, in a ring: the k-th has place k % places. One thread
 * uses a pool. In a child of fork(), which has none of its threads, that one
 * does all that is given. */
#ifndef LUM_BASE_THREAD_POOL_H
#define LUM_BASE_THREAD_POOL_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>

/** What a pool does. */
typedef struct lum_thread_pool_work {
    size_t places;    /**< of the ring */
    unsigned threads; /**< most, beside the user's; they start when there is
                         work for them */
    unsigned waking;  /**< how many jobs have to wait before another thread is
                           woken or started: waking one may take as long as a
                           few jobs */
    void *context;
    /** Make what a thread works with. NULL without memory: the others do its
     * work, and the user. */
    void *(*begin)(void *context);
    void (*work)(void *context, size_t place, void *tools);
    void (*end)(void *tools); /**< NULL is allowed */
} lum_thread_pool_work;

/** A pool. */
typedef struct lum_thread_pool lum_thread_pool;

/** @return NULL without memory. */
LUM_MUST_CHECK lum_thread_pool *lum_thread_pool_new(
    const lum_thread_pool_work *work);

/** Have more threads. */
void lum_thread_pool_set_threads(lum_thread_pool *pool, unsigned threads);

/** End the threads; jobs that nobody has begun are dropped. NULL is allowed. */
void lum_thread_pool_free(lum_thread_pool *pool);

/** The place of the next job, once the one that was there is done. */
size_t lum_thread_pool_next(lum_thread_pool *pool);

/** Have the job at the next place done. Without threads it is done now. */
void lum_thread_pool_give(lum_thread_pool *pool);

/** Do a job that nobody has begun.
 * @return false: there is none. */
bool lum_thread_pool_help(lum_thread_pool *pool);

/** Whether the job at a place is done, after waiting for it if `waits`. */
bool lum_thread_pool_is_done(lum_thread_pool *pool, size_t place, bool waits);

/** Wait until all that was given is done. */
void lum_thread_pool_settle(lum_thread_pool *pool);

#endif
