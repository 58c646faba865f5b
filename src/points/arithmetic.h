/* How a pixel's raw angles become its direction (docs/protocol.md, section 7),
 * and a direction a pixel of a picture (lum/image.h). It is written once, for
 * one and for as many as a vector holds: a `number` is a float, or where
 * LUM_LANES is defined, a vector of floats. Every product and every sum is
 * rounded for itself, so all of them give the same bits. */
#ifndef LUM_POINTS_ARITHMETIC_H
#define LUM_POINTS_ARITHMETIC_H

#include "lum/image.h"
#include "polynomials.h"

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

LUM_IN_LOOP number lum_absolute(number v)
{
    return lum_pick(v < 0.0f, -v, v);
}

/* The larger one, and the share of it that the smaller one is: NaN if both are
 * 0. */
LUM_IN_LOOP number lum_share(number a, number b, number *larger)
{
    *larger = lum_pick(a > b, a, b);
    return lum_pick(a > b, b, a) / *larger;
}

/* The arc tangent of 0 to 1, within 3e-6. */
LUM_IN_LOOP number lum_arc(number a)
{
    const number q = a * a;
    const number qq = q * q;
    return a * (0.99999483f + q * -0.33295711f +
                qq * (0.19534659f + q * -0.12044859f +
                      qq * (0.05658999f + q * -0.01313038f)));
}

/* The square root of 1 plus 0 to 1, within 2e-6 of it. */
LUM_IN_LOOP number lum_root(number q)
{
    const number qq = q * q;
    return 1.00000164f + q * 0.49988075f +
           qq * (-0.12353492f + q * 0.05554068f +
                 qq * (-0.02255685f + q * 0.00488321f));
}

/* Radians left of forward. */
LUM_IN_LOOP number lum_azimuth(number share, number ahead, number left)
{
    const number arc = lum_arc(share);
    const number steep = lum_pick(lum_absolute(left) > lum_absolute(ahead),
                                  1.57079633f - arc, arc);
    const number half = lum_pick(ahead < 0.0f, 3.14159265f - steep, steep);
    return lum_pick(left < 0.0f, -half, half);
}

/* Radians above the level. */
LUM_IN_LOOP number lum_elevation(number level, number up)
{
    number larger;
    const number height = lum_absolute(up);
    const number arc = lum_arc(lum_share(height, level, &larger));
    const number steep = lum_pick(height > level, 1.57079633f - arc, arc);
    return lum_pick(up < 0.0f, -steep, steep);
}

/* Whole numbers from 0 up to below an end; 0 where it is not inside. */
LUM_IN_LOOP whole lum_place(whole is_inside, number at, float end)
{
    const number none = {0};
    const number last = none + (end - 1.0f);
    const number from = lum_pick(is_inside & (at > 0.0f), at, none);
    return lum_to_whole(lum_pick(from < last, from, last));
}

/* The pixel of a point: -1 if it has none. The scale begins half a pixel before
 * the edges, and ends as much behind them. */
LUM_IN_LOOP whole lum_pixel_compute(const lum_image_scale *t, number x,
                                    number y, number z)
{
    const float turn = 6.28318531f;
    number larger;
    const number share = lum_share(lum_absolute(y), lum_absolute(x), &larger);
    const number level = larger * lum_root(share * share);
    const number turned = t->left - lum_azimuth(share, x, y);
    const number below = lum_pick(turned < turn, turned, turned - turn);
    const number right = lum_pick(turned < 0.0f, turned + turn, below);
    const number across = right * t->per_column - 0.5f;
    const number down = (t->top - lum_elevation(level, z)) * t->per_row - 0.5f;
    const whole is_inside = (across < t->columns + 0.5f) & (down >= -0.5f) &
                            (down < t->rows + 0.5f);
    const whole row = lum_place(is_inside, down, t->rows);
    const whole column = lum_place(is_inside, across, t->columns);
    const whole none = {0};
    return lum_pick_whole(is_inside, row * t->width + column, none - 1);
}

#endif
