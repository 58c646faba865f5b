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
    const uint32_t most = LUM_IMAGE_PIXELS_MAX / (2u * EYE_COLUMNS);
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

lum_result lum_image_scale_init(lum_image_scale *out,
                                const lum_image_view *view)
{
    if (!is_possible(view)) {
        return LUM_E_VALUE;
    }
    const double left = (double)view->left_deg * RADIANS;
    const double top = (double)view->top_deg * RADIANS;
    const double column =
        (left - (double)view->right_deg * RADIANS) / view->columns;
    const double row = (top - (double)view->bottom_deg * RADIANS) / view->rows;
    *out = (lum_image_scale){.left = (float)(left + column / 2.0),
                             .top = (float)(top + row / 2.0),
                             .per_column = (float)(1.0 / column),
                             .per_row = (float)(1.0 / row),
                             .columns = (float)view->columns,
                             .rows = (float)view->rows,
                             .width = (int32_t)view->columns};
    return LUM_OK;
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
    LUM_BEST(pixels)(scale, x, y, z, n, out);
}
