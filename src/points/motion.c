#include "motion_loops.h"

#include "kernels.h"

void lum_plain_times(float *pixels, size_t n, int64_t from_ns,
                     int64_t period_ns)
{
    lum_times_loop(pixels, n, from_ns, period_ns);
}

size_t lum_plain_count(const lum_motion *motion, const float *time, size_t n)
{
    return lum_count_loop(motion, time, n);
}

void lum_plain_move(const lum_motion *motion, const lum_motion_points *from,
                    size_t n, float *const out[3])
{
    for (unsigned row = 0; row < 3u; row++) {
        lum_move_loop(motion, from, n, out[row], row);
    }
}

void lum_motion_times(float *pixels, size_t n, int64_t from_ns,
                      int64_t period_ns)
{
    LUM_BEST(times)(pixels, n, from_ns, period_ns);
}

size_t lum_motion_count(const lum_motion *motion, const float *time, size_t n)
{
    return LUM_BEST(count)(motion, time, n);
}

void lum_motion_move(const lum_motion *motion, const lum_motion_points *from,
                     size_t n, float *const out[3])
{
    LUM_BEST(move)(motion, from, n, out);
}
