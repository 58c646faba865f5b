#include "picture_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CELLS    LUM_PANORAMA_CELLS
#define SMALLEST 32 /* smallest size of a crop in cells, in each direction */
#define DARKEST  0.35f
#define EDGES    1.0f /* how much a step in depth darkens */
#define TICK     6

/* Ranges as they will be drawn; 0: nothing. */
typedef struct view {
    int width;
    int height;
    float *range;
} view;

typedef struct span {
    int first;
    int end;
} span;

typedef struct crop {
    span rows;
    span columns;
} crop;

static void widen(span *s, int at)
{
    s->first = at < s->first ? at : s->first;
    s->end = at + 1 > s->end ? at + 1 : s->end;
}

static void enlarge(span *s)
{
    if (s->end <= s->first) {
        s->first = 0;
        s->end = CELLS;
    }
    while (s->end - s->first < SMALLEST) {
        s->first -= s->first > 0;
        s->end += s->end < CELLS;
    }
}

static crop find_crop(const lum_panorama *p)
{
    crop c = {{CELLS, 0}, {CELLS, 0}};
    for (int i = 0; i < CELLS * CELLS; i++) {
        if (p->nearest[i] > 0.0f) {
            widen(&c.rows, i / CELLS);
            widen(&c.columns, i % CELLS);
        }
    }
    enlarge(&c.rows);
    enlarge(&c.columns);
    return c;
}

/* The cells that a pixel shows: none is left out, and there is always one. */
static span cells_of(int pixel, int pixels, span cells)
{
    const int n = cells.end - cells.first;
    span s = {cells.first + pixel * n / pixels,
              cells.first + (pixel + 1) * n / pixels};
    s.end = s.end > s.first ? s.end : s.first + 1;
    return s;
}

static float nearest_of(const lum_panorama *p, span rows, span columns)
{
    float nearest = 0.0f;
    for (int row = rows.first; row < rows.end; row++) {
        for (int column = columns.first; column < columns.end; column++) {
            const float range = p->nearest[row * CELLS + column];
            if (range > 0.0f && (nearest <= 0.0f || range < nearest)) {
                nearest = range;
            }
        }
    }
    return nearest;
}

static void sample_view(view *v, const lum_panorama *p, crop c)
{
    for (int y = 0; y < v->height; y++) {
        const span rows = cells_of(y, v->height, c.rows);
        for (int x = 0; x < v->width; x++) {
            const span columns = cells_of(x, v->width, c.columns);
            v->range[y * v->width + x] = nearest_of(p, rows, columns);
        }
    }
}

/* A row or a column of the view. */
typedef struct strip {
    float *first;
    int n;
    int stride;
} strip;

static strip strip_of(const view *v, bool vertical, int i)
{
    const strip column = {v->range + i, v->height, v->width};
    const strip row = {v->range + i * v->width, v->width, 1};
    return vertical ? column : row;
}

static void count_gaps(strip s, unsigned *gaps)
{
    int last = -1;
    for (int i = 0; i < s.n; i++) {
        if (s.first[i * s.stride] > 0.0f) {
            if (last >= 0) {
                gaps[i - last]++;
            }
            last = i;
        }
    }
}

/* One and a half times the distance that nine of ten neighbours do not exceed,
 * and one more pixel, because rounding can move them by that. In wider gaps
 * nothing came back. */
static int widest_gap(const unsigned *gaps, int n)
{
    unsigned total = 0;
    unsigned below = 0;
    for (int i = 0; i < n; i++) {
        total += gaps[i];
    }
    for (int i = 0; i < n; i++) {
        below += gaps[i];
        if ((double)below >= 0.9 * total) {
            return i + (i + 1) / 2 + 1;
        }
    }
    return 0;
}

/* Each half of a gap takes the range on its side. At the border, half a gap
 * does so too. */
static void fill_gap(strip s, int before, int after, int widest)
{
    const bool has_before = before >= 0;
    const bool has_after = after < s.n;
    const int most = has_before && has_after ? widest : widest / 2;
    if ((!has_before && !has_after) || after - before > most) {
        return;
    }
    for (int i = before + 1; i < after; i++) {
        const bool takes_before =
            has_before && (!has_after || i - before <= after - i);
        s.first[i * s.stride] =
            s.first[(takes_before ? before : after) * s.stride];
    }
}

static void fill_strip(strip s, int widest)
{
    int last = -1;
    for (int i = 0; i < s.n; i++) {
        if (s.first[i * s.stride] > 0.0f) {
            fill_gap(s, last, i, widest);
            last = i;
        }
    }
    fill_gap(s, last, s.n, widest);
}

/* Sparse lines and pixels are stretched until they meet. */
static void fill_gaps(view *v, bool vertical, unsigned *gaps, int room)
{
    const int strips = vertical ? v->width : v->height;
    memset(gaps, 0, (size_t)room * sizeof *gaps);
    for (int i = 0; i < strips; i++) {
        count_gaps(strip_of(v, vertical, i), gaps);
    }
    const int widest = widest_gap(gaps, room);
    for (int i = 0; i < strips; i++) {
        fill_strip(strip_of(v, vertical, i), widest);
    }
}

static float behind(const view *v, int x, int y, float range)
{
    if (x < 0 || y < 0 || x >= v->width || y >= v->height) {
        return 0.0f;
    }
    const float other = v->range[y * v->width + x];
    return other > 0.0f && other < range ? logf(range / other) : 0.0f;
}

/* Darker beside nearer points, so that edges of objects are visible. The
 * nearest neighbour does not count, so that a single point casts no shadow. */
static float light(const view *v, int x, int y, float range)
{
    float sum = 0.0f;
    float most = 0.0f;
    for (int i = 0; i < 9; i++) {
        const float step = behind(v, x - 1 + i % 3, y - 1 + i / 3, range);
        sum += step;
        most = step > most ? step : most;
    }
    const float bright = expf(-EDGES * (sum - most));
    return bright > DARKEST ? bright : DARKEST;
}

static void paint(lum_canvas *canvas, lum_box box, const view *v,
                  lum_depth depth)
{
    for (int i = 0; i < v->width * v->height; i++) {
        const int x = i % v->width;
        const int y = i / v->width;
        if (v->range[i] > 0.0f) {
            lum_canvas_set(canvas, box.x + x, box.y + y,
                           lum_shade(lum_depth_colour(depth, v->range[i]),
                                     light(v, x, y, v->range[i])));
        }
    }
}

/* Degrees from low to high, along an axis of the picture. */
typedef struct axis {
    float low;
    float high;
    float step;
} axis;

/* Cells are counted from the upper end of a whole axis. */
static axis make_axis(float high, float low, span cells, int labels)
{
    const float cell = (high - low) / (float)CELLS;
    axis a = {high - (float)cells.end * cell, high - (float)cells.first * cell,
              0.0f};
    a.step = lum_nice_step(a.high - a.low, labels);
    return a;
}

/* Distance below the upper end, as a fraction of the axis. */
static float part_of(const axis *a, int label)
{
    return (a->high - (float)label * a->step) / (a->high - a->low);
}

static void put_degrees(lum_canvas *canvas, lum_align align, int x, int y,
                        float degrees)
{
    const lum_style style = {16.0f, align, lum_ink, lum_paper, 0.0f};
    char text[32];
    (void)snprintf(text, sizeof text, "%g", (double)degrees);
    lum_canvas_text(canvas, &style, x, y, text);
}

static void label_azimuth(lum_canvas *canvas, lum_box box, axis a)
{
    for (int i = (int)ceilf(a.low / a.step); part_of(&a, i) >= 0.0f; i++) {
        const int x = box.x + (int)(part_of(&a, i) * (float)box.width);
        const lum_box tick = {x, box.y + box.height, 1, TICK};
        lum_canvas_fill(canvas, tick, lum_ink);
        put_degrees(canvas, LUM_ALIGN_MIDDLE, x, tick.y + TICK + 10,
                    (float)i * a.step);
    }
}

static void label_elevation(lum_canvas *canvas, lum_box box, axis a)
{
    for (int i = (int)ceilf(a.low / a.step); part_of(&a, i) >= 0.0f; i++) {
        const int y = box.y + (int)(part_of(&a, i) * (float)box.height);
        const lum_box tick = {box.x - TICK, y, TICK, 1};
        lum_canvas_fill(canvas, tick, lum_ink);
        put_degrees(canvas, LUM_ALIGN_RIGHT, tick.x - 4, y, (float)i * a.step);
    }
}

void lum_draw_panorama(lum_canvas *canvas, lum_box box,
                       const lum_panorama *panorama, lum_depth depth)
{
    const crop c = find_crop(panorama);
    const int room = box.width > box.height ? box.width : box.height;
    unsigned *gaps = malloc((size_t)room * sizeof *gaps);
    view v = {box.width, box.height, NULL};
    v.range = calloc((size_t)box.width * (size_t)box.height, sizeof *v.range);
    lum_canvas_fill(canvas, box, lum_panel);
    if (v.range != NULL && gaps != NULL) {
        sample_view(&v, panorama, c);
        fill_gaps(&v, true, gaps, room);
        fill_gaps(&v, false, gaps, room);
        paint(canvas, box, &v, depth);
    }
    free(v.range);
    free(gaps);
    const lum_image_view *w = &panorama->view;
    label_azimuth(canvas, box,
                  make_axis(w->left_deg, w->right_deg, c.columns, 6));
    label_elevation(canvas, box,
                    make_axis(w->top_deg, w->bottom_deg, c.rows, 5));
}
