/* The colours of a picture, and the scale that explains them. */
#include "picture_internal.h"

#include <math.h>
#include <stdio.h>

#define LABELS 16 /* of a legend */

const lum_rgb lum_paper = {24, 26, 32};
const lum_rgb lum_panel = {12, 13, 16};
const lum_rgb lum_ink = {230, 232, 236};
const lum_rgb lum_dim = {160, 165, 175};
const lum_rgb lum_grid = {62, 66, 76};

int lum_pixels(const lum_drawing *d, float n)
{
    const float pixels = n * d->unit + 0.5f;
    return pixels >= 1.0f ? (int)pixels : 1;
}

void lum_write(const lum_drawing *d, float size, lum_align align, int x, int y,
               float cover, const char *text)
{
    const lum_style style = {size * d->unit, align, lum_ink, lum_panel, cover};
    lum_canvas_text(d->canvas, &style, x, y, text);
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

lum_scale lum_scale_of(lum_picture_colour colour, const lum_dots *dots)
{
    static const double shares[2] = {0.02, 0.98};
    lum_scale s = {colour, 0.0f, 1.0f};
    float limits[2];
    lum_dots_limits(dots, lum_dot_value, shares, limits);
    if (colour == LUM_PICTURE_RANGE) {
        s.low = fmaxf(limits[0], 0.5f);
        s.high = fmaxf(limits[1], 2.0f * s.low);
    } else if (colour != LUM_PICTURE_LABEL) {
        s.low = limits[0];
        s.high = fmaxf(limits[1], s.low + 1.0f);
    }
    return s;
}

/* Where a value is between the ends. */
static float place(const lum_scale *s, float value)
{
    if (s->colour != LUM_PICTURE_RANGE) {
        return (value - s->low) / (s->high - s->low);
    }
    return value > 0.0f ? logf(value / s->low) / logf(s->high / s->low) : 0.0f;
}

lum_rgb lum_scale_colour(const lum_scale *s, float value)
{
    return s->colour == LUM_PICTURE_LABEL ? lum_label_colour(value)
                                          : lum_colour(place(s, value));
}

static const char *unit_of(const lum_scale *s)
{
    return s->colour == LUM_PICTURE_PULSE_WIDTH ? "ns" : "m";
}

static void draw_number(const lum_drawing *d, lum_box box, float value,
                        const char *sign)
{
    char text[32];
    const float up = place(&d->scale, value) * (float)(box.height - 1);
    const int y = box.y + box.height - 1 - (int)(up + 0.5f);
    const lum_box tick = {box.x + box.width, y, lum_pixels(d, 8.0f), 1};
    lum_canvas_fill(d->canvas, tick, lum_ink);
    (void)snprintf(text, sizeof text, "%s%.3g %s", sign, (double)value,
                   unit_of(&d->scale));
    lum_write(d, 18.0f, LUM_ALIGN_LEFT, tick.x + lum_pixels(d, 14.0f), y, 0.0f,
              text);
}

/* Not in the way of the ends' numbers. */
static void draw_between(const lum_drawing *d, lum_box box, float value)
{
    const float apart = 26.0f * d->unit / (float)box.height;
    const float part = place(&d->scale, value);
    if (part > apart && part < 1.0f - apart) {
        draw_number(d, box, value, "");
    }
}

/* 1, 2 and 5 times a power of ten; each digit if these are too few. */
static void number_ranges(const lum_drawing *d, lum_box box)
{
    const bool all = d->scale.high < 6.0f * d->scale.low;
    float ten = 0.1f;
    while (ten < 1e6f) {
        for (int digit = 1; digit <= 9; digit++) {
            if (all || digit == 1 || digit == 2 || digit == 5) {
                draw_between(d, box, ten * (float)digit);
            }
        }
        ten *= 10.0f;
    }
}

static void number_steps(const lum_drawing *d, lum_box box)
{
    const float step = lum_nice_step(d->scale.high - d->scale.low, 6);
    const int first = (int)ceilf(d->scale.low / step);
    for (int i = 0; (float)(first + i) * step < d->scale.high; i++) {
        draw_between(d, box, (float)(first + i) * step);
    }
}

/* The first labels, by their numbers. */
static int find_labels(const lum_dots *dots, float out[LABELS])
{
    int n = 0;
    float last = -INFINITY;
    for (; n < LABELS; n++) {
        float next = INFINITY;
        for (size_t i = 0; i < dots->count; i++) {
            const float label = dots->at[i].value;
            next = label > last && label < next ? label : next;
        }
        if (!isfinite(next)) {
            break;
        }
        out[n] = next;
        last = next;
    }
    return n;
}

static void draw_labels(const lum_drawing *d, lum_box box)
{
    float labels[LABELS];
    const int n = find_labels(d->dots, labels);
    const int line = lum_pixels(d, 28.0f);
    for (int i = 0; i < n && (i + 1) * line <= box.height; i++) {
        const lum_box patch = {box.x, box.y + i * line, box.width,
                               lum_pixels(d, 18.0f)};
        char text[32];
        (void)snprintf(text, sizeof text, "%.0f", (double)labels[i]);
        lum_canvas_fill(d->canvas, patch, lum_label_colour(labels[i]));
        lum_write(d, 18.0f, LUM_ALIGN_LEFT,
                  patch.x + patch.width + lum_pixels(d, 14.0f),
                  patch.y + patch.height / 2, 0.0f, text);
    }
}

void lum_draw_scale(const lum_drawing *d, lum_box box)
{
    if (d->scale.colour == LUM_PICTURE_LABEL) {
        draw_labels(d, box);
        return;
    }
    for (int y = 0; y < box.height; y++) {
        const lum_box row = {box.x, box.y + y, box.width, 1};
        const float part = 1.0f - (float)y / (float)(box.height - 1);
        lum_canvas_fill(d->canvas, row, lum_colour(part));
    }
    draw_number(d, box, d->scale.low, "<= ");
    draw_number(d, box, d->scale.high, ">= ");
    (d->scale.colour == LUM_PICTURE_RANGE ? number_ranges : number_steps)(d,
                                                                          box);
}
