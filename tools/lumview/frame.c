#define _POSIX_C_SOURCE 200809L
#include "frame_make.h"

#include "thread.h"

#include "lum/frame/packed.h"

#include <stdlib.h>

#define SPARE_MAX 8u

struct frame {
    struct frame_pool *pool;
    struct frame *next; /* of the spare ones */
    lum_packed packed;
    unsigned references; /* guarded by the pool's gate */
};

struct frame_pool {
    struct gate *gate;
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
    pool->gate = gate_new();
    if (pool->gate == NULL) {
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
    gate_free(pool->gate);
    free(pool);
}

void frame_pool_free(struct frame_pool *pool)
{
    if (pool == NULL) {
        return;
    }
    gate_take(pool->gate);
    pool->is_left = true;
    const bool is_last = pool->frames == 0;
    gate_leave(pool->gate);
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
    gate_take(pool->gate);
    struct frame *frame = take_spare(pool);
    gate_leave(pool->gate);
    return frame != NULL ? frame : calloc(1, sizeof *frame);
}

/* Its messages are there. */
static struct frame *end(struct frame_pool *pool, struct frame *frame)
{
    frame->pool = pool;
    frame->references = 1;
    gate_take(pool->gate);
    pool->frames++;
    pool->latest = frame->packed.len;
    gate_leave(pool->gate);
    return frame;
}

struct frame *frame_keep(struct frame *frame)
{
    gate_take(frame->pool->gate);
    frame->references++;
    gate_leave(frame->pool->gate);
    return frame;
}

/* Memory far larger than the present need is not kept. With the gate. */
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
    gate_take(pool->gate);
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
    gate_leave(pool->gate);
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

static struct frame *make(struct frame_pool *pool, const lum_packed_part *parts,
                          size_t count, bool is_rig,
                          const struct frame_head *head)
{
    const lum_packed_head packed = {.struct_size = sizeof packed,
                                    .frame = head->frame,
                                    .clock_us = head->clock_us,
                                    .utc_ns = head->begin.utc_ns,
                                    .utc_error_ns = head->begin.error_ns,
                                    .complete_ns = head->complete_ns,
                                    .lost_words = head->lost_words,
                                    .shown = head->shown,
                                    .sensor = head->sensor,
                                    .lines = head->lines,
                                    .time = (uint8_t)head->begin.kind,
                                    .edges = (uint8_t)head->edges,
                                    .smooth = (uint8_t)head->smooth,
                                    .is_rig = is_rig};
    struct frame *frame = begin(pool);
    if (frame == NULL ||
        lum_packed_make(&packed, parts, count, &frame->packed) != LUM_OK) {
        if (frame != NULL) {
            free_frame(frame);
        }
        return NULL;
    }
    return end(pool, frame);
}

struct frame *frame_make(struct frame_pool *pool, const lum_frame *points,
                         const lum_frame *second, const struct frame_head *head)
{
    lum_packed_part parts[2] = {{.struct_size = sizeof parts[0]},
                                {.struct_size = sizeof parts[1]}};
    if (lum_packed_part_of(points, &parts[0]) != LUM_OK ||
        (second != NULL && lum_packed_part_of(second, &parts[1]) != LUM_OK)) {
        return NULL;
    }
    return make(pool, parts, second != NULL ? 2 : 1, false, head);
}

struct frame *frame_make_rig(struct frame_pool *pool,
                             const struct frame_part *parts, size_t count,
                             const struct frame_head *head)
{
    lum_packed_part packed[FRAME_PARTS_MAX];
    for (size_t i = 0; i < count; i++) {
        packed[i].struct_size = sizeof packed[i];
        if (lum_packed_part_of(parts[i].points, &packed[i]) != LUM_OK) {
            return NULL;
        }
        packed[i].frame = parts[i].frame;
        packed[i].sensor = parts[i].sensor;
    }
    return make(pool, packed, count, true, head);
}
