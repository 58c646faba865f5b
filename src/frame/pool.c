/* The memory of frames, used again; references to frames. */
#include "threads.h"

#include "base/grow.h"

#include <stdlib.h>
#include <string.h>

#define ALIGN    64u
#define ROOM_MIN 65536u

/* Up to this size room is doubled, above it grows by an eighth: unused room
 * costs memory too. */
#define ROOM_DOUBLES 262144u

#define XYZ_COUNT 3u

/* Numbers of 4 bytes that take ALIGN bytes. */
#define ALIGN_COUNT (ALIGN / (uint32_t)sizeof(float))

struct lum_frame_pool {
    size_t points_max; /* of a frame */
    unsigned spare_max;
    bool keeps_raw;
    lum_lock *lock; /* guards what follows */
    lum_frame *spare;
    unsigned spare_count;
    size_t frames; /* that are in use */
    size_t latest; /* points of the frames that were given back of late */
    bool is_left;  /* by its owner */
};

/* --- The pool --- */

lum_frame_pool *lum_frame_pool_new(size_t points_max, unsigned spare_max,
                                   bool keeps_raw)
{
    lum_frame_pool *pool = calloc(1, sizeof *pool);
    if (pool == NULL) {
        return NULL;
    }
    pool->points_max = points_max;
    pool->spare_max = spare_max;
    pool->keeps_raw = keeps_raw;
    pool->lock = lum_lock_new();
    if (pool->lock == NULL) {
        free(pool);
        return NULL;
    }
    return pool;
}

static void free_frame(lum_frame *frame)
{
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        free(frame->store.columns[c].block);
    }
    free(frame->store.xyz);
    free(frame->store.rows);
    free(frame->store.scratch);
    lum_raw_store_free(frame->raw);
    free(frame);
}

static void end_pool(lum_frame_pool *pool)
{
    while (pool->spare != NULL) {
        lum_frame *frame = pool->spare;
        pool->spare = frame->next;
        free_frame(frame);
    }
    lum_lock_free(pool->lock);
    free(pool);
}

void lum_frame_pool_free(lum_frame_pool *pool)
{
    if (pool == NULL) {
        return;
    }
    lum_lock_take(pool->lock);
    pool->is_left = true;
    const bool is_last = pool->frames == 0;
    lum_lock_leave(pool->lock);
    if (is_last) {
        end_pool(pool);
    }
}

/* --- Spare frames --- */

static bool has_xyz(lum_columns mask)
{
    return (mask & LUM_COLUMNS_XYZ) == LUM_COLUMNS_XYZ;
}

/* Whether its memory of x, y and z has the form that these columns need: one
 * block for all three, or a block each. */
static bool has_form(const lum_frame *frame, lum_columns mask)
{
    return (mask & LUM_COLUMNS_XYZ) == 0 ||
           has_xyz(mask) == (frame->store.xyz != NULL);
}

/* Points that fit without allocating. */
static size_t room_of(const lum_frame *frame, lum_columns mask)
{
    size_t room = has_form(frame, mask) ? SIZE_MAX : 0;
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        const size_t here = frame->store.columns[c].room;
        room = (mask & LUM_COLUMN_BIT(c)) != 0 && here < room ? here : room;
    }
    return room;
}

/* The spare frame with the least room, of `needed` to `most`; NULL: there is
 * none. */
static lum_frame *take_spare(lum_frame_pool *pool, lum_columns mask,
                             size_t needed, size_t most)
{
    lum_frame **best = NULL;
    lum_lock_take(pool->lock);
    for (lum_frame **at = &pool->spare; *at != NULL; at = &(*at)->next) {
        const size_t room = room_of(*at, mask);
        if (room >= needed && room <= most &&
            (best == NULL || room < room_of(*best, mask))) {
            best = at;
        }
    }
    lum_frame *frame = best != NULL ? *best : NULL;
    if (frame != NULL) {
        *best = frame->next;
        pool->spare_count--;
    }
    lum_lock_leave(pool->lock);
    return frame;
}

/* The most room that a frame takes which is likely to have so many points; 0:
 * not known. Far larger memory is left to frames of other views and sensors:
 * this one may be kept for long. */
static size_t room_for(size_t points)
{
    const size_t least = points < ROOM_MIN ? ROOM_MIN : points;
    return points == 0 || least > SIZE_MAX / 8u ? SIZE_MAX : 8u * least;
}

/* Memory far larger than the present need is not kept. The lock is held. */
static bool is_worth_keeping(const lum_frame_pool *pool, const lum_frame *frame)
{
    const size_t room = frame->mask != 0 ? room_of(frame, frame->mask) : 0;
    return !pool->is_left && pool->spare_count < pool->spare_max &&
           (room <= ROOM_MIN || room / 8u <= pool->latest);
}

/* What no frame uses goes back, or for good. */
static void give_back(lum_frame_pool *pool, lum_frame *frame)
{
    lum_lock_take(pool->lock);
    const bool is_kept = is_worth_keeping(pool, frame);
    if (is_kept) {
        frame->next = pool->spare;
        pool->spare = frame;
        pool->spare_count++;
    }
    lum_lock_leave(pool->lock);
    if (!is_kept) {
        free_frame(frame);
    }
}

static void drop_columns(lum_frame *frame, lum_columns mask)
{
    if (has_xyz(mask) != (frame->store.xyz != NULL)) {
        mask &= ~LUM_COLUMNS_XYZ;
        free(frame->store.xyz);
        frame->store.xyz = NULL;
    }
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        lum_column_array *array = &frame->store.columns[c];
        if ((mask & LUM_COLUMN_BIT(c)) == 0 && array->at != NULL) {
            free(array->block);
            *array = (lum_column_array){NULL, NULL, 0};
        }
    }
}

/* --- Frames --- */

/* False, and the frame is gone: there is no memory. */
static bool begin_raw(const lum_frame_pool *pool, lum_frame *frame)
{
    if (!pool->keeps_raw) {
        return true;
    }
    if (frame->raw == NULL) {
        frame->raw = lum_raw_store_new();
        if (frame->raw == NULL) {
            free_frame(frame);
            return false;
        }
    }
    lum_raw_store_clear(frame->raw);
    return true;
}

lum_frame *lum_frame_begin(lum_frame_pool *pool, lum_columns mask, size_t usual)
{
    lum_frame *frame = take_spare(pool, mask, usual, room_for(usual));
    if (frame == NULL) {
        frame = take_spare(pool, mask, 0, room_for(usual));
    }
    if (frame == NULL) {
        frame = calloc(1, sizeof *frame);
    }
    if (frame == NULL || !begin_raw(pool, frame)) {
        return NULL;
    }
    drop_columns(frame, mask);
    frame->self = frame;
    frame->pool = pool;
    frame->next = NULL;
    frame->into = NULL;
    frame->usual = usual;
    frame->references = 1;
    frame->points_max = pool->points_max;
    frame->mask = mask;
    frame->count = 0;
    frame->row_count = 0;
    frame->info = (lum_frame_info){.struct_size = sizeof frame->info};
    lum_lock_take(pool->lock);
    pool->frames++;
    lum_lock_leave(pool->lock);
    return frame;
}

lum_frame *lum_frame_keep(const lum_frame *frame)
{
    lum_frame *kept = frame->self;
    lum_lock_take(frame->pool->lock);
    kept->references++;
    lum_lock_leave(frame->pool->lock);
    return kept;
}

/* An empty frame among large ones says little about the need. Called with the
 * lock. */
static void note_size(lum_frame_pool *pool, const lum_frame *frame)
{
    pool->latest /= 2u;
    pool->latest = frame->count > pool->latest ? frame->count : pool->latest;
}

void lum_frame_release(lum_frame *frame)
{
    if (frame == NULL) {
        return;
    }
    lum_frame_pool *pool = frame->pool;
    lum_lock_take(pool->lock);
    frame->references--;
    const bool is_unused = frame->references == 0;
    note_size(pool, frame);
    lum_lock_leave(pool->lock);
    if (!is_unused) {
        return;
    }
    give_back(pool, frame);
    lum_lock_take(pool->lock);
    pool->frames--;
    const bool is_last = pool->is_left && pool->frames == 0;
    lum_lock_leave(pool->lock);
    if (is_last) {
        end_pool(pool);
    }
}

/* --- Growing --- */

static uint8_t *aligned(void *block)
{
    uint8_t *at = block;
    return at + (ALIGN - (uintptr_t)block % ALIGN) % ALIGN;
}

/* Systems move the pages of a large block, so that it exists once, and none is
 * touched again. */
static bool grow_column(lum_column_array *array, size_t bytes, size_t count,
                        size_t room)
{
    const size_t begin =
        array->block != NULL
            ? (size_t)((uint8_t *)array->at - (uint8_t *)array->block)
            : 0;
    uint8_t *block = realloc(array->block, room * bytes + ALIGN);
    if (block == NULL) {
        return false;
    }
    uint8_t *at = aligned(block);
    if (count > 0 && at != block + begin) {
        memmove(at, block + begin, count * bytes);
    }
    *array = (lum_column_array){block, at, room};
    return true;
}

/* As grow_column(), with all three in one block. Each column moves to a higher
 * address, and so the last one first; only x may move to a lower one, by the
 * difference of the alignments. */
static bool grow_xyz(lum_frame_store *store, size_t count, size_t room)
{
    lum_column_array *arrays = &store->columns[LUM_COLUMN_X];
    const size_t before = arrays->room;
    const size_t begin =
        store->xyz != NULL
            ? (size_t)((uint8_t *)arrays->at - (uint8_t *)store->xyz)
            : 0;
    const size_t spacing =
        (room + ALIGN_COUNT - 1u) / ALIGN_COUNT * ALIGN_COUNT;
    uint8_t *block =
        realloc(store->xyz, XYZ_COUNT * spacing * sizeof(float) + ALIGN);
    if (block == NULL) {
        return false;
    }
    for (size_t c = XYZ_COUNT; c-- > 0;) {
        float *at = (float *)(void *)aligned(block) + c * spacing;
        if (count > 0) {
            memmove(at, block + begin + c * before * sizeof *at,
                    count * sizeof *at);
        }
        arrays[c] = (lum_column_array){NULL, at, spacing};
    }
    store->xyz = block;
    return true;
}

static size_t next_room(const lum_frame *frame, size_t needed)
{
    /* a line is made as a whole, and then cut */
    const size_t most = frame->points_max + LUM_LINE_WORDS_MAX;
    const size_t now = room_of(frame, frame->mask);
    size_t room = now < ROOM_MIN ? ROOM_MIN : now;
    while (room < needed) {
        room += room < ROOM_DOUBLES ? room : room / 8u;
    }
    return room < most ? room : most;
}

/* One column after another, so that never all columns exist twice. */
static bool grow(lum_frame *frame, size_t needed)
{
    const size_t room = next_room(frame, needed);
    lum_frame_store *store = &frame->store;
    lum_columns own = frame->mask; /* columns with a block of their own */
    if (has_xyz(own)) {
        own &= ~LUM_COLUMNS_XYZ;
        if (store->columns[LUM_COLUMN_X].room < needed &&
            !grow_xyz(store, frame->count, room)) {
            return false;
        }
    }
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        lum_column_array *array = &store->columns[c];
        if ((own & LUM_COLUMN_BIT(c)) != 0 && array->room < needed &&
            !grow_column(array, lum_column_bytes((lum_column)c), frame->count,
                         room)) {
            return false;
        }
    }
    return true;
}

static void move_into(lum_frame *frame, lum_frame *spare)
{
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        const lum_column_array from = frame->store.columns[c];
        const lum_column_array to = spare->store.columns[c];
        if ((frame->mask & LUM_COLUMN_BIT(c)) != 0) {
            if (frame->count > 0) {
                memcpy(to.at, from.at,
                       frame->count * lum_column_bytes((lum_column)c));
            }
            frame->store.columns[c] = to;
            spare->store.columns[c] = from;
        }
    }
    if (has_xyz(frame->mask)) {
        void *xyz = frame->store.xyz;
        frame->store.xyz = spare->store.xyz;
        spare->store.xyz = xyz;
    }
    spare->mask = frame->mask;
    drop_columns(spare, spare->mask);
    give_back(frame->pool, spare);
}

bool lum_frame_reserve_row(lum_frame *frame)
{
    lum_frame_store *store = &frame->store;
    size_t room = store->row_room;
    lum_frame_line *rows =
        lum_grown(store->rows, frame->row_count, 1, sizeof *rows, &room);
    if (rows == NULL) {
        return false;
    }
    store->rows = rows;
    int64_t *scratch = lum_grown(store->scratch, frame->row_count, 1,
                                 sizeof *scratch, &store->row_room);
    if (scratch == NULL) {
        return false;
    }
    store->scratch = scratch;
    return true;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* A frame often begins before the one before it gives back its memory, and so
 * in smaller memory. It moves as soon as it can, with few points. */
bool lum_frame_claim_room(lum_frame *frame, size_t points)
{
    const size_t needed = frame->count + points;
    const size_t likely = larger(needed, frame->usual);
    if (frame->mask == 0) {
        return true;
    }
    const size_t room = room_of(frame, frame->mask);
    if (frame->into == NULL && room < likely) {
        frame->into =
            take_spare(frame->pool, frame->mask, likely, room_for(likely));
    }
    return room >= needed && frame->into == NULL;
}

bool lum_frame_relocate(lum_frame *frame, size_t points)
{
    const size_t needed = frame->count + points;
    lum_frame *into = frame->into;
    frame->into = NULL;
    if (into == NULL) {
        into = take_spare(frame->pool, frame->mask, needed, room_for(needed));
    }
    if (into == NULL) {
        return grow(frame, needed);
    }
    move_into(frame, into);
    return true;
}
