/* Draws the scene from above. */
#include "picture_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPARSE 200000 /* points below which each is drawn larger */
#define RINGS  5

/* Where the scene lies in the box. */
typedef struct map {
    lum_box box;
    float radius; /* metres that are drawn */
    float x_min;  /* metres at the lower edge */
    float y_mid;  /* metres in the middle */
    float scale;  /* pixels a metre */
} map;

/* Farther away is no point of a sensor, and no pixel either. */
#define RADIUS_MAX 1e5f

typedef struct bounds {
    float x_min;
    float x_max;
    float y_min;
    float y_max;
} bounds;

/* The sensor, at the origin, is always inside. */
static bounds find_bounds(const lum_dots *dots, float radius)
{
    bounds b = {0.0f, 1.0f, -0.5f, 0.5f};
    for (size_t i = 0; i < dots->count; i++) {
        const lum_dot *dot = &dots->at[i];
        if (lum_dot_distance(dot) <= radius) {
            b.x_min = fminf(b.x_min, dot->x);
            b.x_max = fmaxf(b.x_max, dot->x);
            b.y_min = fminf(b.y_min, dot->y);
            b.y_max = fmaxf(b.y_max, dot->y);
        }
    }
    return b;
}

static map make_map(const lum_dots *dots, lum_box box)
{
    static const double shares[2] = {0.0, 0.95};
    float limits[2];
    lum_dots_limits(dots, lum_dot_distance, shares, limits);
    map m = {.box = box, .radius = fminf(fmaxf(limits[1], 2.0f), RADIUS_MAX)};
    const bounds b = find_bounds(dots, m.radius);
    const float margin = 0.03f * (b.x_max - b.x_min);
    m.scale = fminf((float)box.height / (b.x_max - b.x_min + 2.0f * margin),
                    (float)box.width / (b.y_max - b.y_min + 2.0f * margin));
    m.x_min = b.x_min - margin;
    m.y_mid = (b.y_min + b.y_max) / 2.0f;
    return m;
}

/* Pixels from the left and the lower edge of the box. */
static float across(const map *m, float y)
{
    return (float)m->box.width / 2.0f - (y - m->y_mid) * m->scale;
}

static float up(const map *m, float x)
{
    return (x - m->x_min) * m->scale;
}

static int column_of(const map *m, float y)
{
    return m->box.x + (int)across(m, y);
}

static int row_of(const map *m, float x)
{
    return m->box.y + m->box.height - 1 - (int)up(m, x);
}

/* Where points lie on each other, one sees the highest. */
static void take_pixel(const map *m, uint32_t *top, const lum_dots *dots,
                       int column, int row, uint32_t i)
{
    if (column < 0 || column >= m->box.width || row < 0 ||
        row >= m->box.height) {
        return;
    }
    uint32_t *pixel = &top[row * m->box.width + column];
    if (*pixel == LUM_IMAGE_NONE || dots->at[*pixel].z < dots->at[i].z) {
        *pixel = i;
    }
}

/* A square of pixels around each point. */
static void find_top(const map *m, uint32_t *top, const lum_dots *dots,
                     int side)
{
    for (uint32_t i = 0; i < dots->count; i++) {
        const lum_dot *dot = &dots->at[i];
        if (!(lum_dot_distance(dot) <= 2.0f * m->radius)) {
            continue;
        }
        const int left = (int)floorf(across(m, dot->y)) - (side - 1) / 2;
        const int lower = (int)floorf(up(m, dot->x)) - side / 2;
        for (int k = 0; k < side * side; k++) {
            take_pixel(m, top, dots, left + k % side,
                       m->box.height - 1 - lower - k / side, i);
        }
    }
}

static void paint(const lum_drawing *d, const map *m)
{
    const size_t n = (size_t)m->box.width * (size_t)m->box.height;
    uint32_t *top = malloc(n * sizeof *top);
    if (top == NULL) {
        return;
    }
    memset(top, 0xff, n * sizeof *top);
    find_top(m, top, d->dots,
             lum_pixels(d, d->dots->all < SPARSE ? 3.0f : 2.0f));
    for (size_t i = 0; i < n; i++) {
        if (top[i] != LUM_IMAGE_NONE) {
            const size_t width = (size_t)m->box.width;
            lum_canvas_set(
                d->canvas, m->box.x + (int)(i % width),
                m->box.y + (int)(i / width),
                lum_scale_colour(&d->scale, d->dots->at[top[i]].value));
        }
    }
    free(top);
}

static void draw_rings(const lum_drawing *d, const map *m, float ring)
{
    const float x = (float)column_of(m, 0.0f) + 0.5f;
    const float y = (float)row_of(m, 0.0f) + 0.5f;
    const float most = (float)(m->box.width + m->box.height);
    for (int i = 1; (float)i * ring * m->scale < most; i++) {
        lum_canvas_circle(d->canvas, m->box, x, y, (float)i * ring * m->scale,
                          lum_grid);
    }
}

/* On each ring, straight ahead of the sensor, or behind it where the scene is
 * there. */
static void label_rings(const lum_drawing *d, const map *m, float ring)
{
    const int edge = lum_pixels(d, 12.0f);
    const bool is_behind = row_of(m, 0.0f) < m->box.y + m->box.height / 2;
    for (int i = 1; (float)i * ring < 2.0f * m->radius; i++) {
        const float at = (float)i * ring;
        char text[32];
        const int y = row_of(m, is_behind ? -at : at);
        (void)snprintf(text, sizeof text, "%g m", (double)at);
        if (y > m->box.y + edge && y < m->box.y + m->box.height - edge) {
            lum_write(d, 18.0f, LUM_ALIGN_MIDDLE, column_of(m, 0.0f), y, 0.7f,
                      text);
        }
    }
}

static void mark_sensor(const lum_drawing *d, const map *m)
{
    const int arm = lum_pixels(d, 7.0f);
    const int x = column_of(m, 0.0f);
    const int y = row_of(m, 0.0f);
    const lum_box across_it = {x - arm, y - 1, 2 * arm + 1, 3};
    const lum_box along_it = {x - 1, y - arm, 3, 2 * arm + 1};
    lum_canvas_fill(d->canvas, across_it, lum_ink);
    lum_canvas_fill(d->canvas, along_it, lum_ink);
}

void lum_draw_ground(const lum_drawing *d, lum_box box)
{
    const map m = make_map(d->dots, box);
    const float ring = lum_nice_step((float)box.height / m.scale, RINGS);
    lum_canvas_fill(d->canvas, box, lum_panel);
    draw_rings(d, &m, ring);
    paint(d, &m);
    label_rings(d, &m, ring);
    mark_sensor(d, &m);
}
