#include "tiles.h"

#include "parts.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define INDEX_BITS 8u /* of the first index */
#define MIB        (1024.0 * 1024.0)
#define BITS_FIRST 7u  /* of the smallest table */
#define BITS_MAX   30u /* of the largest */
#define DIGIT_BITS 11u /* of a key, in sorting */
#define DIGITS     (1u << DIGIT_BITS)
#define AHEAD      16u /* points between loading a slot and using it */

/* --- A table of voxels --- */

/* The order of keys among voxels, while they are sorted. */
typedef struct place {
    uint32_t key;
    uint32_t from;
} place;

static size_t table_bytes(const lum_map_table *table)
{
    return table->at == NULL ? 0u : sizeof *table->at << table->bits;
}

static size_t table_bytes_next(const lum_map_table *table)
{
    const unsigned bits = table->at == NULL ? BITS_FIRST : table->bits + 1u;
    return sizeof *table->at << bits;
}

/* Full by three quarters, then it is slow. */
static bool table_has_room(const lum_map_table *table)
{
    return table->at != NULL && table->used + LUM_MAP_CHUNK <=
                                    3u * ((uint32_t)1 << table->bits) / 4u;
}

static lum_map_entry *entry_of(const lum_map_table *table, uint32_t key)
{
    return &table->at[key * UINT32_C(0x9e3779b1) >> (32u - table->bits)];
}

/* The slot of a key, or the free one where it belongs. */
static lum_map_entry *find_entry(const lum_map_table *table, uint32_t key)
{
    const lum_map_entry *end = table->at + ((size_t)1 << table->bits);
    lum_map_entry *slot = entry_of(table, key);
    while (slot->count != 0 && slot->key != key) {
        slot = slot + 1 < end ? slot + 1 : table->at;
    }
    return slot;
}

static int table_grow(lum_map_table *table)
{
    lum_map_table next = {
        .bits = (uint8_t)(table->at == NULL ? BITS_FIRST : table->bits + 1u)};
    if (next.bits > BITS_MAX) {
        return -1;
    }
    next.at = calloc((size_t)1 << next.bits, sizeof *next.at);
    if (next.at == NULL) {
        return -1;
    }
    const size_t old = table->at == NULL ? 0u : (size_t)1 << table->bits;
    for (size_t i = 0; i < old; i++) {
        if (table->at[i].count != 0) {
            *find_entry(&next, table->at[i].key) = table->at[i];
        }
    }
    next.used = table->used;
    free(table->at);
    *table = next;
    return 0;
}

static void prefetch(const lum_map_table *table, uint32_t key)
{
#if defined(__GNUC__)
    __builtin_prefetch(entry_of(table, key), 1);
#else
    (void)table;
    (void)key;
#endif
}

static void table_prefetch(const lum_map_table *table,
                           const lum_map_entry *points, size_t count)
{
    for (size_t i = 0; table->at != NULL && i < count && i < AHEAD; i++) {
        prefetch(table, points[i].key);
    }
}

static void table_add(lum_map_table *table, const lum_map_entry *points,
                      size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (i + AHEAD < count) {
            prefetch(table, points[i + AHEAD].key);
        }
        lum_map_entry *slot = find_entry(table, points[i].key);
        if (slot->count == 0) {
            *slot = points[i];
            table->used++;
        } else {
            lum_map_join(slot, &points[i]);
        }
    }
}

/* --- Sorting --- */

static void sort_by_digit(const place *from, place *to, size_t n,
                          unsigned shift)
{
    uint32_t begins[DIGITS] = {0};
    uint32_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        begins[from[i].key >> shift & (DIGITS - 1u)]++;
    }
    for (size_t d = 0; d < DIGITS; d++) {
        const uint32_t count = begins[d];
        begins[d] = sum;
        sum += count;
    }
    for (size_t i = 0; i < n; i++) {
        to[begins[from[i].key >> shift & (DIGITS - 1u)]++] = from[i];
    }
}

/* Move each entry to its place along the circles of the permutation: from[to]
 * is where the entry of a place is before. */
static void permute(lum_map_entry *at, uint32_t *from, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const lum_map_entry first = at[i];
        size_t to = i;
        while (from[to] != i) {
            const size_t next = from[to];
            at[to] = at[next];
            from[to] = (uint32_t)to;
            to = next;
        }
        at[to] = first;
        from[to] = (uint32_t)to;
    }
}

static int compare_keys(const void *a, const void *b)
{
    const uint32_t one = ((const lum_map_entry *)a)->key;
    const uint32_t other = ((const lum_map_entry *)b)->key;
    return one < other ? -1 : one > other;
}

static int sort_keys(lum_map_entry *at, size_t n)
{
    place *places = calloc(2u * n, sizeof *places);
    if (places == NULL) {
        return -1;
    }
    for (size_t i = 0; i < n; i++) {
        places[i] = (place){at[i].key, (uint32_t)i};
    }
    sort_by_digit(places, places + n, n, 0);
    sort_by_digit(places + n, places, n, DIGIT_BITS);
    sort_by_digit(places, places + n, n, 2u * DIGIT_BITS);
    uint32_t *from = (uint32_t *)places;
    for (size_t i = 0; i < n; i++) {
        from[i] = places[n + i].from;
    }
    permute(at, from, n);
    free(places);
    return 0;
}

int lum_map_table_sort(lum_map_table *table)
{
    if (table->at == NULL) {
        return 0;
    }
    const size_t slots = (size_t)1 << table->bits;
    size_t n = 0;
    for (size_t i = 0; i < slots; i++) {
        if (table->at[i].count != 0) {
            table->at[n++] = table->at[i];
        }
    }
    if (n >= DIGITS) {
        return sort_keys(table->at, n);
    }
    qsort(table->at, n, sizeof *table->at, compare_keys);
    return 0;
}

static void table_free(lum_map_table *table)
{
    free(table->at);
    *table = (lum_map_table){0};
}

/* --- Index --- */

static lum_map_tile **slot_of(const lum_map_tiles *tiles, uint64_t id)
{
    const uint64_t mask = ((uint64_t)1 << tiles->bits) - 1u;
    uint64_t i = id * UINT64_C(0x9e3779b97f4a7c15) >> (64u - tiles->bits);
    while (tiles->index[i] != NULL && tiles->index[i]->id != id) {
        i = (i + 1u) & mask;
    }
    return &tiles->index[i];
}

static int grow_index(lum_map_tiles *tiles)
{
    lum_map_tiles next = {
        .bits =
            (uint8_t)(tiles->index == NULL ? INDEX_BITS : tiles->bits + 1u)};
    next.index = calloc((size_t)1 << next.bits, sizeof(lum_map_tile *));
    if (next.index == NULL) {
        return -1;
    }
    const size_t old = tiles->index == NULL ? 0u : (size_t)1 << tiles->bits;
    for (size_t i = 0; i < old; i++) {
        if (tiles->index[i] != NULL) {
            *slot_of(&next, tiles->index[i]->id) = tiles->index[i];
        }
    }
    free(tiles->index);
    tiles->index = next.index;
    tiles->bits = next.bits;
    return 0;
}

/* A new one if there is none; NULL: no memory. */
static lum_map_tile *find(lum_map_tiles *tiles, uint64_t id)
{
    if ((tiles->index == NULL ||
         2u * (tiles->count + 1u) > (uint64_t)1 << tiles->bits) &&
        grow_index(tiles) != 0) {
        return NULL;
    }
    lum_map_tile **slot = slot_of(tiles, id);
    if (*slot == NULL) {
        *slot = calloc(1, sizeof **slot);
        if (*slot != NULL) {
            (*slot)->id = id;
            tiles->count++;
        }
    }
    return *slot;
}

static int compare(const void *a, const void *b)
{
    const uint64_t one = (*(lum_map_tile *const *)a)->id;
    const uint64_t other = (*(lum_map_tile *const *)b)->id;
    return one < other ? -1 : one > other;
}

void lum_map_tiles_sort(lum_map_tiles *tiles)
{
    const size_t slots = tiles->index == NULL ? 0u : (size_t)1 << tiles->bits;
    size_t n = 0;
    for (size_t i = 0; i < slots; i++) {
        lum_map_tile *tile = tiles->index[i];
        tiles->index[i] = NULL;
        if (tile != NULL) {
            tiles->index[n++] = tile;
        }
    }
    if (n > 1u) {
        qsort(tiles->index, n, sizeof(lum_map_tile *), compare);
    }
}

/* --- Those in memory --- */

static void unlink_tile(lum_map_tiles *tiles, lum_map_tile *tile)
{
    if (tile->newer != NULL) {
        tile->newer->older = tile->older;
    } else if (tiles->newest == tile) {
        tiles->newest = tile->older;
    }
    if (tile->older != NULL) {
        tile->older->newer = tile->newer;
    } else if (tiles->oldest == tile) {
        tiles->oldest = tile->newer;
    }
    tile->newer = NULL;
    tile->older = NULL;
}

static void touch(lum_map_tiles *tiles, lum_map_tile *tile)
{
    if (tiles->newest == tile) {
        return;
    }
    unlink_tile(tiles, tile);
    tile->older = tiles->newest;
    if (tiles->newest != NULL) {
        tiles->newest->newer = tile;
    } else {
        tiles->oldest = tile;
    }
    tiles->newest = tile;
}

void lum_map_tiles_release(lum_map_tiles *tiles, lum_map_tile *tile)
{
    tiles->held -= table_bytes(&tile->table);
    tiles->in_memory -= tile->table.used;
    unlink_tile(tiles, tile);
    table_free(&tile->table);
}

static int fail_memory(const lum_map_tiles *tiles, lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error,
                         "the map: out of memory, with %.0f MiB in its tables; "
                         "free some, or take larger voxels",
                         (double)tiles->held / MIB);
}

static int fail_disk(const lum_map_tiles *tiles, int code, lum_error *error)
{
    (void)lum_error_set(
        error,
        "%s: after %.4g MiB, the map's temporary file beside it cannot be "
        "written: %s; free some of the disk, put the map on another, or take "
        "larger voxels",
        tiles->beside, (double)tiles->spool.size / MIB, strerror(code));
    errno = code;
    return -1;
}

static int fail_full(const lum_map_tiles *tiles, lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error,
                         "the map does not fit in %.0f MiB, and has no place "
                         "on the disk; give it one, more memory, or larger "
                         "voxels",
                         (double)tiles->memory / MIB);
}

/* Move a tile to the disk. */
static int evict(lum_map_tiles *tiles, lum_map_tile *tile, lum_error *error)
{
    int64_t written = 0;
    int code = 0;
    if (tiles->beside == NULL) {
        return fail_full(tiles, error);
    }
    if (tiles->spool.fd < 0) {
        code = lum_map_spool_open(&tiles->spool, tiles->beside);
    }
    if (code == 0 && lum_map_table_sort(&tile->table) != 0) {
        return fail_memory(tiles, error);
    }
    if (code == 0) {
        code = lum_map_part_write(tile, &tiles->spool, &written);
    }
    if (code != 0) {
        return fail_disk(tiles, code, error);
    }
    tiles->on_disk += (uint64_t)written;
    tile->least =
        tile->table.used > tile->least ? tile->table.used : tile->least;
    lum_map_tiles_release(tiles, tile);
    return 0;
}

/* Until so many bytes more fit, or nothing is left to be moved. */
static int make_room(lum_map_tiles *tiles, size_t bytes, lum_error *error)
{
    while (tiles->held + bytes > tiles->memory && tiles->oldest != NULL) {
        if (evict(tiles, tiles->oldest, error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* Both tables are there while one grows. */
static int grow(lum_map_tiles *tiles, lum_map_tile *tile, lum_error *error)
{
    if (make_room(tiles, table_bytes_next(&tile->table), error) != 0) {
        return -1;
    }
    const size_t before = table_bytes(&tile->table);
    if (table_grow(&tile->table) != 0) {
        return fail_memory(tiles, error);
    }
    const size_t now = table_bytes(&tile->table);
    const uint64_t both = tiles->held + now;
    tiles->held_most = both > tiles->held_most ? both : tiles->held_most;
    tiles->held = both - before;
    touch(tiles, tile);
    return 0;
}

/* --- Adding --- */

static size_t same_tile(const uint64_t *ids, size_t count)
{
    size_t n = 1;
    while (n < count && n < LUM_MAP_CHUNK && ids[n] == ids[0]) {
        n++;
    }
    return n;
}

static int add_some(lum_map_tiles *tiles, lum_map_tile *tile,
                    const lum_map_entry *points, size_t n, lum_error *error)
{
    if (tile->table.at != NULL) {
        touch(tiles, tile);
    }
    while (!table_has_room(&tile->table)) {
        if (grow(tiles, tile, error) != 0) {
            return -1;
        }
    }
    const uint32_t before = tile->table.used;
    table_add(&tile->table, points, n);
    tiles->in_memory += tile->table.used - before;
    return 0;
}

/* The next points' slots are on their way to the cache while these are
 * added. */
int lum_map_tiles_add(lum_map_tiles *tiles, const uint64_t *ids,
                      const lum_map_entry *points, size_t count,
                      lum_error *error)
{
    size_t n = count > 0 ? same_tile(ids, count) : 0u;
    lum_map_tile *tile = count > 0 ? find(tiles, ids[0]) : NULL;
    for (size_t i = 0; i < count && tile != NULL;) {
        const size_t next = i + n;
        const size_t next_n =
            next < count ? same_tile(ids + next, count - next) : 0u;
        lum_map_tile *next_tile = next < count ? find(tiles, ids[next]) : tile;
        if (next_n > 0 && next_tile != NULL) {
            table_prefetch(&next_tile->table, points + next, next_n);
        }
        if (add_some(tiles, tile, points + i, n, error) != 0) {
            return -1;
        }
        tile = next_tile;
        i = next;
        n = next_n;
    }
    return count > 0 && tile == NULL ? fail_memory(tiles, error) : 0;
}

uint64_t lum_map_tiles_least(const lum_map_tiles *tiles)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; i < tiles->count; i++) {
        const lum_map_tile *tile = tiles->index[i];
        sum += tile->table.used > tile->least ? tile->table.used : tile->least;
    }
    return sum;
}

void lum_map_tiles_free(lum_map_tiles *tiles)
{
    const size_t slots = tiles->index == NULL ? 0u : (size_t)1 << tiles->bits;
    for (size_t i = 0; i < slots; i++) {
        if (tiles->index[i] != NULL) {
            table_free(&tiles->index[i]->table);
            free(tiles->index[i]);
        }
    }
    free(tiles->index);
    lum_map_spool_close(&tiles->spool);
}
