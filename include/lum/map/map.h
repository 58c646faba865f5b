/** @file
 * A map: points in the world, thinned to voxels, cubes of one size. Each voxel
 * keeps the point nearest to its centre, and the number of its points.
 *
 * @code
 * lum_map_options options = {
 *     .struct_size = sizeof options, .voxel = 0.1, .spool = "map.las"};
 * if (lum_map_new(&options, &map, &error) == 0) {
 *     while (lum_map_add(map, &points, &error) == 0 && more(&points)) {
 *     }
 *     while (lum_map_next(map, voxels, 1000, &count, &error) == 0 &&
 *            count > 0) {
 *     }
 * }
 * lum_map_free(map);
 * @endcode
 *
 * The world is cut into tiles of 256 x 256 x 65536 voxels. Tiles are tables in
 * memory. When these take more than lum_map_options.memory, the least recently
 * used go to a file on the disk, so memory grows only by about 150 bytes for
 * each tile with points. The result does not depend on this limit, on threads,
 * or on the order in which points come.
 *
 * Only one thread at a time may use a map; two maps share nothing. */
#ifndef LUM_MAP_MAP_H
#define LUM_MAP_MAP_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Smallest size of a voxel, metres. */
#define LUM_MAP_VOXEL_MIN 0.01
/** Largest, metres. */
#define LUM_MAP_VOXEL_MAX 100.0

/** Bytes that tables take by default. */
#define LUM_MAP_MEMORY ((uint64_t)768 << 20)
/** Smallest value of lum_map_options.memory. */
#define LUM_MAP_MEMORY_MIN ((uint64_t)1 << 20)

/** A map that is being made. */
typedef struct lum_map lum_map;

/** Options of a map. */
typedef struct lum_map_options {
    size_t struct_size; /**< sizeof(lum_map_options), set by the caller */
    double voxel;       /**< size of a voxel, metres: ::LUM_MAP_VOXEL_MIN to
                             ::LUM_MAP_VOXEL_MAX */
    uint64_t memory;    /**< bytes that tables may take, at least
                             ::LUM_MAP_MEMORY_MIN; 0: ::LUM_MAP_MEMORY. While a
                             tile goes to the disk, 2/3 of its table are needed
                             in addition */
    const char *spool;  /**< what does not fit goes to a temporary file in the
                             folder of this file. It has no name (on some file
                             systems, one for a moment), so nothing stays when
                             the process ends, even if killed. NULL: no file; a
                             map that does not fit fails. Copied */
    bool has_thread;    /**< a thread of its own fills the tables, while the
                             caller computes the next points */
} lum_map_options;

/** Points in the world. */
typedef struct lum_map_points {
    size_t struct_size;       /**< sizeof(lum_map_points), set by the caller */
    size_t count;             /**< how many */
    const float *x;           /**< metres, from origin */
    const float *y;           /**< likewise */
    const float *z;           /**< likewise */
    const float *pulse_width; /**< nanoseconds, 0 where unknown; NULL: all 0 */
    const float *time;        /**< seconds from time_ns on, below 4e9; beyond
                                   that, or NaN, it is 0; NULL: all 0 */
    int64_t time_ns;          /**< by any clock; at most 5e18 from 0 */
    double origin[3];         /**< where x, y and z are 0, metres */
} lum_map_points;

/** A voxel with points. It never grows, because it is used in arrays. */
typedef struct lum_map_voxel {
    double x;          /**< metres: of the point that is nearest to the voxel's
                            centre, to 1/65536 of the voxel's size */
    double y;          /**< likewise */
    double z;          /**< likewise */
    int64_t time_ns;   /**< of that point */
    float pulse_width; /**< of that point, to 0.01 ns, at most 655.35 */
    uint32_t count;    /**< points in the voxel; UINT32_MAX: that many or
                            more */
} lum_map_voxel;

/** What a map has taken and made. */
typedef struct lum_map_counters {
    size_t struct_size;    /**< sizeof(lum_map_counters), set by the caller */
    uint64_t points;       /**< that are in voxels */
    uint64_t not_finite;   /**< left out: a coordinate is no number */
    uint64_t out_of_range; /**< left out: farther than 2^23 tiles or, upwards,
                                2^15 tiles from 0 */
    uint64_t voxels_most;  /**< upper bound of the number of voxels: a tile's
                                parts on the disk may share some */
    uint64_t voxels_least; /**< lower bound of it; 0 before the first call of
                                lum_map_next() */
    uint64_t voxels;       /**< given out by lum_map_next() */
    uint64_t tiles;        /**< with points */
    uint64_t memory_most;  /**< bytes of tables at one time */
    uint64_t spooled;      /**< bytes that went to the disk */
} lum_map_counters;

/** Begin a map.
 * @param options copied.
 * @param out     written only on success; to be freed by lum_map_free().
 * @return 0, or -1 with the reason in error and in errno: EINVAL for an option
 *         that is not allowed, or a struct_size that is not set; ENOMEM. The
 *         spool's file is made when it is first needed. */
LUM_MUST_CHECK int lum_map_new(const lum_map_options *options, lum_map **out,
                               lum_error *error);

/** Add points; they are copied. Linear (docs/internals/performance.md has the
 * time of a point); about half of it in the map's own thread, if it has one.
 * @return 0, or -1 with the reason in error and in errno, also for points added
 *         earlier: EINVAL if struct_size is not set or voxels were given out
 *         already; ENOMEM, also if it does not fit and has no spool; ENOSPC and
 *         others of the disk. Then free the map. */
LUM_MUST_CHECK int lum_map_add(lum_map *map, const lum_map_points *points,
                               lum_error *error);

/** Give out the next voxels; the first call ends the adding; its room may be 0,
 * to count them first. Tiles come in rising order of x, then y, then z, and so
 * do the voxels of each. Of points that are equally near to the centre, the one
 * with the earliest time counts, then that with the lowest x, y, z, then with
 * the shortest pulse.
 * @param room  of voxels.
 * @param count how many came; fewer than room: there are no more.
 * @return 0, or -1 as lum_map_add(). */
LUM_MUST_CHECK int lum_map_next(lum_map *map, lum_map_voxel *voxels,
                                size_t room, size_t *count, lum_error *error);

/** Count what it has taken so far; waits for the map's thread.
 * @param out its struct_size is set by the caller.
 * @return 0, or -1 if that is not set, or points could not be added. */
LUM_MUST_CHECK int lum_map_count(lum_map *map, lum_map_counters *out);

/** Free it, and its space on the disk. NULL is allowed. Keeps errno. */
void lum_map_free(lum_map *map);

#ifdef __cplusplus
}
#endif

#endif
