/* The loops of motion.h, as the compiler makes vector code of them for the
 * processor of the file that includes this. */
#ifndef LUM_POINTS_MOTION_LOOPS_H
#define LUM_POINTS_MOTION_LOOPS_H

#include "arithmetic.h"
#include "lum/group.h"
#include "motion.h"

/* A whole product below 2^53, divided by 1000 and cut off, is exact so. */
LUM_IN_LOOP void lum_times_loop(float *restrict pixels, size_t n,
                                int64_t from_ns, int64_t period_ns)
{
    const double from = (double)from_ns;
    const double period = (double)period_ns;
    for (size_t i = 0; i < n; i++) {
        const int32_t in_line =
            (int32_t)((double)pixels[i] * period * (1.0 / LUM_LINE_PIXELS));
        pixels[i] = (float)((from + (double)in_line) * 1e-9);
    }
}

LUM_IN_LOOP size_t lum_count_loop(const lum_motion *motion, const float *time,
                                  size_t n)
{
    const float from_s = motion->from_s;
    const float to_s = motion->to_s;
    uint32_t count = 0;
    for (size_t i = 0; i < n; i++) {
        count += (time[i] >= from_s ? 1u : 0u) & (time[i] < to_s ? 1u : 0u);
    }
    return count;
}

LUM_IN_LOOP void lum_move_loop(const lum_motion *motion,
                               const lum_motion_points *from, size_t n,
                               float *restrict out, unsigned row)
{
    const float *x = from->x;
    const float *y = from->y;
    const float *z = from->z;
    const float *time = from->time;
    const float *m = motion->matrix + (size_t)4 * row;
    const float *s = motion->slope + (size_t)4 * row;
    const float from_s = motion->from_s;
    for (size_t i = 0; i < n; i++) {
        const float turned = m[0] * x[i] + m[1] * y[i] + m[2] * z[i];
        const float more = s[0] * x[i] + s[1] * y[i] + s[2] * z[i] + s[3];
        out[i] = turned + more * (time[i] - from_s) + m[3];
    }
}

#endif
