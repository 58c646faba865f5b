#include "lum/map/map.h"

#include "base/sized.h"
#include "parts.h"
#include "queue.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STEPS      65536.0           /* that a voxel has on each side */
#define LIMIT      140737488355328.0 /* steps from 0 that have a tile: 2^47 */
#define SECONDS    4e9               /* that a time of today can be added to */
#define WIDTH_UNIT 100.0             /* of a pulse width in a nanosecond */
#define READ_CHUNK 256u              /* voxels that are merged at a time */

struct lum_map {
    double scale; /* steps of a metre */
    char *beside;
    lum_map_tiles tiles;
    lum_map_queue queue;
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
    return lum_map_queue_begin(&map->queue, &map->tiles, o->has_thread);
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
        lum_map_queue_end(&map->queue);
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

static void put(lum_map_batch *batch, const uint64_t at[3])
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

static bool add_point(lum_map *map, lum_map_batch *batch,
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
        return lum_error_set(error, "the map: points after voxels were given "
                                    "out; make a new map");
    }
    for (size_t i = 0; i < known.count; i++) {
        lum_map_batch *batch = lum_map_queue_batch(&map->queue);
        if (add_point(map, batch, &known, i)) {
            map->counters.points++;
            if (batch->count == LUM_MAP_BATCH &&
                lum_map_queue_push(&map->queue, error) != 0) {
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
    if (lum_map_queue_flush(&map->queue, error) != 0) {
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
        if (lum_map_queue_flush(&map->queue, &ignored) != 0) {
            return -1;
        }
        counters.voxels_most = map->tiles.on_disk + map->tiles.in_memory;
    }
    counters.tiles = map->tiles.count;
    counters.memory_most = map->tiles.held_most;
    counters.spooled = map->tiles.spool.size;
    return lum_sized_fill(out, &counters, sizeof counters) ? 0 : -1;
}
