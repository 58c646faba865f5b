#include "polynomials.h"

#include <float.h>

/* The polynomials in x * x that come nearest to sin(x) / x and cos(x) where x
 * is from -45 to 45 degrees: x times the first is off by at most 1.3e-9, the
 * second by 2.8e-8. One term less would be off by 5.7e-7 and 1e-5.
 * What comes of it at all angles is held by tests/unit/test_projector.c. */
static const double sine[LUM_POLYNOMIAL_TERMS] = {
    0.9999999861793886, -0.166666367543469, 0.008331584607840248,
    -0.00019462117113966087};
static const double cosine[LUM_POLYNOMIAL_TERMS] = {
    0.999999972423323, -0.49999856695848893, 0.04165502688425432,
    -0.0013585908510145017};

/* Numbers below the least normal one make some processors a hundred times
 * slower. A coefficient can only be so small where its term does not matter. */
static float normal(double value)
{
    return value < FLT_MIN && value > -FLT_MIN ? 0.0f : (float)value;
}

/* scale: radians of a raw number. */
static void set_axis(lum_axis *out, double scale)
{
    double power = 1.0;
    for (unsigned i = 0; i < LUM_POLYNOMIAL_TERMS; i++) {
        out->sine[i] = normal(sine[i] * power);
        out->cosine[i] = normal(cosine[i] * power);
        power *= scale * scale;
    }
}

/* Products with a sine bring the scale that the sine lacks. */
void lum_polynomials_init(lum_polynomials *out, const lum_eye_projector *eye)
{
    const double azimuth = eye->azimuth_rad;
    const double elevation = eye->elevation_rad;
    set_axis(&out->azimuth, azimuth);
    set_axis(&out->elevation, elevation);
    out->sine_up = normal(elevation * eye->center_cos);
    out->cosine_up = normal(eye->center_sin);
    out->sine_level = normal(-elevation * eye->center_sin);
    out->cosine_level = normal(eye->center_cos);
    for (unsigned i = 0; i < 9; i++) {
        out->rotation[i] =
            normal(i % 3 == 1 ? azimuth * eye->rotation[i] : eye->rotation[i]);
    }
}
