#define _POSIX_C_SOURCE 200809L
#include "frame_make.h"

#include "thread.h"

#include "lum/frame/clock_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SPARE_MAX 8u

/* Bytes of a point before each array. */
#define WIDTH_AT  12u
#define LINE_AT   14u
#define PIXEL_AT  16u
#define RETURN_AT 18u
#define BITS_AT   19u

struct frame {
    struct frame_pool *pool;
    struct frame *next; /* of the spare ones */
    uint8_t *bytes;
    size_t capacity; /* points */
    size_t count;
    size_t parts;        /* sensors of a rig */
    unsigned references; /* guarded by the pool's gate */
};

struct frame_pool {
    struct gate *gate;
    struct frame *spare;
    size_t spare_count;
    size_t frames; /* that are in use */
    size_t latest; /* points of the frame that was made last */
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
    free(frame->bytes);
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

/* The first spare one that is large enough, or the first, to be enlarged. */
static struct frame *take_spare(struct frame_pool *pool, size_t count)
{
    struct frame **at = &pool->spare;
    while (*at != NULL && (*at)->capacity < count) {
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

/* What it held is not needed. */
static bool enlarge(struct frame *frame, size_t count)
{
    const size_t capacity = count + count / 8u;
    if (frame->bytes != NULL && count <= frame->capacity) {
        return true;
    }
    free(frame->bytes);
    frame->bytes = malloc(FRAME_HEAD_BYTES + capacity * FRAME_POINT_BYTES +
                          FRAME_PARTS_MAX * FRAME_PART_BYTES);
    frame->capacity = frame->bytes != NULL ? capacity : 0;
    return frame->bytes != NULL;
}

/* A frame with room for this many points. */
static struct frame *begin(struct frame_pool *pool, size_t count)
{
    gate_take(pool->gate);
    struct frame *frame = take_spare(pool, count);
    pool->frames++;
    pool->latest = count;
    gate_leave(pool->gate);
    if (frame == NULL) {
        frame = calloc(1, sizeof *frame);
    }
    if (frame == NULL || !enlarge(frame, count)) {
        free(frame);
        gate_take(pool->gate);
        pool->frames--;
        gate_leave(pool->gate);
        return NULL;
    }
    frame->pool = pool;
    frame->count = count;
    frame->parts = 0;
    frame->references = 1;
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
           frame->capacity / 8u <= pool->latest;
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
    *len = FRAME_HEAD_BYTES + frame->count * FRAME_POINT_BYTES +
           frame->parts * FRAME_PART_BYTES;
    return frame->bytes;
}

/* --- Bytes of points --- */

/* Compilers make one store of each of these. */
static inline void put16(uint8_t *to, uint16_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
}

static inline void put32(uint8_t *to, uint32_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
    to[2] = (uint8_t)(value >> 16);
    to[3] = (uint8_t)(value >> 24);
}

static void put64(uint8_t *to, uint64_t value)
{
    put32(to, (uint32_t)value);
    put32(to + 4, (uint32_t)(value >> 32));
}

static inline void put_float(uint8_t *to, float value)
{
    uint32_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    put32(to, bits);
}

static void put_double(uint8_t *to, double value)
{
    uint64_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    put64(to, bits);
}

static inline uint16_t width_of(float ns)
{
    const float hundredths = ns * 100.0f + 0.5f;
    return hundredths < 65535.0f ? (uint16_t)hundredths : UINT16_MAX;
}

/* Points of a frame of the library, and where they go. */
struct part {
    const struct frame *frame;
    const lum_frame *points;
    size_t first;
    size_t count;
};

/* The start of the part's elements of the array that has this many bytes of
 * each point before it. */
static uint8_t *array_at(const struct part *part, unsigned before,
                         unsigned bytes)
{
    return part->frame->bytes + FRAME_HEAD_BYTES + before * part->frame->count +
           bytes * part->first;
}

static void put_space(const struct part *part)
{
    const lum_frame *points = part->points;
    const float *x = lum_frame_floats(points, LUM_COLUMN_X);
    const float *y = lum_frame_floats(points, LUM_COLUMN_Y);
    const float *z = lum_frame_floats(points, LUM_COLUMN_Z);
    const float *width = lum_frame_floats(points, LUM_COLUMN_PULSE_WIDTH);
    uint8_t *to = array_at(part, 0, WIDTH_AT);
    uint8_t *to_width = array_at(part, WIDTH_AT, 2);
    for (size_t i = 0; i < part->count; i++) {
        put_float(to + WIDTH_AT * i, x[i]);
        put_float(to + WIDTH_AT * i + 4, y[i]);
        put_float(to + WIDTH_AT * i + 8, z[i]);
        put16(to_width + 2 * i, width_of(width[i]));
    }
}

static void put_places(const struct part *part)
{
    const lum_frame *points = part->points;
    const uint32_t *line = lum_frame_uint32s(points, LUM_COLUMN_LINE);
    const uint16_t *pixel = lum_frame_uint16s(points, LUM_COLUMN_PIXEL);
    uint8_t *to_line = array_at(part, LINE_AT, 2);
    uint8_t *to_pixel = array_at(part, PIXEL_AT, 2);
    for (size_t i = 0; i < part->count; i++) {
        put16(to_line + 2 * i,
              line[i] < UINT16_MAX ? (uint16_t)line[i] : UINT16_MAX);
        put16(to_pixel + 2 * i, pixel[i]);
    }
}

static void put_returns(const struct part *part)
{
    const lum_frame *points = part->points;
    const uint16_t *numbers =
        lum_frame_uint16s(points, LUM_COLUMN_RETURN_NUMBER);
    const uint16_t *counts =
        lum_frame_uint16s(points, LUM_COLUMN_NUMBER_OF_RETURNS);
    const uint8_t *eye = lum_frame_uint8s(points, LUM_COLUMN_EYE);
    const uint8_t *edge = lum_frame_uint8s(points, LUM_COLUMN_EDGE);
    const uint8_t *strongest = lum_frame_uint8s(points, LUM_COLUMN_STRONGEST);
    uint8_t *to_return = array_at(part, RETURN_AT, 1);
    uint8_t *to_bits = array_at(part, BITS_AT, 1);
    for (size_t i = 0; i < part->count; i++) {
        const unsigned number = numbers[i] < 127u ? numbers[i] : 127u;
        const unsigned count = counts[i] < 63u ? counts[i] : 63u;
        to_return[i] = (uint8_t)(number | (unsigned)strongest[i] << 7);
        to_bits[i] = (uint8_t)(eye[i] | (unsigned)edge[i] << 1 | count << 2);
    }
}

/* --- Messages --- */

static uint32_t fit32(uint64_t value)
{
    return value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
}

static void put_head(const struct frame *frame, const struct frame_head *head,
                     size_t second_count)
{
    uint8_t *to = frame->bytes;
    put32(to, FRAME_MAGIC);
    put16(to + 4, FRAME_VERSION);
    put16(to + 6, FRAME_HEAD_BYTES);
    put_double(to + 8, (double)head->frame);
    put_double(to + 16, (double)head->clock_us);
    put_double(to + 24, (double)head->begin.utc_ns * 1e-9);
    put32(to + 32, (uint32_t)frame->count);
    to[36] = (uint8_t)head->edges;
    to[37] = (uint8_t)head->smooth;
    to[38] = (uint8_t)head->begin.kind;
    to[39] = (uint8_t)frame->parts;
    put32(to + 40, head->lines);
    put32(to + 44, fit32(head->lost_words));
    put32(to + 48, head->sensor);
    put32(to + 52, fit32(head->shown));
    put_double(to + 56, (double)head->complete_ns * 1e-9);
    put_double(to + 64, head->begin.error_ns != LUM_CLOCK_ERROR_UNKNOWN
                            ? (double)head->begin.error_ns * 1e-9
                            : (double)NAN);
    put32(to + 72, (uint32_t)second_count);
    put32(to + 76, 0);
}

static void put_part(const struct part *part)
{
    if (part->count > 0) {
        put_space(part);
        put_places(part);
        put_returns(part);
    }
}

struct frame *frame_make(struct frame_pool *pool, const lum_frame *points,
                         const lum_frame *second, const struct frame_head *head)
{
    const size_t count = lum_frame_count(points);
    const size_t more = second != NULL ? lum_frame_count(second) : 0;
    struct frame *frame = begin(pool, count + more);
    if (frame == NULL) {
        return NULL;
    }
    put_head(frame, head, more);
    put_part(&(struct part){frame, points, 0, count});
    put_part(&(struct part){frame, second, count, more});
    return frame;
}

struct frame *frame_make_rig(struct frame_pool *pool,
                             const struct frame_part *parts, size_t count,
                             const struct frame_head *head)
{
    size_t total = 0;
    for (size_t i = 0; i < count; i++) {
        total += lum_frame_count(parts[i].points);
    }
    struct frame *frame = begin(pool, total);
    if (frame == NULL) {
        return NULL;
    }
    frame->parts = count;
    put_head(frame, head, 0);
    uint8_t *to = frame->bytes + FRAME_HEAD_BYTES + FRAME_POINT_BYTES * total;
    size_t first = 0;
    for (size_t i = 0; i < count; i++) {
        const size_t points = lum_frame_count(parts[i].points);
        put_part(&(struct part){frame, parts[i].points, first, points});
        put_double(to, (double)parts[i].frame);
        put32(to + 8, (uint32_t)points);
        put32(to + 12, parts[i].sensor);
        to += FRAME_PART_BYTES;
        first += points;
    }
    return frame;
}
