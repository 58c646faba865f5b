#include "table.h"

#include <stdlib.h>

#define BITS_FIRST 7u  /* of the smallest table */
#define BITS_MAX   30u /* of the largest */
#define DIGIT_BITS 11u /* of a key, in sorting */
#define DIGITS     (1u << DIGIT_BITS)
#define AHEAD      16u /* points between loading a slot and using it */

/* The order of keys among voxels, while they are sorted. */
typedef struct place {
    uint32_t key;
    uint32_t from;
} place;

size_t lum_map_table_bytes(const lum_map_table *table)
{
    return table->at == NULL ? 0u : sizeof *table->at << table->bits;
}

size_t lum_map_table_bytes_next(const lum_map_table *table)
{
    const unsigned bits = table->at == NULL ? BITS_FIRST : table->bits + 1u;
    return sizeof *table->at << bits;
}

/* Full by three quarters, then it is slow. */
bool lum_map_table_has_room(const lum_map_table *table)
{
    return table->at != NULL && table->used + LUM_MAP_CHUNK <=
                                    3u * ((uint32_t)1 << table->bits) / 4u;
}

static lum_map_entry *slot_of(const lum_map_table *table, uint32_t key)
{
    return &table->at[key * UINT32_C(0x9e3779b1) >> (32u - table->bits)];
}

/* The slot of a key, or the free one where it belongs. */
static lum_map_entry *find(const lum_map_table *table, uint32_t key)
{
    const lum_map_entry *end = table->at + ((size_t)1 << table->bits);
    lum_map_entry *slot = slot_of(table, key);
    while (slot->count != 0 && slot->key != key) {
        slot = slot + 1 < end ? slot + 1 : table->at;
    }
    return slot;
}

int lum_map_table_grow(lum_map_table *table)
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
            *find(&next, table->at[i].key) = table->at[i];
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
    __builtin_prefetch(slot_of(table, key), 1);
#else
    (void)table;
    (void)key;
#endif
}

void lum_map_table_prefetch(const lum_map_table *table,
                            const lum_map_entry *points, size_t count)
{
    for (size_t i = 0; table->at != NULL && i < count && i < AHEAD; i++) {
        prefetch(table, points[i].key);
    }
}

void lum_map_table_add(lum_map_table *table, const lum_map_entry *points,
                       size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (i + AHEAD < count) {
            prefetch(table, points[i + AHEAD].key);
        }
        lum_map_entry *slot = find(table, points[i].key);
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

static int compare(const void *a, const void *b)
{
    const uint32_t one = ((const lum_map_entry *)a)->key;
    const uint32_t other = ((const lum_map_entry *)b)->key;
    return one < other ? -1 : one > other;
}

static int sort(lum_map_entry *at, size_t n)
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
        return sort(table->at, n);
    }
    qsort(table->at, n, sizeof *table->at, compare);
    return 0;
}

void lum_map_table_free(lum_map_table *table)
{
    free(table->at);
    *table = (lum_map_table){0};
}
