#define _POSIX_C_SOURCE 200809L
#include "queue.h"

#include "base/thread.h"

#include <errno.h>
#include <stdlib.h>

static void put(lum_map_queue *queue, const lum_map_batch *batch)
{
    lum_error text = {""};
    if (lum_map_tiles_add(queue->tiles, batch->ids, batch->points, batch->count,
                          &text) != 0) {
        queue->failure = errno;
        queue->text = text;
    }
}

/* The oldest batch; lock is held before and after. */
static void take_oldest(lum_map_queue *queue)
{
    const unsigned oldest =
        (queue->filling + LUM_MAP_BATCHES - queue->queued) % LUM_MAP_BATCHES;
    lum_error text = {""};
    int code = 0;
    (void)pthread_mutex_unlock(&queue->lock);
    const lum_map_batch *batch = &queue->batches[oldest];
    if (lum_map_tiles_add(queue->tiles, batch->ids, batch->points, batch->count,
                          &text) != 0) {
        code = errno;
    }
    (void)pthread_mutex_lock(&queue->lock);
    if (code != 0) {
        queue->failure = code;
        queue->text = text;
    }
    queue->queued--;
    (void)pthread_cond_broadcast(&queue->changed);
}

static void *run(void *argument)
{
    lum_map_queue *queue = argument;
    (void)pthread_mutex_lock(&queue->lock);
    while (!queue->stop && queue->failure == 0) {
        if (queue->queued > 0) {
            take_oldest(queue);
        } else {
            (void)pthread_cond_wait(&queue->changed, &queue->lock);
        }
    }
    (void)pthread_mutex_unlock(&queue->lock);
    return NULL;
}

int lum_map_queue_begin(lum_map_queue *queue, lum_map_tiles *tiles,
                        bool has_thread)
{
    queue->tiles = tiles;
    queue->batches =
        malloc((has_thread ? LUM_MAP_BATCHES : 1u) * sizeof *queue->batches);
    if (queue->batches == NULL) {
        return ENOMEM;
    }
    queue->batches[0].count = 0;
    if (!has_thread) {
        return 0;
    }
    if (pthread_mutex_init(&queue->lock, NULL) != 0 ||
        pthread_cond_init(&queue->changed, NULL) != 0) {
        return ENOMEM;
    }
    const int code = lum_thread_start(&queue->thread, run, queue);
    queue->has_thread = code == 0;
    return code;
}

lum_map_batch *lum_map_queue_batch(lum_map_queue *queue)
{
    return &queue->batches[queue->filling];
}

static int failure_of(const lum_map_queue *queue, lum_error *error)
{
    if (queue->failure == 0) {
        return 0;
    }
    (void)lum_error_set(error, "%s", queue->text.text);
    errno = queue->failure;
    return -1;
}

/* Wait until at most so many batches are queued. */
static int wait_until(lum_map_queue *queue, unsigned most, lum_error *error)
{
    while (queue->queued > most && queue->failure == 0) {
        (void)pthread_cond_wait(&queue->changed, &queue->lock);
    }
    return failure_of(queue, error);
}

static int push(lum_map_queue *queue, unsigned most, lum_error *error)
{
    (void)pthread_mutex_lock(&queue->lock);
    queue->queued++;
    queue->filling = (queue->filling + 1u) % LUM_MAP_BATCHES;
    (void)pthread_cond_broadcast(&queue->changed);
    const int result = wait_until(queue, most, error);
    (void)pthread_mutex_unlock(&queue->lock);
    return result;
}

/* Behind the batches that are queued is one that is filled. */
int lum_map_queue_push(lum_map_queue *queue, lum_error *error)
{
    if (queue->has_thread) {
        const int result = push(queue, LUM_MAP_BATCHES - 1u, error);
        queue->batches[queue->filling].count = 0;
        return result;
    }
    if (queue->failure == 0) {
        put(queue, queue->batches);
    }
    queue->batches[0].count = 0;
    return failure_of(queue, error);
}

int lum_map_queue_flush(lum_map_queue *queue, lum_error *error)
{
    if (!queue->has_thread) {
        return lum_map_queue_push(queue, error);
    }
    const int result = push(queue, 0, error);
    queue->batches[queue->filling].count = 0;
    return result;
}

void lum_map_queue_end(lum_map_queue *queue)
{
    if (queue->has_thread) {
        (void)pthread_mutex_lock(&queue->lock);
        queue->stop = true;
        (void)pthread_cond_broadcast(&queue->changed);
        (void)pthread_mutex_unlock(&queue->lock);
        (void)pthread_join(queue->thread, NULL);
        (void)pthread_cond_destroy(&queue->changed);
        (void)pthread_mutex_destroy(&queue->lock);
    }
    free(queue->batches);
}
