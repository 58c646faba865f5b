/** @file
 * Parts of tiles on the disk, and the parts of a tile as one. Internal to
 * map. */
#ifndef LUM_MAP_PARTS_H
#define LUM_MAP_PARTS_H

#include "tiles.h"

/** Make the file of parts.
 * @param beside a name in the folder where it is to be.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_spool_open(lum_map_spool *spool, const char *beside);

/** Close it, if it is open. errno stays. */
void lum_map_spool_close(lum_map_spool *spool);

/** A part that is read, or what the tile has in memory. */
typedef struct lum_map_part {
    const lum_map_entry *next; /**< in order; NULL: there are no more */
    const lum_map_entry *end;  /**< behind the last that is in memory */
    uint64_t from;             /**< where the others are on the disk */
    uint64_t left;             /**< so many */
    lum_map_entry *buffer;     /**< where they are read to */
} lum_map_part;

/** The parts of a tile that are read at once; all bytes 0: none. */
typedef struct lum_map_merge {
    lum_map_part parts[LUM_MAP_PARTS_MAX + 1u]; /**< of them: */
    unsigned count;                             /**< how many */
    lum_map_entry *buffers;                     /**< of all of them */
} lum_map_merge;

/** Begin. The tile's table is sorted, and stays until the end.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_merge_begin(lum_map_merge *merge,
                                       const lum_map_tile *tile,
                                       const lum_map_spool *spool);

/** The next voxels in order of keys, the same of several parts as one.
 * @param count how many of room; fewer than that: there are no more.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_merge_next(lum_map_merge *merge,
                                      const lum_map_spool *spool,
                                      lum_map_entry *out, size_t room,
                                      size_t *count);

/** Free its memory. */
void lum_map_merge_end(lum_map_merge *merge);

/** Write a tile's sorted table as a part, and if it has many, all of them as
 * one. The table stays.
 * @param written voxels that are in parts now and were not before; fewer than 0
 *                if they became one.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_part_write(lum_map_tile *tile, lum_map_spool *spool,
                                      int64_t *written);

#endif
