/* How a pixel's raw angles become its direction (docs/protocol.md, section 7),
 * and a direction a pixel of a picture (lum/image.h). It is written once, for
 * one and for as many as a vector holds: a `number` is a float, or where
 * LUM_LANES is defined, a vector of floats. Every product and every sum is
 * rounded for itself, so all of them give the same bits. */
#ifndef LUM_POINTS_ARITHMETIC_H
#define LUM_POINTS_ARITHMETIC_H

#include "lum/image.h"
#include "polynomials.h"

#include <math.h>

#if defined(__GNUC__)
#define LUM_IN_LOOP static inline __attribute__((always_inline))
#else
#define LUM_IN_LOOP static inline
#endif

#if defined(LUM_LANES)
/* What a comparison gives: all bits of a number, or none. */
LUM_IN_LOOP whole lum_pick_whole(whole which, whole a, whole b)
{
    return (which & a) | (~which & b);
}

LUM_IN_LOOP number lum_pick(whole which, number a, number b)
{
    return (number)lum_pick_whole(which, (whole)a, (whole)b);
}

LUM_IN_LOOP whole lum_to_whole(number v)
{
    return __builtin_convertvector(v, whole);
}

LUM_IN_LOOP number lum_root(number v)
{
#if LUM_LANES == 16
    return _mm512_sqrt_ps(v);
#elif LUM_LANES == 8
    return _mm256_sqrt_ps(v);
#elif defined(LUM_HAS_NEON)
    return vsqrtq_f32(v);
#else
    return _mm_sqrt_ps(v);
#endif
}

#else
typedef float number;
typedef int32_t whole;

LUM_IN_LOOP whole lum_pick_whole(whole which, whole a, whole b)
{
    return which != 0 ? a : b;
}

LUM_IN_LOOP number lum_pick(whole which, number a, number b)
{
    return which != 0 ? a : b;
}

LUM_IN_LOOP whole lum_to_whole(number v)
{
    return (whole)v;
}

LUM_IN_LOOP number lum_root(number v)
{
    return sqrtf(v);
}
#endif

/* The sine, divided by the scale of the axis, and the cosine of raw angles.
 * Both halves of a polynomial are computed side by side: processors wait less,
 * which gains more than one product costs. */
LUM_IN_LOOP void lum_axis_compute(const lum_axis *axis, number raw,
                                  number *sine, number *cosine)
{
    const float *s = axis->sine;
    const float *c = axis->cosine;
    const number q = raw * raw;
    const number qq = q * q;
    *sine = raw * (s[0] + q * s[1] + qq * (s[2] + q * s[3]));
    *cosine = c[0] + q * c[1] + qq * (c[2] + q * c[3]);
}

LUM_IN_LOOP void lum_polynomials_compute(const lum_polynomials *t,
                                         number azimuth, number elevation,
                                         number *x, number *y, number *z)
{
    number sa, ca, se, ce;
    lum_axis_compute(&t->azimuth, azimuth, &sa, &ca);
    lum_axis_compute(&t->elevation, elevation, &se, &ce);
    const number up = se * t->sine_up + ce * t->cosine_up;
    const number level = se * t->sine_level + ce * t->cosine_level;
    const number ahead = level * ca;
    const number left = level * sa;
    const float *m = t->rotation;
    *x = m[0] * ahead + m[1] * left + m[2] * up;
    *y = m[3] * ahead + m[4] * left + m[5] * up;
    *z = m[6] * ahead + m[7] * left + m[8] * up;
}

/* The arc tangent of -1 to 1, within 3e-6. */
LUM_IN_LOOP number lum_arc(number a, number q)
{
    const number qq = q * q;
    return a * (0.99999483f + q * -0.33295711f +
                qq * (0.19534659f + q * -0.12044859f +
                      qq * (0.05658999f + q * -0.01313038f)));
}

/* The pixel of a point in a view of directions before the sensor, within 45
 * degrees of the level: -1 if it has none. Half the azimuth is found, which
 * both sides of the sensor reach without a case of their own. What lies up to
 * half a pixel before the first one is rounded into it. */
LUM_IN_LOOP whole lum_pixel_compute(const lum_image_scale *t, number x,
                                    number y, number z)
{
    const number level = lum_root(x * x + y * y);
    const number sum = level + x;
    const number part = 1.0f / (level * sum);
    const number half = y * level * part;
    const number slope = z * sum * part;
    const number steep = slope * slope;
    const number across =
        t->left - lum_arc(half, half * half) * (2.0f * t->per_column);
    const number down = t->top - lum_arc(slope, steep) * t->per_row;
    const whole is_inside = (x >= 0.0f) & (steep <= 1.0f) & (across >= -0.5f) &
                            (across < t->columns + 0.5f) & (down >= -0.5f) &
                            (down < t->rows + 0.5f);
    const number zero = {0};
    const whole row = lum_to_whole(lum_pick(is_inside, down, zero));
    const whole column = lum_to_whole(lum_pick(is_inside, across, zero));
    const whole none = {0};
    const whole last_row = none + (t->height - 1);
    const whole last_column = none + (t->width - 1);
    const whole pixel =
        lum_pick_whole(row < last_row, row, last_row) * t->width +
        lum_pick_whole(column < last_column, column, last_column);
    return lum_pick_whole(is_inside, pixel, none - 1);
}

#endif
