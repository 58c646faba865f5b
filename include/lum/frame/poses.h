/** @file
 * Poses over time: where a sensor was, from a file or from arrays
 * (docs/reader.md, "Motion").
 *
 * Files are text in UTF-8 or ASCII; numbers are separated by blanks, tabs,
 * commas or semicolons, and lines that begin with # are comments. The first
 * line with numbers shows the format:
 *
 * | format | a line |
 * |---|---|
 * | TUM | t x y z qx qy qz qw |
 * | KITTI | a matrix of 3 rows of 4; a second file has the times |
 * | CSV | as its first line names it: t, time or timestamp (seconds, or with
 *   _s, _ms, _us or _ns at the end), x, y, z, qx, qy, qz, qw; others are
 *   ignored |
 *
 * Times are seconds by the sensor's clock or since 1970 UTC, and rise. They are
 * kept in nanoseconds, as exactly as the text has them. Positions are metres, a
 * quaternion turns the sensor's directions into the world's.
 *
 * Poses do not change once they are made: any number of threads can read them.
 */
#ifndef LUM_FRAME_POSES_H
#define LUM_FRAME_POSES_H

#include "lum/base/error.h"
#include "lum/pose.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The clock of the times. */
typedef enum lum_poses_clock {
    LUM_POSES_BY_SIZE, /**< in options: UTC if the first time is above
                            LUM_POSES_UTC_NS, else the sensor's */
    LUM_POSES_SENSOR,  /**< the sensor's clock, from 0 */
    LUM_POSES_UTC      /**< since 1970 UTC */
} lum_poses_clock;

/** Times above this are UTC, if their clock is not given: 10^8 s, that is 1973,
 * or three years after a sensor was switched on. */
#define LUM_POSES_UTC_NS INT64_C(100000000000000000)

/** The usual lum_poses_options.gap_ns. */
#define LUM_POSES_GAP_NS INT64_C(1000000000)

/** The usual lum_poses_options.jump_m. */
#define LUM_POSES_JUMP_M 100.0

/** A quaternion, or the rows of a rotation, may be this far from length 1; they
 * are then normalised. */
#define LUM_POSES_UNIT_ERROR 0.01

/** How poses are taken. All bytes 0 except struct_size are the defaults. */
typedef struct lum_poses_options {
    size_t struct_size;    /**< sizeof(lum_poses_options) */
    lum_poses_clock clock; /**< of the times */
    int64_t gap_ns; /**< between two poses that are farther apart, times have no
                         pose; above 0, or 0: LUM_POSES_GAP_NS */
    double jump_m;  /**< largest distance of two poses that follow each other
                         without a gap, or lie within 0.1 s; above 0, or 0:
                         LUM_POSES_JUMP_M */
} lum_poses_options;

/** Poses. */
typedef struct lum_poses lum_poses;

/** Read a file.
 * @param path       its name, or "-" for standard input.
 * @param times_path of KITTI: a file with a time a line; else NULL.
 * @param options    NULL: the defaults.
 * @param out        written only on success; to be freed by lum_poses_free().
 * @return 0, or -1 with the reason in error, which names the line and the
 *         fix: the file cannot be read; it has no poses; a line has another
 *         count of numbers than the first one, or other text; a time is not
 *         after that of the line above; times are not in seconds; a
 *         quaternion's length is not 1; poses are farther apart than jump_m;
 *         all are farther apart in time than gap_ns; KITTI has no times, or too
 *         few or too many; an option is invalid (errno is EINVAL). */
LUM_MUST_CHECK int lum_poses_read(const char *path, const char *times_path,
                                  const lum_poses_options *options,
                                  lum_poses **out, lum_error *error);

/** The text of a file of poses. It never grows. */
typedef struct lum_poses_text {
    const char *name; /**< for messages */
    const char *at;   /**< any bytes, also 0; not kept */
    size_t len;       /**< how many */
} lum_poses_text;

/** As lum_poses_read(), for texts in memory. times: NULL, or those of KITTI. */
LUM_MUST_CHECK int lum_poses_parse(const lum_poses_text *text,
                                   const lum_poses_text *times,
                                   const lum_poses_options *options,
                                   lum_poses **out, lum_error *error);

/** Make poses of arrays.
 * @param times_ns count times, rising; copied.
 * @param poses    count poses; copied, and their quaternions normalised.
 * @param count    at least 1.
 * @return as lum_poses_read(); the message counts the poses from 0. */
LUM_MUST_CHECK int lum_poses_new(const int64_t *times_ns, const lum_pose *poses,
                                 size_t count, const lum_poses_options *options,
                                 lum_poses **out, lum_error *error);

/** Free poses; NULL is allowed. */
void lum_poses_free(lum_poses *poses);

/** A summary of poses. */
typedef struct lum_poses_info {
    size_t struct_size;    /**< sizeof(lum_poses_info), set by the caller */
    size_t count;          /**< at least 1 */
    lum_poses_clock clock; /**< LUM_POSES_SENSOR or LUM_POSES_UTC */
    int64_t first_ns;      /**< the time of the first */
    int64_t last_ns;       /**< of the last */
    size_t gaps;           /**< pairs that are farther apart than gap_ns */
    int64_t gap_from_ns;   /**< the longest of these; 0: there is none */
    int64_t gap_to_ns;     /**< its end */
    double min[3];         /**< the box of the positions, metres */
    double max[3];         /**< its other corner */
} lum_poses_info;

/** Read the summary.
 * @param out as for lum_frame_get_info().
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_poses_get_info(const lum_poses *poses, lum_poses_info *out);

/** The i-th pose and its time; i is below lum_poses_info.count, and out or
 * time_ns may be NULL. */
void lum_poses_get(const lum_poses *poses, size_t i, int64_t *time_ns,
                   lum_pose *out);

/** World coordinates beyond this, in metres, lose more than half a millimetre
 * as floats. */
#define LUM_POSES_FAR_M 5000.0

/** What to subtract from the world's coordinates so that floats hold them
 * (lum_move_options.origin).
 * @param out the middle of the positions' box in whole kilometres, halves away
 *            from 0; 0, 0, 0 if no position is beyond LUM_POSES_FAR_M.
 * @return whether one is. */
bool lum_poses_origin(const lum_poses *poses, double out[3]);

/** A time this near to a pose's time has that pose, even outside of all: texts
 * round their times to a microsecond. */
#define LUM_POSES_SLACK_NS INT64_C(1000)

/** Whether a time has a pose. */
typedef enum lum_poses_place {
    LUM_POSES_INSIDE, /**< at a pose, or between two */
    LUM_POSES_BEFORE, /**< before the first */
    LUM_POSES_AFTER,  /**< after the last */
    LUM_POSES_IN_GAP  /**< between two that are farther apart than gap_ns */
} lum_poses_place;

/** The pose of a time, on the screw between its neighbours
 * (lum_pose_between()).
 * @param near 0 at first; then the place of the last look-up, where this one
 *             begins: times near the last one take constant time, others a
 *             binary search. NULL: always search.
 * @param out  the pose; for a time outside, the nearest pose, which the caller
 *             may use or refuse. */
lum_poses_place lum_poses_at(const lum_poses *poses, int64_t time_ns,
                             size_t *near, lum_pose *out);

/** The first pose whose time is not before a time; count if there is none.
 * near: as for lum_poses_at(). */
size_t lum_poses_find(const lum_poses *poses, int64_t time_ns, size_t *near);

/** If no time of a capture has a pose, say why: both spans, and the unit that
 * would fit if the times' unit is wrong.
 * @param name     of the poses, for the message.
 * @param from_ns  the capture's first time, by the poses' clock.
 * @param to_ns    its last.
 * @return 0 if the spans overlap, else -1 with the message in error. */
int lum_poses_check_span(const lum_poses *poses, const char *name,
                         int64_t from_ns, int64_t to_ns, lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
