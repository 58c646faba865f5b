/** @file
 * The voxels of a tile in memory: a table with open addressing. Internal to
 * map. */
#ifndef LUM_MAP_TABLE_H
#define LUM_MAP_TABLE_H

#include "entry.h"

#include "lum/result.h"

#include <stddef.h>

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
