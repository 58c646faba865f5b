/* Poses while they are made. */
#ifndef LUM_FRAME_POSES_INTERNAL_H
#define LUM_FRAME_POSES_INTERNAL_H

#include "lum/frame/poses.h"

#include <stddef.h>
#include <stdint.h>

/* Times, in nanoseconds, that can be added to each other. */
#define LUM_POSES_TIME_MAX_NS (INT64_MAX / 2)

struct lum_poses {
    int64_t *times;
    lum_pose *poses;
    size_t room;
    int64_t gap_ns;
    double jump_m;
    size_t recent; /* while they are made: as find_recent() found it last */
    lum_poses_info info; /* its count is that of the arrays */
};

/* Where a pose stands, for messages. */
typedef struct lum_poses_mark {
    const char *name; /* of the file; NULL: poses of arrays */
    size_t number;    /* of its line, from 1; of arrays its index */
} lum_poses_mark;

/* None yet. NULL with the reason in error. */
lum_poses *lum_poses_begin(const lum_poses_options *options, lum_error *error);

/* Add the next one; before is the mark of the one before. 0, or -1 with the
 * reason in error. */
int lum_poses_add(lum_poses *poses, int64_t time_ns, const lum_pose *pose,
                  const lum_poses_mark *mark, const lum_poses_mark *before,
                  lum_error *error);

/* No more will come: check them as a whole. 0, or -1 with the reason in error.
 * name: of the file, or NULL. */
int lum_poses_end(lum_poses *poses, const char *name, lum_error *error);

/* Numbers of a text, whatever the locale is. */
typedef struct lum_decimal {
    uint64_t digits;
    int exponent; /* of 10 */
    bool is_negative;
} lum_decimal;

/* False: the bytes are no number. */
bool lum_decimal_parse(const char *at, size_t len, lum_decimal *out);

/* To about the last bit; infinite if it is too large. */
double lum_decimal_double(const lum_decimal *d);

/* d x 10^exponent, rounded to a whole number. False: it is too large. */
bool lum_decimal_whole(const lum_decimal *d, int exponent, int64_t *out);

#endif
