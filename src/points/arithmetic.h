/* How a pixel's raw angles become its direction (docs/protocol.md, section 7).
 * It is written once, for one pixel and for as many as a vector holds: a
 * `number` is a float, or where LUM_LANES is defined, a vector of floats. Every
 * product and every sum is rounded for itself, so all of them give the same
 * bits. */
#ifndef LUM_POINTS_ARITHMETIC_H
#define LUM_POINTS_ARITHMETIC_H

#include "polynomials.h"

#if !defined(LUM_LANES)
typedef float number;
#endif

#if defined(__GNUC__)
#define LUM_IN_LOOP static inline __attribute__((always_inline))
#else
#define LUM_IN_LOOP static inline
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

#endif
