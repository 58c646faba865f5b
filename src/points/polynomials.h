/* What the directions of an eye's pixels are computed from: polynomials of raw
 * angles, with the scale of the angles in their coefficients, and the rotation
 * to the frame of the sensor. Internal to points. */
#ifndef LUM_POINTS_POLYNOMIALS_H
#define LUM_POINTS_POLYNOMIALS_H

#include "lum/points.h"

#define LUM_POLYNOMIAL_TERMS 4

/* Coefficients of the squared raw angle, the lowest power first. The sine lacks
 * the factor raw * scale, of which polynomials.c puts the scale elsewhere. */
typedef struct lum_axis {
    float sine[LUM_POLYNOMIAL_TERMS];
    float cosine[LUM_POLYNOMIAL_TERMS];
} lum_axis;

typedef struct lum_polynomials {
    lum_axis azimuth;
    lum_axis elevation;
    float sine_up; /* about the elevation's centre */
    float cosine_up;
    float sine_level;
    float cosine_level;
    float rotation[9]; /* row by row */
} lum_polynomials;

/* Angles up to 45 degrees either way: of an eye whose projector is narrow. */
void lum_polynomials_init(lum_polynomials *out, const lum_eye_projector *eye);

#endif
