#define _POSIX_C_SOURCE 200809L
#include "lum/map/map.h"

#include "base/sized.h"
#include "base/thread.h"
#include "parts.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define STEPS      65536.0           /* that a voxel has on each side */
#define LIMIT      140737488355328.0 /* steps from 0 that have a tile: 2^47 */
#define SECONDS    4e9               /* that a time of today can be added to */
#define WIDTH_UNIT 100.0             /* of a pulse width in a nanosecond */
#define READ_CHUNK 256u              /* voxels that are merged at a time */

/* --- Batches on their way to the tables, by a thread or at once --- */

#define BATCH_POINTS 4096u /* points of one */
#define BATCHES      8u    /* of them */

/* Points of a batch. */
struct batch {
    uint64_t ids[BATCH_POINTS];         /* of the tile of each */
    lum_map_entry points[BATCH_POINTS]; /* each as a voxel with one point */
    size_t count;                       /* how many */
};

/* What is on its way. */
struct queue {
    struct batch *batches;  /* BATCHES; without a thread 1 */
    unsigned filling;       /* which the caller fills */
    lum_map_tiles *tiles;   /* where they go; the thread's, as long as
                                 batches are queued */
    bool has_thread;        /* whether there is one */
    pthread_t thread;       /* it */
    pthread_mutex_t lock;   /* guards what follows */
    pthread_cond_t changed; /* likewise */
    unsigned queued;        /* batches, up to the one that is filled */
    bool stop;              /* the thread is to end */
    int failure;            /* errno of the first failure, or 0 */
    lum_error text;         /* of that */
};

static void add_batch(struct queue *queue, const struct batch *batch)
{
    lum_error text = {""};
    if (lum_map_tiles_add(queue->tiles, batch->ids, batch->points, batch->count,
                          &text) != 0) {
        queue->failure = errno;
        queue->text = text;
    }
}

/* The oldest batch; lock is held before and after. */
static void take_oldest(struct queue *queue)
{
    const unsigned oldest =
        (queue->filling + BATCHES - queue->queued) % BATCHES;
    lum_error text = {""};
    int code = 0;
    (void)pthread_mutex_unlock(&queue->lock);
    const struct batch *batch = &queue->batches[oldest];
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

static void *run_queue(void *argument)
{
    struct queue *queue = argument;
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

/* queue is all bytes 0. 0, or an errno. */
static int queue_begin(struct queue *queue, lum_map_tiles *tiles,
                       bool has_thread)
{
    queue->tiles = tiles;
    queue->batches =
        malloc((has_thread ? BATCHES : 1u) * sizeof *queue->batches);
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
    const int code = lum_thread_start(&queue->thread, run_queue, queue);
    queue->has_thread = code == 0;
    return code;
}

static int failure_of(const struct queue *queue, lum_error *error)
{
    if (queue->failure == 0) {
        return 0;
    }
    (void)lum_error_set(error, "%s", queue->text.text);
    errno = queue->failure;
    return -1;
}

/* Wait until at most so many batches are queued. */
static int wait_until(struct queue *queue, unsigned most, lum_error *error)
{
    while (queue->queued > most && queue->failure == 0) {
        (void)pthread_cond_wait(&queue->changed, &queue->lock);
    }
    return failure_of(queue, error);
}

static int push_batch(struct queue *queue, unsigned most, lum_error *error)
{
    (void)pthread_mutex_lock(&queue->lock);
    queue->queued++;
    queue->filling = (queue->filling + 1u) % BATCHES;
    (void)pthread_cond_broadcast(&queue->changed);
    const int result = wait_until(queue, most, error);
    (void)pthread_mutex_unlock(&queue->lock);
    return result;
}

/* Behind the batches that are queued is one that is filled. */
static int queue_push(struct queue *queue, lum_error *error)
{
    if (queue->has_thread) {
        const int result = push_batch(queue, BATCHES - 1u, error);
        queue->batches[queue->filling].count = 0;
        return result;
    }
    if (queue->failure == 0) {
        add_batch(queue, queue->batches);
    }
    queue->batches[0].count = 0;
    return failure_of(queue, error);
}

/* Waits until all is in the tables. */
static int queue_flush(struct queue *queue, lum_error *error)
{
    if (!queue->has_thread) {
        return queue_push(queue, error);
    }
    const int result = push_batch(queue, 0, error);
    queue->batches[queue->filling].count = 0;
    return result;
}

/* What is queued is dropped. */
static void queue_end(struct queue *queue)
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

/* --- The map --- */

struct lum_map {
    double scale; /* steps of a metre */
    char *beside;
    lum_map_tiles tiles;
    struct queue queue;
    lum_map_counters counters; /* points, those left out, given out */
    bool has_ended;            /* voxels are given out */
    uint64_t next;             /* the tile to be given out next */
    lum_map_tile *tile;        /* which is given out; NULL: none */
    lum_map_merge merge;       /* its parts */
};

/* --- Begin and end --- */

static int check(const lum_map_options *o, lum_error *error)
{
    errno = EINVAL;
    if (!(o->voxel >= LUM_MAP_VOXEL_MIN && o->voxel <= LUM_MAP_VOXEL_MAX)) {
        return lum_error_set(error, "a voxel of %g m: %g to %g m are possible",
                             o->voxel, LUM_MAP_VOXEL_MIN, LUM_MAP_VOXEL_MAX);
    }
    if (o->memory != 0 && o->memory < LUM_MAP_MEMORY_MIN) {
        return lum_error_set(error, "%llu bytes for a map: it needs %llu",
                             (unsigned long long)o->memory,
                             (unsigned long long)LUM_MAP_MEMORY_MIN);
    }
    return 0;
}

static int begin(lum_map *map, const lum_map_options *o)
{
    const size_t n = o->spool != NULL ? strlen(o->spool) + 1u : 0u;
    map->scale = STEPS / o->voxel;
    map->tiles.memory = o->memory != 0 ? o->memory : LUM_MAP_MEMORY;
    map->tiles.spool.fd = -1;
    if (n > 0) {
        map->beside = malloc(n);
        if (map->beside == NULL) {
            return ENOMEM;
        }
        memcpy(map->beside, o->spool, n);
    }
    map->tiles.beside = map->beside;
    return queue_begin(&map->queue, &map->tiles, o->has_thread);
}

int lum_map_new(const lum_map_options *options, lum_map **out, lum_error *error)
{
    lum_map_options known;
    if (lum_sized_take(&known, sizeof known, options, "the map's options",
                       "lum_map_options", error) != 0 ||
        check(&known, error) != 0) {
        return -1;
    }
    lum_map *map = calloc(1, sizeof *map);
    const int code = map == NULL ? ENOMEM : begin(map, &known);
    if (code != 0) {
        lum_map_free(map);
        errno = code;
        return lum_error_set(error, "the map: %s", strerror(code));
    }
    *out = map;
    return 0;
}

void lum_map_free(lum_map *map)
{
    const int code = errno;
    if (map != NULL) {
        queue_end(&map->queue);
        lum_map_merge_end(&map->merge);
        lum_map_tiles_free(&map->tiles);
        free(map->beside);
        free(map);
    }
    errno = code;
}

/* --- Adding --- */

/* Steps from the lowest place that has a tile, 48 bits. The sum is above 0, so
 * that the fraction is cut downwards; it is rounded to 1/32 of a step. */
static bool to_steps(double metres, double scale, uint64_t *out)
{
    const double v = metres * scale + LIMIT;
    *out = 0;
    if (!(v >= 0.0 && v < 2.0 * LIMIT)) {
        return false;
    }
    *out = (uint64_t)(int64_t)v;
    return true;
}

static uint16_t width_of(float ns)
{
    const double units = (double)ns * WIDTH_UNIT + 0.5;
    return units >= 65535.0 ? 65535u : units >= 1.0 ? (uint16_t)units : 0u;
}

static int64_t time_of(int64_t from_ns, float seconds)
{
    const double s = (double)seconds;
    const double ns = s * 1e9;
    return s > -SECONDS && s < SECONDS
               ? from_ns + (int64_t)(ns + (ns < 0 ? -0.5 : 0.5))
               : from_ns;
}

static void put(struct batch *batch, const uint64_t at[3])
{
    lum_map_entry *entry = &batch->points[batch->count];
    batch->ids[batch->count++] =
        at[0] >> 24 << 40 | at[1] >> 24 << 16 | at[2] >> 32;
    entry->key =
        (uint32_t)((at[0] >> 16 & 0xffu) << 24 | (at[1] >> 16 & 0xffu) << 16 |
                   (at[2] >> 16 & 0xffffu));
    entry->count = 1;
    for (unsigned k = 0; k < 3u; k++) {
        entry->at[k] = (uint16_t)(at[k] & 0xffffu);
    }
}

static bool add_point(lum_map *map, struct batch *batch,
                      const lum_map_points *p, size_t i)
{
    const double x = (double)p->x[i] + p->origin[0];
    const double y = (double)p->y[i] + p->origin[1];
    const double z = (double)p->z[i] + p->origin[2];
    uint64_t at[3];
    if (!to_steps(x, map->scale, &at[0]) || !to_steps(y, map->scale, &at[1]) ||
        !to_steps(z, map->scale, &at[2])) {
        /* isfinite() of a double warns on Windows. */
        const bool is_finite = fabs(x) + fabs(y) + fabs(z) <= DBL_MAX;
        map->counters.out_of_range += is_finite ? 1u : 0u;
        map->counters.not_finite += is_finite ? 0u : 1u;
        return false;
    }
    lum_map_entry *entry = &batch->points[batch->count];
    entry->time_ns =
        p->time != NULL ? time_of(p->time_ns, p->time[i]) : p->time_ns;
    entry->width = p->pulse_width != NULL ? width_of(p->pulse_width[i]) : 0u;
    put(batch, at);
    return true;
}

int lum_map_add(lum_map *map, const lum_map_points *points, lum_error *error)
{
    lum_map_points known;
    if (lum_sized_take(&known, sizeof known, points, "the points",
                       "lum_map_points", error) != 0) {
        return -1;
    }
    if (map->has_ended) {
        errno = EINVAL;
        return lum_error_set(error, "the map: no points can be added after "
                                    "voxels were given out; make a new map");
    }
    for (size_t i = 0; i < known.count; i++) {
        struct batch *batch = &map->queue.batches[map->queue.filling];
        if (add_point(map, batch, &known, i)) {
            map->counters.points++;
            if (batch->count == BATCH_POINTS &&
                queue_push(&map->queue, error) != 0) {
                return -1;
            }
        }
    }
    return 0;
}

/* --- Giving out --- */

static double to_metres(const lum_map *map, uint64_t steps)
{
    return ((double)((int64_t)steps - (int64_t)LIMIT) + 0.5) / map->scale;
}

static lum_map_voxel voxel_of(const lum_map *map, const lum_map_entry *entry)
{
    const uint64_t id = map->tile->id;
    const uint64_t key = entry->key;
    const uint64_t x = id >> 40 << 24 | key >> 24 << 16 | entry->at[0];
    const uint64_t y =
        (id >> 16 & 0xffffffu) << 24 | (key >> 16 & 0xffu) << 16 | entry->at[1];
    const uint64_t z =
        (id & 0xffffu) << 32 | (key & 0xffffu) << 16 | entry->at[2];
    return (lum_map_voxel){.x = to_metres(map, x),
                           .y = to_metres(map, y),
                           .z = to_metres(map, z),
                           .time_ns = entry->time_ns,
                           .pulse_width =
                               (float)((double)entry->width / WIDTH_UNIT),
                           .count = entry->count};
}

/* Only what is on the disk fails otherwise; then there is a name. */
static int fail(const lum_map *map, int code, lum_error *error)
{
    errno = code;
    return code == ENOMEM
               ? lum_error_set(error,
                               "the map: out of memory while its voxels are "
                               "given out; free some, or take larger voxels")
               : lum_error_set(error,
                               "%s: the map's temporary file beside it cannot "
                               "be read: %s; put the map on another disk",
                               map->beside, strerror(code));
}

/* Go on to the next tile; none: map->tile is NULL. */
static int begin_tile(lum_map *map, lum_error *error)
{
    map->tile = NULL;
    if (map->next == map->tiles.count) {
        return 0;
    }
    map->tile = map->tiles.index[map->next++];
    int code = lum_map_table_sort(&map->tile->table) == 0 ? 0 : ENOMEM;
    if (code == 0) {
        code = lum_map_merge_begin(&map->merge, map->tile, &map->tiles.spool);
    }
    return code == 0 ? 0 : fail(map, code, error);
}

static int end_adding(lum_map *map, lum_error *error)
{
    if (map->has_ended) {
        return 0;
    }
    if (queue_flush(&map->queue, error) != 0) {
        return -1;
    }
    map->counters.voxels_most = map->tiles.on_disk + map->tiles.in_memory;
    map->has_ended = true;
    lum_map_tiles_sort(&map->tiles);
    map->counters.voxels_least = lum_map_tiles_least(&map->tiles);
    return begin_tile(map, error);
}

/* Some voxels of the present tile; the next tile if there are no more. */
static int take_some(lum_map *map, lum_map_voxel *voxels, size_t room,
                     size_t *count, lum_error *error)
{
    lum_map_entry entries[READ_CHUNK];
    const size_t n = room < READ_CHUNK ? room : READ_CHUNK;
    const int code =
        lum_map_merge_next(&map->merge, &map->tiles.spool, entries, n, count);
    if (code != 0) {
        return fail(map, code, error);
    }
    for (size_t i = 0; i < *count; i++) {
        voxels[i] = voxel_of(map, &entries[i]);
    }
    if (*count == n) {
        return 0;
    }
    lum_map_merge_end(&map->merge);
    lum_map_tiles_release(&map->tiles, map->tile);
    return begin_tile(map, error);
}

int lum_map_next(lum_map *map, lum_map_voxel *voxels, size_t room,
                 size_t *count, lum_error *error)
{
    size_t n = 0;
    *count = 0;
    if (end_adding(map, error) != 0) {
        return -1;
    }
    while (map->tile != NULL && n < room) {
        size_t more = 0;
        if (take_some(map, voxels + n, room - n, &more, error) != 0) {
            return -1;
        }
        n += more;
    }
    map->counters.voxels += n;
    *count = n;
    return 0;
}

int lum_map_count(lum_map *map, lum_map_counters *out)
{
    lum_error ignored;
    lum_map_counters counters = map->counters;
    counters.struct_size = sizeof counters;
    if (!map->has_ended) {
        if (queue_flush(&map->queue, &ignored) != 0) {
            return -1;
        }
        counters.voxels_most = map->tiles.on_disk + map->tiles.in_memory;
    }
    counters.tiles = map->tiles.count;
    counters.memory_most = map->tiles.held_most;
    counters.spooled = map->tiles.spool.size;
    return lum_sized_fill(out, &counters, sizeof counters) ? 0 : -1;
}
