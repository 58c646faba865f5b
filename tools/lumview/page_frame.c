#include "page_frame.h"

#include "thread_monitor.h"

#include <stdlib.h>

#define SPARE_MAX 8u

struct frame {
    struct frame_pool *pool;
    struct frame *next; /* of the spare ones */
    lum_packed packed;
    unsigned references; /* guarded by the pool's monitor */
};

struct frame_pool {
    struct monitor *monitor;
    struct frame *spare;
    size_t spare_count;
    size_t frames; /* that are in use */
    size_t latest; /* bytes of the frame that was made last */
    bool is_left;  /* by its owner */
};

/* --- Buffers --- */

struct frame_pool *frame_pool_new(void)
{
    struct frame_pool *pool = calloc(1, sizeof *pool);
    if (pool == NULL) {
        return NULL;
    }
    pool->monitor = monitor_new();
    if (pool->monitor == NULL) {
        free(pool);
        return NULL;
    }
    return pool;
}

static void free_frame(struct frame *frame)
{
    lum_packed_free(&frame->packed);
    free(frame);
}

static void end_pool(struct frame_pool *pool)
{
    while (pool->spare != NULL) {
        struct frame *frame = pool->spare;
        pool->spare = frame->next;
        free_frame(frame);
    }
    monitor_free(pool->monitor);
    free(pool);
}

void frame_pool_free(struct frame_pool *pool)
{
    if (pool == NULL) {
        return;
    }
    monitor_lock(pool->monitor);
    pool->is_left = true;
    const bool is_last = pool->frames == 0;
    monitor_unlock(pool->monitor);
    if (is_last) {
        end_pool(pool);
    }
}

/* The first spare one that is large enough for one like the latest, or the
 * first, to be enlarged. */
static struct frame *take_spare(struct frame_pool *pool)
{
    struct frame **at = &pool->spare;
    while (*at != NULL && (*at)->packed.room < pool->latest) {
        at = &(*at)->next;
    }
    at = *at != NULL ? at : &pool->spare;
    struct frame *frame = *at;
    if (frame != NULL) {
        *at = frame->next;
        pool->spare_count--;
    }
    return frame;
}

/* NULL without memory. */
static struct frame *begin(struct frame_pool *pool)
{
    monitor_lock(pool->monitor);
    struct frame *frame = take_spare(pool);
    monitor_unlock(pool->monitor);
    return frame != NULL ? frame : calloc(1, sizeof *frame);
}

/* Its messages are there. */
static struct frame *end(struct frame_pool *pool, struct frame *frame)
{
    frame->pool = pool;
    frame->references = 1;
    monitor_lock(pool->monitor);
    pool->frames++;
    pool->latest = frame->packed.len;
    monitor_unlock(pool->monitor);
    return frame;
}

struct frame *frame_keep(struct frame *frame)
{
    monitor_lock(frame->pool->monitor);
    frame->references++;
    monitor_unlock(frame->pool->monitor);
    return frame;
}

/* Memory far larger than the present need is not kept. With the monitor. */
static bool is_worth_keeping(const struct frame_pool *pool,
                             const struct frame *frame)
{
    return !pool->is_left && pool->spare_count < SPARE_MAX &&
           frame->packed.room / 8u <= pool->latest;
}

void frame_release(struct frame *frame)
{
    if (frame == NULL) {
        return;
    }
    struct frame_pool *pool = frame->pool;
    monitor_lock(pool->monitor);
    frame->references--;
    const bool is_unused = frame->references == 0;
    const bool is_kept = is_unused && is_worth_keeping(pool, frame);
    if (is_kept) {
        frame->next = pool->spare;
        pool->spare = frame;
        pool->spare_count++;
    }
    pool->frames -= is_unused ? 1u : 0u;
    const bool is_last = is_unused && pool->is_left && pool->frames == 0;
    monitor_unlock(pool->monitor);
    if (is_unused && !is_kept) {
        free_frame(frame);
    }
    if (is_last) {
        end_pool(pool);
    }
}

const uint8_t *frame_bytes(const struct frame *frame, size_t *len)
{
    *len = frame->packed.len;
    return frame->packed.bytes;
}

size_t frame_piece(const struct frame *frame, size_t at)
{
    return lum_packed_piece(&frame->packed, at);
}

/* --- Messages --- */

struct frame *frame_make(struct frame_pool *pool, const lum_packed_head *head,
                         const lum_packed_part *parts, size_t count)
{
    struct frame *frame = begin(pool);
    if (frame == NULL ||
        lum_packed_make(head, parts, count, &frame->packed) != LUM_OK) {
        if (frame != NULL) {
            free_frame(frame);
        }
        return NULL;
    }
    return end(pool, frame);
}
