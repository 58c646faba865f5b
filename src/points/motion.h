/* Columns of points by their times: when each was, and where it is if the
 * sensor moved. Internal to points, and for frame. */
#ifndef LUM_POINTS_MOTION_H
#define LUM_POINTS_MOTION_H

#include <stddef.h>
#include <stdint.h>

/* Points of the times from from_s to before to_s. */
typedef struct lum_motion {
    float from_s;
    float to_s;
    float matrix[12]; /* at from_s: 3 rows of 4 */
    float slope[12];  /* a second */
} lum_motion;

/* The columns of points. */
typedef struct lum_motion_points {
    const float *x;
    const float *y;
    const float *z;
    const float *time;
} lum_motion_points;

/* Pixels to seconds: those of a line that begins at from_ns and takes
 * period_ns, which is at most 10^8. */
void lum_motion_times(float *pixels, size_t n, int64_t from_ns,
                      int64_t period_ns);

/* How many of n times a motion is for. */
size_t lum_motion_count(const lum_motion *motion, const float *time, size_t n);

/* Move n points. out: x, y and z, apart from those of from. */
void lum_motion_move(const lum_motion *motion, const lum_motion_points *from,
                     size_t n, float *const out[3]);

#endif
