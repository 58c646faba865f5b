/* Draws what both eyes see, by azimuth and elevation. */
#include "picture_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK   256u
#define COLUMNS 1600 /* at most: in more, pixels of a line have gaps */
#define DARKEST 0.35f
#define EDGES   1.0f /* how much a step in depth darkens */
#define MOST    0.9f /* of the points that the usual view must show */
#define AROUND  2.0f /* degrees around the points of another one */
#define DEGREES 57.2957795f

/* --- The view --- */

static float azimuth(const lum_dot *dot)
{
    return atan2f(dot->y, dot->x) * DEGREES;
}

/* The same where it does not jump behind the sensor, but ahead of it. */
static float azimuth_behind(const lum_dot *dot)
{
    const float at = azimuth(dot);
    return at < 0.0f ? at + 360.0f : at;
}

static float elevation(const lum_dot *dot)
{
    return atan2f(dot->z, lum_dot_distance(dot)) * DEGREES;
}

static bool shows_most(const lum_image_view *v, const lum_dots *dots)
{
    size_t outside = 0;
    for (size_t i = 0; i < dots->count; i++) {
        const float across = azimuth(&dots->at[i]);
        const float up = elevation(&dots->at[i]);
        outside += across > v->left_deg || across < v->right_deg ||
                   up > v->top_deg || up < v->bottom_deg;
    }
    return (float)outside <= (1.0f - MOST) * (float)dots->count;
}

lum_image_view lum_panorama_view(const lum_dots *dots)
{
    static const double shares[2] = {0.005, 0.995};
    lum_image_view v;
    float ahead[2];
    float back[2];
    float up[2];
    lum_image_view_default(&v, LUM_IMAGE_BOTH, 1);
    if (shows_most(&v, dots)) {
        return v;
    }
    lum_dots_limits(dots, azimuth, shares, ahead);
    lum_dots_limits(dots, azimuth_behind, shares, back);
    lum_dots_limits(dots, elevation, shares, up);
    const float *across =
        back[1] - back[0] < ahead[1] - ahead[0] ? back : ahead;
    v.left_deg = fminf(across[1] + AROUND, 360.0f);
    v.right_deg = fmaxf(across[0] - AROUND, v.left_deg - 360.0f);
    v.top_deg = fminf(up[1] + AROUND, 90.0f);
    v.bottom_deg = fmaxf(up[0] - AROUND, -90.0f);
    return v;
}

/* --- The points in it --- */

/* The point that each pixel shows, the nearest; LUM_IMAGE_NONE: none. */
typedef struct image {
    const lum_dots *dots;
    int width;
    int height;
    uint32_t *dot;
} image;

/* At most BLOCK points, from this one on. */
static void take_block(image *im, const lum_image_scale *scale, uint32_t first,
                       uint32_t n)
{
    const lum_dot *dots = im->dots->at;
    float at[3][BLOCK];
    uint32_t pixels[BLOCK];
    for (uint32_t i = 0; i < n; i++) {
        at[0][i] = dots[first + i].x;
        at[1][i] = dots[first + i].y;
        at[2][i] = dots[first + i].z;
    }
    lum_image_pixels(scale, at[0], at[1], at[2], n, pixels);
    for (uint32_t i = 0; i < n; i++) {
        uint32_t *dot = &im->dot[pixels[i] != LUM_IMAGE_NONE ? pixels[i] : 0];
        if (pixels[i] != LUM_IMAGE_NONE &&
            (*dot == LUM_IMAGE_NONE ||
             dots[first + i].range < dots[*dot].range)) {
            *dot = first + i;
        }
    }
}

static void take_points(image *im, const lum_image_view *view)
{
    lum_image_scale scale;
    lum_image_view v = *view;
    v.rows = (uint32_t)im->height;
    v.columns = (uint32_t)im->width;
    if (lum_image_scale_init(&scale, &v) != LUM_OK) {
        return;
    }
    const uint32_t count = (uint32_t)im->dots->count;
    for (uint32_t i = 0; i < count; i += BLOCK) {
        take_block(im, &scale, i, count - i < BLOCK ? count - i : BLOCK);
    }
}

/* --- Gaps --- */

/* A row or a column of the image. */
typedef struct strip {
    uint32_t *first;
    int n;
    int stride;
} strip;

static strip strip_of(const image *im, bool vertical, int i)
{
    const strip column = {im->dot + i, im->height, im->width};
    const strip row = {im->dot + i * im->width, im->width, 1};
    return vertical ? column : row;
}

static bool has_point(const strip *s, int i)
{
    return s->first[i * s->stride] != LUM_IMAGE_NONE;
}

static void count_gaps(strip s, unsigned *gaps)
{
    int last = -1;
    for (int i = 0; i < s.n; i++) {
        if (has_point(&s, i)) {
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

/* Each half of a gap takes the point on its side. At the border, half a gap
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
        if (has_point(&s, i)) {
            fill_gap(s, last, i, widest);
            last = i;
        }
    }
    fill_gap(s, last, s.n, widest);
}

/* Sparse lines and pixels are stretched until they meet. */
static void fill_gaps(image *im, bool vertical, unsigned *gaps, int room)
{
    const int strips = vertical ? im->width : im->height;
    memset(gaps, 0, (size_t)room * sizeof *gaps);
    for (int i = 0; i < strips; i++) {
        count_gaps(strip_of(im, vertical, i), gaps);
    }
    const int widest = widest_gap(gaps, room);
    for (int i = 0; i < strips; i++) {
        fill_strip(strip_of(im, vertical, i), widest);
    }
}

/* --- Colours --- */

static const lum_dot *dot_at(const image *im, int x, int y)
{
    const bool is_inside = x >= 0 && y >= 0 && x < im->width && y < im->height;
    const uint32_t i = is_inside ? im->dot[y * im->width + x] : LUM_IMAGE_NONE;
    return i != LUM_IMAGE_NONE ? &im->dots->at[i] : NULL;
}

static float behind(const image *im, int x, int y, float range)
{
    const lum_dot *other = dot_at(im, x, y);
    return other != NULL && other->range > 0.0f && other->range < range
               ? logf(range / other->range)
               : 0.0f;
}

/* Darker beside nearer points, so that edges of objects are visible. The
 * nearest neighbour does not count, so that a single point casts no shadow. */
static float light(const image *im, int x, int y, float range)
{
    float sum = 0.0f;
    float most = 0.0f;
    for (int i = 0; i < 9; i++) {
        const float step = behind(im, x - 1 + i % 3, y - 1 + i / 3, range);
        sum += step;
        most = step > most ? step : most;
    }
    const float bright = expf(-EDGES * (sum - most));
    return bright > DARKEST ? bright : DARKEST;
}

static void paint(const lum_drawing *d, lum_box box, const image *im)
{
    for (int i = 0; i < box.width * box.height; i++) {
        const int x = i % box.width * im->width / box.width;
        const int y = i / box.width;
        const lum_dot *dot = dot_at(im, x, y);
        if (dot != NULL) {
            lum_canvas_set(d->canvas, box.x + i % box.width, box.y + y,
                           lum_shade(lum_scale_colour(&d->scale, dot->value),
                                     light(im, x, y, dot->range)));
        }
    }
}

/* --- Angles --- */

/* Degrees from low to high, along a side of the box, at most so many labels. */
typedef struct axis {
    float low;
    float high;
    float step;
} axis;

static axis make_axis(float high, float low, int labels)
{
    return (axis){low, high, lum_nice_step(high - low, labels)};
}

/* Distance below the upper end, as a fraction of the axis. */
static float part_of(const axis *a, int label)
{
    return (a->high - (float)label * a->step) / (a->high - a->low);
}

static void put_degrees(const lum_drawing *d, lum_align align, int x, int y,
                        float degrees)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%g", (double)degrees);
    lum_write(d, 16.0f, align, x, y, 0.0f, text);
}

static void label_azimuth(const lum_drawing *d, lum_box box, axis a)
{
    const int tick = lum_pixels(d, 6.0f);
    for (int i = (int)ceilf(a.low / a.step); part_of(&a, i) >= 0.0f; i++) {
        const int x = box.x + (int)(part_of(&a, i) * (float)(box.width - 1));
        const lum_box at = {x, box.y + box.height, 1, tick};
        lum_canvas_fill(d->canvas, at, lum_ink);
        put_degrees(d, LUM_ALIGN_MIDDLE, x, at.y + lum_pixels(d, 16.0f),
                    (float)i * a.step);
    }
}

static void label_elevation(const lum_drawing *d, lum_box box, axis a)
{
    const int tick = lum_pixels(d, 6.0f);
    for (int i = (int)ceilf(a.low / a.step); part_of(&a, i) >= 0.0f; i++) {
        const int y = box.y + (int)(part_of(&a, i) * (float)(box.height - 1));
        const lum_box at = {box.x - tick, y, tick, 1};
        lum_canvas_fill(d->canvas, at, lum_ink);
        put_degrees(d, LUM_ALIGN_RIGHT, at.x - lum_pixels(d, 4.0f), y,
                    (float)i * a.step);
    }
}

void lum_draw_panorama(const lum_drawing *d, lum_box box,
                       const lum_image_view *view)
{
    const int room = box.width > box.height ? box.width : box.height;
    const int width = box.width < COLUMNS ? box.width : COLUMNS;
    const size_t n = (size_t)width * (size_t)box.height;
    unsigned *gaps = malloc((size_t)room * sizeof *gaps);
    image im = {d->dots, width, box.height, malloc(n * sizeof(uint32_t))};
    lum_canvas_fill(d->canvas, box, lum_panel);
    if (im.dot != NULL && gaps != NULL) {
        memset(im.dot, 0xff, n * sizeof *im.dot);
        take_points(&im, view);
        fill_gaps(&im, true, gaps, room);
        fill_gaps(&im, false, gaps, room);
        paint(d, box, &im);
    }
    free(im.dot);
    free(gaps);
    label_azimuth(d, box, make_axis(view->left_deg, view->right_deg, 12));
    label_elevation(d, box, make_axis(view->top_deg, view->bottom_deg, 4));
}
