/** @file
 * The tiles of a map: found by number, in memory as long as they fit, and what
 * of them is on the disk. Internal to map.
 *
 * What a tile had in memory when it went to the disk is a part: its voxels in
 * rising order of keys, with the place of the tile's part before behind them.
 * So no list of parts is kept in memory. */
#ifndef LUM_MAP_TILES_H
#define LUM_MAP_TILES_H

#include "spool.h"
#include "table.h"

#include "lum/base/error.h"

#include <stdbool.h>

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
