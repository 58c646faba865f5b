/** @file
 * The tiles of a map: found by number, in memory as long as they fit, and what
 * of them is on the disk. Internal to map.
 *
 * What a tile had in memory when it went to the disk is a part: its voxels in
 * rising order of keys, with the place of the tile's part before behind them.
 * So no list of parts is kept in memory. */
#ifndef LUM_MAP_TILES_H
#define LUM_MAP_TILES_H

#include "lum/base/error.h"
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

/** A temporary file without a name: what is written is appended, and read again
 * by its place. It is gone with the process, however that ends. */
typedef struct lum_map_spool {
    int fd;        /**< -1: not made yet */
    uint64_t size; /**< bytes written */
} lum_map_spool;

/** Most parts of a tile; then they become one. */
#define LUM_MAP_PARTS_MAX 64u

/** A tile. */
typedef struct lum_map_tile {
    uint64_t id;                /**< x 24 bits, y 24, z 16, each from below */
    lum_map_table table;        /**< what is in memory; sorted: an array */
    struct lum_map_tile *newer; /**< among those in memory, by last touch */
    struct lum_map_tile *older; /**< likewise */
    uint64_t part;              /**< place of the end of its newest part */
    uint32_t parts;             /**< how many */
    uint32_t least;             /**< voxels of its largest part */
} lum_map_tile;

/** All tiles. */
typedef struct lum_map_tiles {
    lum_map_tile **index; /**< by id, open addressing; NULL: free */
    uint8_t bits;         /**< it has 2^bits slots */
    uint64_t count;       /**< tiles */
    lum_map_tile *newest; /**< of those in memory */
    lum_map_tile *oldest; /**< likewise */
    uint64_t held;        /**< bytes of tables */
    uint64_t held_most;   /**< at one time */
    uint64_t memory;      /**< bytes that tables may take */
    uint64_t on_disk;     /**< voxels in parts */
    uint64_t in_memory;   /**< voxels in tables */
    const char *beside;   /**< where the spool is to be; NULL: none */
    lum_map_spool spool;  /**< see above */
} lum_map_tiles;

/** Bring the voxels of a table to the front, in rising order of keys. It is a
 * table no more, but an array.
 * @return 0; -1: no memory for that; then it can only be freed. */
LUM_MUST_CHECK int lum_map_table_sort(lum_map_table *table);

/** Add points, those of a tile one behind the other.
 * @param ids of the tile of each.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_map_tiles_add(lum_map_tiles *tiles, const uint64_t *ids,
                                     const lum_map_entry *points, size_t count,
                                     lum_error *error);

/** Bring the index into rising order of ids; it is no index any more, but an
 * array of count tiles. */
void lum_map_tiles_sort(lum_map_tiles *tiles);

/** Voxels that there are at least, once they are sorted. */
uint64_t lum_map_tiles_least(const lum_map_tiles *tiles);

/** Free what a tile has in memory. */
void lum_map_tiles_release(lum_map_tiles *tiles, lum_map_tile *tile);

/** Free all. */
void lum_map_tiles_free(lum_map_tiles *tiles);

#endif
