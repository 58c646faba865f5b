#include "face.h"

#include "random.h"
#include "rotation.h"

#include <math.h>

/* Stream of random numbers. */
#define STREAM_FACE 4u

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Lengths are spread evenly by their logarithm, directions by their angle. */
static lum_face_wave draw_wave(lum_random *random)
{
    const double ratio = log((double)LUM_FACE_WAVE_MAX_M / LUM_FACE_WAVE_MIN_M);
    const double length = (double)LUM_FACE_WAVE_MIN_M *
                          exp(ratio * (double)lum_random_unit(random));
    const double heading = LUM_FULL_TURN * (double)lum_random_unit(random);
    const double phase = LUM_FULL_TURN * (double)lum_random_unit(random);
    return (lum_face_wave){
        .along_per_m = (float)(LUM_FULL_TURN / length * cos(heading)),
        .up_per_m = (float)(LUM_FULL_TURN / length * sin(heading)),
        .phase = (float)phase};
}

void lum_face_roughen(lum_face *face, uint64_t seed, unsigned number,
                      double rms_m, double bias_m)
{
    lum_random random;
    lum_random_init(&random, seed, ((uint64_t)number << 8) | STREAM_FACE);
    face->bias_m = (float)bias_m * lum_random_normal(&random);
    face->height_m = (float)(rms_m * sqrt(2.0 / LUM_FACE_WAVES));
    for (unsigned i = 0; i < LUM_FACE_WAVES; i++) {
        face->waves[i] = draw_wave(&random);
    }
}

float lum_face_height(const lum_face *face, float a, float b)
{
    double sum = 0.0;
    if (face->height_m <= 0.0f) {
        return 0.0f;
    }
    for (unsigned i = 0; i < LUM_FACE_WAVES; i++) {
        const lum_face_wave *w = &face->waves[i];
        sum += sin((double)(a * w->along_per_m + b * w->up_per_m + w->phase));
    }
    return face->height_m * (float)sum;
}

/* Waves are low and long: their height where the beam meets the plane is that
 * where it meets the surface. */
bool lum_face_cast(const lum_face *face, const float middle[3],
                   const float d[3], float *range, float *cosine)
{
    const float along = dot(face->normal, d);
    if (fabsf(along) < 1e-6f) {
        return false;
    }
    const float away = dot(face->normal, middle);
    const float flat = away / along;
    const float at[3] = {flat * d[0] - middle[0], flat * d[1] - middle[1],
                         flat * d[2] - middle[2]};
    const float a = dot(face->along, at);
    const float b = dot(face->up, at);
    if (flat <= 0.0f || fabsf(a) > face->half[0] || fabsf(b) > face->half[1]) {
        return false;
    }
    *range = (away + lum_face_height(face, a, b)) / along;
    *cosine = fabsf(along);
    return true;
}
