#define _POSIX_C_SOURCE 200809L
#include "frame_make.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define SPARE_MAX    8u
#define CAPACITY_MIN 65536u

/* Bytes of a point before each array. */
#define WIDTH_AT  12u
#define LINE_AT   14u
#define PIXEL_AT  16u
#define RETURN_AT 18u
#define BITS_AT   19u

struct frame {
    struct frame_pool *pool;
    struct frame *next; /* of the spare ones */
    uint8_t *bytes;     /* while it is made, arrays are of capacity */
    size_t capacity;    /* points */
    size_t count;
    uint64_t cut;
    unsigned references; /* guarded by the pool's lock */
};

struct frame_pool {
    size_t points_max; /* of a frame */
    pthread_mutex_t lock;
    struct frame *spare;
    size_t spare_count;
    size_t frames;   /* that are in use */
    size_t capacity; /* of the largest of late: the next begins so */
    bool is_left;    /* by its owner */
};

struct frame_pool *frame_pool_new(size_t points_max)
{
    struct frame_pool *pool = calloc(1, sizeof *pool);
    if (pool != NULL) {
        (void)pthread_mutex_init(&pool->lock, NULL);
        pool->capacity = CAPACITY_MIN;
        pool->points_max = points_max;
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
    (void)pthread_mutex_destroy(&pool->lock);
    free(pool);
}

void frame_pool_free(struct frame_pool *pool)
{
    if (pool == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&pool->lock);
    pool->is_left = true;
    const bool is_last = pool->frames == 0;
    (void)pthread_mutex_unlock(&pool->lock);
    if (is_last) {
        end_pool(pool);
    }
}

static struct frame *new_frame(struct frame_pool *pool, size_t capacity)
{
    struct frame *frame = calloc(1, sizeof *frame);
    if (frame == NULL) {
        return NULL;
    }
    frame->pool = pool;
    frame->capacity = capacity;
    frame->bytes = malloc(FRAME_HEAD_BYTES + capacity * FRAME_POINT_BYTES);
    if (frame->bytes == NULL) {
        free(frame);
        return NULL;
    }
    return frame;
}

struct frame *frame_begin(struct frame_pool *pool)
{
    (void)pthread_mutex_lock(&pool->lock);
    struct frame *frame = pool->spare;
    const size_t capacity = pool->capacity;
    if (frame != NULL) {
        pool->spare = frame->next;
        pool->spare_count--;
    }
    pool->frames++;
    (void)pthread_mutex_unlock(&pool->lock);
    if (frame == NULL) {
        frame = new_frame(pool, capacity);
    }
    if (frame == NULL) {
        (void)pthread_mutex_lock(&pool->lock);
        pool->frames--;
        (void)pthread_mutex_unlock(&pool->lock);
        return NULL;
    }
    frame->count = 0;
    frame->cut = 0;
    frame->references = 1;
    return frame;
}

struct frame *frame_keep(struct frame *frame)
{
    (void)pthread_mutex_lock(&frame->pool->lock);
    frame->references++;
    (void)pthread_mutex_unlock(&frame->pool->lock);
    return frame;
}

/* Called with the lock. What is far larger than what is needed now is not kept.
 */
static bool is_worth_keeping(const struct frame_pool *pool,
                             const struct frame *frame)
{
    return !pool->is_left && pool->spare_count < SPARE_MAX &&
           frame->capacity / 8u <= pool->capacity;
}

void frame_release(struct frame *frame)
{
    if (frame == NULL) {
        return;
    }
    struct frame_pool *pool = frame->pool;
    (void)pthread_mutex_lock(&pool->lock);
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
    (void)pthread_mutex_unlock(&pool->lock);
    if (is_unused && !is_kept) {
        free_frame(frame);
    }
    if (is_last) {
        end_pool(pool);
    }
}

const uint8_t *frame_bytes(const struct frame *frame, size_t *len)
{
    *len = FRAME_HEAD_BYTES + frame->count * FRAME_POINT_BYTES;
    return frame->bytes;
}

uint64_t frame_cut(const struct frame *frame)
{
    return frame->cut;
}

/* Where the array that has so many bytes of each point before it begins, in
 * arrays of so many points. */
static uint8_t *array_at(uint8_t *bytes, unsigned before, size_t points)
{
    return bytes + FRAME_HEAD_BYTES + before * points;
}

/* The arrays of count points, laid out for so many, to a layout for others. */
static void move_arrays(uint8_t *to, size_t to_points, uint8_t *from,
                        size_t from_points, size_t count)
{
    static const unsigned arrays[][2] = {{WIDTH_AT, 2},
                                         {LINE_AT, 2},
                                         {PIXEL_AT, 2},
                                         {RETURN_AT, 1},
                                         {BITS_AT, 1}};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        memmove(array_at(to, arrays[i][0], to_points),
                array_at(from, arrays[i][0], from_points),
                arrays[i][1] * count);
    }
}

static bool grow(struct frame *frame, size_t needed)
{
    size_t capacity = frame->capacity;
    while (capacity < needed) {
        capacity *= 2u;
    }
    uint8_t *bytes = malloc(FRAME_HEAD_BYTES + capacity * FRAME_POINT_BYTES);
    if (bytes == NULL) {
        return false;
    }
    memcpy(bytes + FRAME_HEAD_BYTES, frame->bytes + FRAME_HEAD_BYTES,
           WIDTH_AT * frame->count);
    move_arrays(bytes, capacity, frame->bytes, frame->capacity, frame->count);
    free(frame->bytes);
    frame->bytes = bytes;
    frame->capacity = capacity;
    return true;
}

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

static inline uint8_t bits_of(const lum_sample *s, uint8_t eye)
{
    const unsigned returns =
        s->number_of_returns < 63u ? s->number_of_returns : 63u;
    return (uint8_t)(eye | (unsigned)s->edge << 1 | returns << 2);
}

static inline uint8_t return_of(const lum_sample *s, unsigned strongest)
{
    const unsigned number = s->return_number < 127u ? s->return_number : 127u;
    return (uint8_t)(number | strongest << 7);
}

static inline bool is_asked(const lum_sample *s, unsigned edges)
{
    return (edges & (s->edge != 0 ? LUM_EDGES_RISING : LUM_EDGES_FALLING)) != 0;
}

/* There is room for all of the part. */
static size_t write_part(struct frame *frame, const struct frame_part *part)
{
    const size_t at = frame->count;
    const unsigned edges = (unsigned)part->edges;
    const uint16_t number =
        part->line < UINT16_MAX ? (uint16_t)part->line : UINT16_MAX;
    uint8_t *xyz = frame->bytes + FRAME_HEAD_BYTES + WIDTH_AT * at;
    uint8_t *width = array_at(frame->bytes, WIDTH_AT, frame->capacity) + 2 * at;
    uint8_t *line = array_at(frame->bytes, LINE_AT, frame->capacity) + 2 * at;
    uint8_t *pixel = array_at(frame->bytes, PIXEL_AT, frame->capacity) + 2 * at;
    uint8_t *ret = array_at(frame->bytes, RETURN_AT, frame->capacity) + at;
    uint8_t *bits = array_at(frame->bytes, BITS_AT, frame->capacity) + at;
    size_t n = 0;
    for (size_t i = 0; i < part->count; i++) {
        const lum_sample *s = &part->samples[i];
        put_float(xyz + WIDTH_AT * n, s->x);
        put_float(xyz + WIDTH_AT * n + 4, s->y);
        put_float(xyz + WIDTH_AT * n + 8, s->z);
        put16(width + 2 * n, width_of(s->pulse_width));
        put16(line + 2 * n, number);
        put16(pixel + 2 * n, s->pixel);
        ret[n] = return_of(s, part->strongest[i]);
        bits[n] = bits_of(s, part->eye);
        n += is_asked(s, edges) ? 1u : 0u;
    }
    return n;
}

static size_t count_asked(const struct frame_part *part)
{
    size_t n = 0;
    for (size_t i = 0; i < part->count; i++) {
        n += is_asked(&part->samples[i], (unsigned)part->edges) ? 1u : 0u;
    }
    return n;
}

bool frame_add(struct frame *frame, const struct frame_part *part)
{
    struct frame_part fitting = *part;
    const size_t room = frame->pool->points_max - frame->count;
    if (part->count > room) {
        fitting.count = room;
        frame->cut +=
            count_asked(&(struct frame_part){.samples = part->samples + room,
                                             .count = part->count - room,
                                             .edges = part->edges});
    }
    if (frame->capacity < frame->count + fitting.count &&
        !grow(frame, frame->count + fitting.count)) {
        return false;
    }
    frame->count += write_part(frame, &fitting);
    return true;
}

static void note_capacity(struct frame *frame)
{
    struct frame_pool *pool = frame->pool;
    (void)pthread_mutex_lock(&pool->lock);
    pool->capacity = frame->capacity;
    (void)pthread_mutex_unlock(&pool->lock);
}

static uint32_t fit32(uint64_t value)
{
    return value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
}

void frame_seal(struct frame *frame, const struct frame_head *head)
{
    uint8_t *to = frame->bytes;
    move_arrays(to, frame->count, to, frame->capacity, frame->count);
    note_capacity(frame);
    put32(to, FRAME_MAGIC);
    put16(to + 4, FRAME_VERSION);
    put16(to + 6, FRAME_HEAD_BYTES);
    put_double(to + 8, (double)head->frame);
    put_double(to + 16, (double)head->clock_us);
    put_double(to + 24, (double)head->utc_ns * 1e-9);
    put32(to + 32, (uint32_t)frame->count);
    to[36] = (uint8_t)head->edges;
    to[37] = (uint8_t)head->smooth;
    put16(to + 38, 0);
    put32(to + 40, head->lines);
    put32(to + 44, fit32(head->lost_words));
    put32(to + 48, head->sensor);
    put32(to + 52, fit32(head->shown));
    put_double(to + 56, (double)head->complete_ns * 1e-9);
}
