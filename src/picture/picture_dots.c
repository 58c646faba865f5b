/* The points that a picture keeps, in bounded memory. */
#include "picture_internal.h"

#include "base/grow.h"

#include <math.h>
#include <stdlib.h>

/* Every second one is enough from now on. */
static void thin(lum_dots *dots)
{
    for (size_t i = 0; i < dots->count / 2u; i++) {
        dots->at[i] = dots->at[2u * i];
    }
    dots->count /= 2u;
    dots->step *= 2u;
}

int lum_dots_add(lum_dots *dots, const lum_dot *dot)
{
    const uint64_t number = dots->all++;
    if (number % dots->step != 0 || !isfinite(dot->x) || !isfinite(dot->y) ||
        !isfinite(dot->z) || !isfinite(dot->value)) {
        return 0;
    }
    lum_dot *at = lum_grown(dots->at, dots->count, 1, sizeof *at, &dots->room);
    if (at == NULL) {
        return -1;
    }
    dots->at = at;
    at[dots->count++] = *dot;
    if (dots->count == LUM_DOTS_MAX) {
        thin(dots);
    }
    return 0;
}

void lum_dots_move(lum_dots *dots, const lum_pose *pose)
{
    for (size_t i = 0; i < dots->count; i++) {
        lum_dot *dot = &dots->at[i];
        double at[3] = {(double)dot->x, (double)dot->y, (double)dot->z};
        lum_pose_apply(pose, at, at);
        dot->x = (float)at[0];
        dot->y = (float)at[1];
        dot->z = (float)at[2];
    }
}

void lum_dots_free(lum_dots *dots)
{
    free(dots->at);
    dots->at = NULL;
}

float lum_dot_value(const lum_dot *dot)
{
    return dot->value;
}

float lum_dot_distance(const lum_dot *dot)
{
    return hypotf(dot->x, dot->y);
}

static int compare(const void *a, const void *b)
{
    const float *x = a;
    const float *y = b;
    return (*x > *y) - (*x < *y);
}

void lum_dots_limits(const lum_dots *dots, lum_dot_number *number,
                     const double shares[2], float out[2])
{
    const size_t stride = dots->count / LUM_DOTS_SAMPLE + 1u;
    const size_t n = (dots->count + stride - 1u) / stride;
    float *sample = malloc((n + 1u) * sizeof *sample);
    out[0] = 0.0f;
    out[1] = 0.0f;
    if (sample != NULL && n > 0) {
        for (size_t i = 0; i < n; i++) {
            sample[i] = number(&dots->at[i * stride]);
        }
        qsort(sample, n, sizeof *sample, compare);
        for (int i = 0; i < 2; i++) {
            out[i] = sample[(size_t)(shares[i] * (double)(n - 1u) + 0.5)];
        }
    }
    free(sample);
}
