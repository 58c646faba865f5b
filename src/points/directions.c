/* The directions of a line's pixels. */
#include "arithmetic.h"
#include "kernels.h"

#include <math.h>

void lum_plain_directions(const lum_polynomials *polynomials,
                          const lum_angle *angles, lum_direction *restrict out)
{
    const lum_polynomials own = *polynomials;
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        lum_direction *d = &out[i];
        lum_polynomials_compute(&own, (float)angles[i].azimuth,
                                (float)angles[i].elevation, &d->x, &d->y,
                                &d->z);
        d->pad = 0.0f;
    }
}

/* Angles beyond the reach of the polynomials. */
static void compute_wide(const lum_eye_projector *p, const lum_line *line,
                         lum_direction *out)
{
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        const double az = line->angles[i].azimuth * p->azimuth_rad;
        const double el = line->angles[i].elevation * p->elevation_rad;
        const double up = sin(el) * p->center_cos + cos(el) * p->center_sin;
        const double level = cos(el) * p->center_cos - sin(el) * p->center_sin;
        const double ahead = level * cos(az);
        const double left = level * sin(az);
        const float *m = p->rotation;
        out[i] = (lum_direction){
            (float)(m[0] * ahead + m[1] * left + m[2] * up),
            (float)(m[3] * ahead + m[4] * left + m[5] * up),
            (float)(m[6] * ahead + m[7] * left + m[8] * up), 0.0f};
    }
}

void lum_directions_compute(const lum_projector *projector,
                            const lum_line *line, lum_direction *out)
{
    const lum_eye_projector *p = &projector->eye[line->eye];
    if (p->narrow) {
        lum_polynomials polynomials;
        lum_polynomials_init(&polynomials, p);
        LUM_BEST(directions)(&polynomials, line->angles, out);
    } else {
        compute_wide(p, line, out);
    }
}
