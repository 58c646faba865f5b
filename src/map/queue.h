/** @file
 * Batches of points on their way to the tables, by a thread or at once.
 * Internal to map. */
#ifndef LUM_MAP_QUEUE_H
#define LUM_MAP_QUEUE_H

#include "tiles.h"

#include <pthread.h>

#define LUM_MAP_BATCH   4096u /**< points of one */
#define LUM_MAP_BATCHES 8u    /**< of them */

/** Points of a batch. */
typedef struct lum_map_batch {
    uint64_t ids[LUM_MAP_BATCH];         /**< of the tile of each */
    lum_map_entry points[LUM_MAP_BATCH]; /**< each as a voxel with one point */
    size_t count;                        /**< how many */
} lum_map_batch;

/** What is on its way. */
typedef struct lum_map_queue {
    lum_map_batch *batches; /**< LUM_MAP_BATCHES; without a thread 1 */
    unsigned filling;       /**< which the caller fills */
    lum_map_tiles *tiles;   /**< where they go; the thread's, as long as
                                 batches are queued */
    bool has_thread;        /**< whether there is one */
    pthread_t thread;       /**< it */
    pthread_mutex_t lock;   /**< guards what follows */
    pthread_cond_t changed; /**< likewise */
    unsigned queued;        /**< batches, up to the one that is filled */
    bool stop;              /**< the thread is to end */
    int failure;            /**< errno of the first failure, or 0 */
    lum_error text;         /**< of that */
} lum_map_queue;

/** Begin. queue is all bytes 0.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_queue_begin(lum_map_queue *queue,
                                       lum_map_tiles *tiles, bool has_thread);

/** The batch that is to be filled. */
lum_map_batch *lum_map_queue_batch(lum_map_queue *queue);

/** Send it on.
 * @return 0, or -1 with the first failure in error and in errno. */
LUM_MUST_CHECK int lum_map_queue_push(lum_map_queue *queue, lum_error *error);

/** Send it on, and wait until all is in the tables.
 * @return as lum_map_queue_push(). */
LUM_MUST_CHECK int lum_map_queue_flush(lum_map_queue *queue, lum_error *error);

/** End the thread; what is queued is dropped. */
void lum_map_queue_end(lum_map_queue *queue);

#endif
