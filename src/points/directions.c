#include "lum/points.h"

#include <math.h>

/* Taylor's series of sine and cosine about 0: over 45 degrees the error stays
 * below that of float. */
static inline float sine(float x)
{
    const float q = x * x;
    return x * (1.0f + q * (-1.0f / 6.0f + q * (1.0f / 120.0f +
                                                q * (-1.0f / 5040.0f +
                                                     q * (1.0f / 362880.0f)))));
}

static inline float cosine(float x)
{
    const float q = x * x;
    return 1.0f + q * (-1.0f / 2.0f +
                       q * (1.0f / 24.0f +
                            q * (-1.0f / 720.0f + q * (1.0f / 40320.0f))));
}

/* The sines and cosines of both angles, about their centres, to a vector. */
static inline lum_direction rotate(const lum_eye_projector *p, float sa,
                                   float ca, float se, float ce)
{
    const float up = se * p->center_cos + ce * p->center_sin;
    const float level = ce * p->center_cos - se * p->center_sin;
    const float ahead = level * ca;
    const float left = level * sa;
    const float *m = p->rotation;
    return (lum_direction){m[0] * ahead + m[1] * left + m[2] * up,
                           m[3] * ahead + m[4] * left + m[5] * up,
                           m[6] * ahead + m[7] * left + m[8] * up, 0.0f};
}

static void compute_narrow(const lum_eye_projector *p, const lum_line *line,
                           lum_direction *restrict out)
{
    const lum_eye_projector eye = *p;
    const float azimuth_rad = (float)eye.azimuth_rad;
    const float elevation_rad = (float)eye.elevation_rad;
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        const float az = (float)line->angles[i].azimuth * azimuth_rad;
        const float el = (float)line->angles[i].elevation * elevation_rad;
        out[i] = rotate(&eye, sine(az), cosine(az), sine(el), cosine(el));
    }
}

static void compute_wide(const lum_eye_projector *p, const lum_line *line,
                         lum_direction *out)
{
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        const double az = line->angles[i].azimuth * p->azimuth_rad;
        const double el = line->angles[i].elevation * p->elevation_rad;
        out[i] = rotate(p, (float)sin(az), (float)cos(az), (float)sin(el),
                        (float)cos(el));
    }
}

void lum_directions_compute(const lum_projector *projector,
                            const lum_line *line, lum_direction *out)
{
    const lum_eye_projector *p = &projector->eye[line->eye];
    if (p->narrow) {
        compute_narrow(p, line, out);
    } else {
        compute_wide(p, line, out);
    }
}
