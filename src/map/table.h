/** @file
 * The voxels of a tile in memory: what one is, the rule by which points and
 * voxels become one, and a table with open addressing. Internal to map. */
#ifndef LUM_MAP_TABLE_H
#define LUM_MAP_TABLE_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A voxel of a tile. The distance of its point from the centre is an integer,
 * so that every processor finds the same point nearest. */
typedef struct lum_map_entry {
    int64_t time_ns; /**< of the nearest point */
    uint32_t key;    /**< voxel within the tile: x 8 bits, y 8, z 16 */
    uint32_t count;  /**< points; 0: a free slot */
    uint16_t at[3];  /**< of the nearest point, 65536ths of the voxel */
    uint16_t width;  /**< its pulse width, 0.01 ns */
} lum_map_entry;

static inline uint32_t lum_map_square(uint16_t at)
{
    const int32_t from_centre = (int32_t)at - 32768;
    return (uint32_t)(from_centre * from_centre);
}

/** At most 3 x 2^30. */
static inline uint32_t lum_map_distance(const lum_map_entry *entry)
{
    return lum_map_square(entry->at[0]) + lum_map_square(entry->at[1]) +
           lum_map_square(entry->at[2]);
}

static inline uint64_t lum_map_rank(const lum_map_entry *entry)
{
    return (uint64_t)entry->at[0] << 48 | (uint64_t)entry->at[1] << 32 |
           (uint64_t)entry->at[2] << 16 | entry->width;
}

/** Whether the point of one counts rather than that of the other. */
static inline bool lum_map_is_before(const lum_map_entry *one,
                                     const lum_map_entry *other)
{
    const uint32_t near = lum_map_distance(one);
    const uint32_t far = lum_map_distance(other);
    if (near != far) {
        return near < far;
    }
    return one->time_ns != other->time_ns
               ? one->time_ns < other->time_ns
               : lum_map_rank(one) < lum_map_rank(other);
}

/** Add points of the same voxel. */
static inline void lum_map_join(lum_map_entry *entry, const lum_map_entry *more)
{
    const uint32_t left = UINT32_MAX - entry->count;
    const uint32_t count =
        entry->count + (more->count < left ? more->count : left);
    if (lum_map_is_before(more, entry)) {
        *entry = *more;
    }
    entry->count = count;
}

/** Points that are added at a time; a table always has room for so many. */
#define LUM_MAP_CHUNK 64u

/** A table; all bytes 0: none. */
typedef struct lum_map_table {
    lum_map_entry *at; /**< 2^bits slots; NULL: none */
    uint32_t used;     /**< slots with a voxel */
    uint8_t bits;      /**< see at */
} lum_map_table;

/** Bytes of it, or of one that has twice its slots; the smallest one for none.
 */
size_t lum_map_table_bytes(const lum_map_table *table);
size_t lum_map_table_bytes_next(const lum_map_table *table);

/** Whether LUM_MAP_CHUNK more voxels fit. */
bool lum_map_table_has_room(const lum_map_table *table);

/** Make it twice as large, or make the smallest one.
 * @return 0; -1: no memory, and it is unchanged. */
LUM_MUST_CHECK int lum_map_table_grow(lum_map_table *table);

/** Add at most LUM_MAP_CHUNK points. */
void lum_map_table_add(lum_map_table *table, const lum_map_entry *points,
                       size_t count);

/** Load into the cache where points will go. */
void lum_map_table_prefetch(const lum_map_table *table,
                            const lum_map_entry *points, size_t count);

/** Bring its voxels to the front, in rising order of keys. It is a table no
 * more, but an array.
 * @return 0; -1: no memory for that; then it can only be freed. */
LUM_MUST_CHECK int lum_map_table_sort(lum_map_table *table);

/** Free its memory; then there is none. */
void lum_map_table_free(lum_map_table *table);

#endif
