/* The sensor's motion: the points of frames, moved by poses. */
#ifndef LUMDUMP_POSE_MOTION_H
#define LUMDUMP_POSE_MOTION_H

#include "options.h"

#include "lum/frame/move.h"

#include <stdbool.h>
#include <stddef.h>

struct motion;

/* The poses of --poses. *out: NULL if there are none. 0, or -1 with the reason
 * in error. */
int motion_new(const struct options *options, struct motion **out,
               lum_error *error);

/* NULL is allowed. */
void motion_free(struct motion *motion);

/* Another pass over the same frames begins. NULL is allowed. */
void motion_restart(struct motion *motion);

/* Whether the times are UTC; false for NULL. */
bool motion_is_utc(const struct motion *motion);

/* Where a frame's points are: a number for each, NaN where its time has no
 * pose. */
struct moved {
    const float *x;
    const float *y;
    const float *z;
    size_t without; /* how many are NaN */
};

/* Move a frame's points; out lives until the next call. 0, or -1 with the
 * reason in error. */
int motion_move(struct motion *motion, const lum_frame *frame,
                struct moved *out, lum_error *error);

/* Of all frames so far. */
const lum_move_counts *motion_counts(const struct motion *motion);

/* What is subtracted from the world's coordinates, where these are too large
 * for floats. False: they are not; then out stays. motion: NULL is allowed. */
bool motion_origin(const struct motion *motion, double out[3]);

/* How far, along an axis, a pose is from the origin, metres. */
double motion_farthest(const struct motion *motion);

/* Of its poses, for messages. */
const char *motion_name(const struct motion *motion);

/* At the end: -1 with the reason in error if frames had points, and none of
 * them has a pose. */
int motion_check(const struct motion *motion, lum_error *error);

/* What is to be said of the points without a pose, and where the poses have
 * their longest gap. False: nothing. */
bool motion_tell(const struct motion *motion, char *out, size_t room);

#endif
