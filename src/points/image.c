#include "lum/image.h"

#include "arithmetic.h"
#include "kernels.h"

#include <math.h>

#define RADIANS (3.14159265358979323846 / 180.0)

#define EYE_COLUMNS 800u
#define ROWS_STEP   64u

void lum_image_view_default(lum_image_view *out, unsigned eyes, uint32_t lines)
{
    const bool is_one = eyes == LUM_IMAGE_BLUE || eyes == LUM_IMAGE_GREEN;
    const uint32_t columns = is_one ? EYE_COLUMNS : 2u * EYE_COLUMNS;
    const uint32_t most =
        LUM_IMAGE_PIXELS_MAX / (2u * EYE_COLUMNS * ROWS_STEP) * ROWS_STEP;
    const uint32_t known = lines < 1u ? 1u : lines < most ? lines : most;
    *out = (lum_image_view){
        .left_deg = eyes == LUM_IMAGE_BLUE ? 0.0f : 60.0f,
        .right_deg = eyes == LUM_IMAGE_GREEN ? 0.0f : -60.0f,
        .top_deg = 3.0f,
        .bottom_deg = -17.0f,
        .rows = (known + ROWS_STEP - 1u) / ROWS_STEP * ROWS_STEP,
        .columns = columns};
}

/* Where a number is NaN, every comparison is false. */
static bool is_possible(const lum_image_view *v)
{
    const float width = v->left_deg - v->right_deg;
    return v->left_deg <= 360.0f && v->right_deg >= -360.0f && width > 0.0f &&
           width <= 360.0f && v->top_deg <= 90.0f && v->bottom_deg >= -90.0f &&
           v->top_deg > v->bottom_deg && v->rows > 0 && v->columns > 0 &&
           (uint64_t)v->rows * v->columns <= LUM_IMAGE_PIXELS_MAX;
}

/* Whether no pixel and no half one beyond it reaches behind the sensor or above
 * 45 degrees. */
static bool looks_ahead(const lum_image_view *v)
{
    const float column = (v->left_deg - v->right_deg) / (float)v->columns;
    const float row = (v->top_deg - v->bottom_deg) / (float)v->rows;
    return v->left_deg + column < 90.0f && v->right_deg - column > -90.0f &&
           v->top_deg + row < 45.0f && v->bottom_deg - row > -45.0f;
}

lum_result lum_image_scale_init(lum_image_scale *out,
                                const lum_image_view *view)
{
    if (!is_possible(view)) {
        return LUM_E_VALUE;
    }
    const double left = (double)view->left_deg * RADIANS;
    const double right = (double)view->right_deg * RADIANS;
    const double top = (double)view->top_deg * RADIANS;
    const double bottom = (double)view->bottom_deg * RADIANS;
    const double per_column = view->columns / (left - right);
    const double per_row = view->rows / (top - bottom);
    *out = (lum_image_scale){.left = (float)(left * per_column),
                             .top = (float)(top * per_row),
                             .per_column = (float)per_column,
                             .per_row = (float)per_row,
                             .columns = (float)view->columns,
                             .rows = (float)view->rows,
                             .width = (int32_t)view->columns,
                             .height = (int32_t)view->rows,
                             .is_before = looks_ahead(view)};
    return LUM_OK;
}

/* A place from 0 to below an end, which half a pixel before and behind belongs
 * to; -1: outside. */
static int32_t step_of(float at, float size, int32_t end)
{
    if (!(at >= -0.5f && at < size + 0.5f)) {
        return -1;
    }
    const int32_t place = (int32_t)at;
    return place < end ? place : end - 1;
}

/* In a view that reaches around the sensor. */
static uint32_t pixel_around(const lum_image_scale *t, float x, float y,
                             float z)
{
    const float turn = t->per_column * 360.0f * (float)RADIANS;
    const float level = hypotf(x, y);
    float across = t->left - atan2f(y, x) * t->per_column;
    const float end = fmaxf(t->columns, turn - 1.0f) + 0.5f;
    across -= across >= end ? turn : 0.0f; /* also just before the left edge */
    across += across < -0.5f ? turn : 0.0f;
    const float down = t->top - atan2f(z, level) * t->per_row;
    const int32_t column = step_of(across, t->columns, t->width);
    const int32_t row = step_of(down, t->rows, t->height);
    return level > 0.0f && column >= 0 && row >= 0
               ? (uint32_t)(row * t->width + column)
               : LUM_IMAGE_NONE;
}

void lum_plain_pixels(const lum_image_scale *scale, const float *x,
                      const float *y, const float *z, size_t n, uint32_t *out)
{
    const lum_image_scale own = *scale; /* which out cannot be part of */
    for (size_t i = 0; i < n; i++) {
        out[i] = (uint32_t)lum_pixel_compute(&own, x[i], y[i], z[i]);
    }
}

void lum_image_pixels(const lum_image_scale *scale, const float *x,
                      const float *y, const float *z, size_t n, uint32_t *out)
{
    if (scale->is_before) {
        LUM_BEST(pixels)(scale, x, y, z, n, out);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        out[i] = pixel_around(scale, x[i], y[i], z[i]);
    }
}
