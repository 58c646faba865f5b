/* What the directions of an eye's pixels are computed from: polynomials of raw
 * angles, with the scale of the angles in their coefficients, and the rotation
 * to the frame of the sensor. Internal to points. */
#ifndef LUM_POINTS_TURN_H
#define LUM_POINTS_TURN_H

#include "lum/points.h"

#define LUM_TURN_TERMS 4

/* Coefficients of the squared raw angle, the lowest power first. The sine lacks
 * the factor raw * scale, of which turn.c puts the scale elsewhere. */
typedef struct lum_axis {
    float sine[LUM_TURN_TERMS];
    float cosine[LUM_TURN_TERMS];
} lum_axis;

typedef struct lum_turn {
    lum_axis azimuth;
    lum_axis elevation;
    float sine_up; /* about the elevation's centre */
    float cosine_up;
    float sine_level;
    float cosine_level;
    float rotation[9]; /* row by row */
} lum_turn;

/* Angles up to 45 degrees either way: of an eye whose projector is narrow. */
void lum_turn_init(lum_turn *out, const lum_eye_projector *eye);

#endif
