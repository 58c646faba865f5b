#include "picture_internal.h"

#include <math.h>
#include <stdio.h>

const lum_rgb lum_paper = {24, 26, 32};
const lum_rgb lum_panel = {12, 13, 16};
const lum_rgb lum_ink = {230, 232, 236};
const lum_rgb lum_dim = {160, 165, 175};
const lum_rgb lum_grid = {62, 66, 76};

static float place(lum_depth depth, float range)
{
    return logf(range / depth.near_m) / logf(depth.far_m / depth.near_m);
}

lum_rgb lum_depth_colour(lum_depth depth, float range)
{
    return lum_colour(range > depth.near_m ? place(depth, range) : 0.0f);
}

float lum_nice_step(float span, int n)
{
    const float rough = span / (float)n;
    const float ten = powf(10.0f, floorf(log10f(rough)));
    const float times = rough / ten;
    return ten * (times < 1.5f   ? 1.0f
                  : times < 3.5f ? 2.0f
                  : times < 7.5f ? 5.0f
                                 : 10.0f);
}

static void draw_number(lum_canvas *canvas, lum_box box, lum_depth depth,
                        float range)
{
    const lum_style style = {18.0f, LUM_ALIGN_LEFT, lum_ink, lum_paper, 0.0f};
    char text[32];
    const float part = place(depth, range);
    if (part < -0.01f || part > 1.01f) {
        return;
    }
    const int y = box.y + (int)((1.0f - part) * (float)(box.height - 1) + 0.5f);
    const lum_box tick = {box.x + box.width, y, 8, 1};
    lum_canvas_fill(canvas, tick, lum_ink);
    (void)snprintf(text, sizeof text, "%g m", (double)range);
    lum_canvas_text(canvas, &style, tick.x + 14, y, text);
}

/* 1, 2 and 5 times a power of ten; each digit if these are too few. */
static bool has_number(lum_depth depth, int digit)
{
    return depth.far_m < 6.0f * depth.near_m || digit == 1 || digit == 2 ||
           digit == 5;
}

void lum_draw_scale(lum_canvas *canvas, lum_box box, lum_depth depth)
{
    for (int y = 0; y < box.height; y++) {
        const lum_box row = {box.x, box.y + y, box.width, 1};
        const float part = 1.0f - (float)y / (float)(box.height - 1);
        lum_canvas_fill(canvas, row, lum_colour(part));
    }
    float ten = 0.1f;
    while (ten < 1e6f) {
        for (int digit = 1; digit <= 9; digit++) {
            if (has_number(depth, digit)) {
                draw_number(canvas, box, depth, ten * (float)digit);
            }
        }
        ten *= 10.0f;
    }
}
