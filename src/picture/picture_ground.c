#include "picture_internal.h"

#include <math.h>
#include <stdio.h>

#define CELLS  LUM_GROUND_CELLS
#define FAINT  0.6f   /* how bright a single point is */
#define SPARSE 200000 /* points below which each is drawn larger */
#define RINGS  5

/* Where the scene lies in the box. */
typedef struct map {
    const uint8_t (*counts)[CELLS];
    float reach;  /* metres that counts covers in each direction */
    float radius; /* metres that are drawn */
    float x_min;  /* metres at the lower edge */
    float y_mid;  /* metres in the middle */
    float scale;  /* pixels a metre */
    float metres; /* half of what a pixel shows */
} map;

typedef struct bounds {
    float x_min;
    float x_max;
    float y_min;
    float y_max;
} bounds;

static float metres_of(const map *m, int cell)
{
    return ((float)cell + 0.5f) * 2.0f * m->reach / (float)CELLS - m->reach;
}

static int cell_of(const map *m, float metres)
{
    const float at = (metres + m->reach) / (2.0f * m->reach) * (float)CELLS;
    return at <= 0.0f ? 0 : at >= (float)CELLS ? CELLS - 1 : (int)at;
}

/* The sensor, at the origin, is always inside. */
static bounds find_bounds(const map *m)
{
    bounds b = {0.0f, 1.0f, -0.5f, 0.5f};
    for (int i = 0; i < CELLS * CELLS; i++) {
        if (m->counts[i / CELLS][i % CELLS] > 0) {
            const float x = metres_of(m, i / CELLS);
            const float y = metres_of(m, i % CELLS);
            b.x_min = fminf(b.x_min, x);
            b.x_max = fmaxf(b.x_max, x);
            b.y_min = fminf(b.y_min, y);
            b.y_max = fmaxf(b.y_max, y);
        }
    }
    b.x_min = fmaxf(b.x_min, -m->radius);
    b.x_max = fminf(b.x_max, m->radius);
    b.y_min = fmaxf(b.y_min, -m->radius);
    b.y_max = fminf(b.y_max, m->radius);
    return b;
}

static map make_map(const lum_raster *raster, lum_box box)
{
    int level = 0;
    map m = {.reach = LUM_GROUND_REACH,
             .radius = fmaxf(lum_raster_range(raster, 0.95), 2.0f)};
    for (; level < LUM_GROUND_LEVELS - 1 && m.reach < m.radius; level++) {
        m.reach *= 2.0f;
    }
    m.counts = (const uint8_t(*)[CELLS])raster->ground[level];
    const bounds b = find_bounds(&m);
    const float margin = 0.03f * (b.x_max - b.x_min);
    m.scale = fminf((float)box.height / (b.x_max - b.x_min + 2.0f * margin),
                    (float)box.width / (b.y_max - b.y_min + 2.0f * margin));
    m.x_min = b.x_min - margin;
    m.y_mid = (b.y_min + b.y_max) / 2.0f;
    m.metres = (raster->points < SPARSE ? 1.5f : 0.5f) / m.scale;
    return m;
}

/* The most points of any cell that a pixel shows. */
static int count_at(const map *m, float x, float y)
{
    const int row_end = cell_of(m, x + m->metres);
    const int column_end = cell_of(m, y + m->metres);
    int most = 0;
    for (int row = cell_of(m, x - m->metres); row <= row_end; row++) {
        for (int column = cell_of(m, y - m->metres); column <= column_end;
             column++) {
            const int count = m->counts[row][column];
            most = count > most ? count : most;
        }
    }
    return most;
}

/* Walls gather many points over one spot of ground: they are brighter. */
static float light(int count)
{
    const float bright = FAINT + (1.0f - FAINT) * logf((float)count) / 3.5f;
    return bright < 1.0f ? bright : 1.0f;
}

static void paint_pixel(lum_canvas *canvas, int px, int py, const map *m,
                        lum_depth depth, float x, float y)
{
    const float distance = hypotf(x, y);
    const int count = distance <= m->reach ? count_at(m, x, y) : 0;
    if (count > 0) {
        lum_canvas_set(
            canvas, px, py,
            lum_shade(lum_depth_colour(depth, distance), light(count)));
    }
}

static int column_of(const map *m, lum_box box, float y)
{
    return box.x + (int)((float)box.width / 2.0f - (y - m->y_mid) * m->scale);
}

static int row_of(const map *m, lum_box box, float x)
{
    return box.y + box.height - 1 - (int)((x - m->x_min) * m->scale);
}

static void paint(lum_canvas *canvas, lum_box box, const map *m,
                  lum_depth depth)
{
    for (int i = 0; i < box.width * box.height; i++) {
        const int px = i % box.width;
        const int py = i / box.width;
        const float x = m->x_min + ((float)(box.height - py) - 0.5f) / m->scale;
        const float y =
            m->y_mid + ((float)box.width / 2.0f - (float)px - 0.5f) / m->scale;
        paint_pixel(canvas, box.x + px, box.y + py, m, depth, x, y);
    }
}

static void draw_rings(lum_canvas *canvas, lum_box box, const map *m,
                       float ring)
{
    const float x = (float)column_of(m, box, 0.0f) + 0.5f;
    const float y = (float)row_of(m, box, 0.0f) + 0.5f;
    const float most = (float)(box.width + box.height);
    for (int i = 1; (float)i * ring * m->scale < most; i++) {
        lum_canvas_circle(canvas, box, x, y, (float)i * ring * m->scale,
                          lum_grid);
    }
}

/* On each ring, straight ahead of the sensor. */
static void label_rings(lum_canvas *canvas, lum_box box, const map *m,
                        float ring)
{
    const lum_style style = {18.0f, LUM_ALIGN_MIDDLE, lum_ink, lum_panel, 0.7f};
    for (int i = 1; (float)i * ring < 2.0f * m->radius; i++) {
        const float at = (float)i * ring;
        char text[32];
        const int y = row_of(m, box, at);
        (void)snprintf(text, sizeof text, "%g m", (double)at);
        if (y > box.y + 12 && y < box.y + box.height - 12) {
            lum_canvas_text(canvas, &style, column_of(m, box, 0.0f), y, text);
        }
    }
}

static void mark_sensor(lum_canvas *canvas, lum_box box, const map *m)
{
    const lum_box across = {column_of(m, box, 0.0f) - 7,
                            row_of(m, box, 0.0f) - 1, 15, 3};
    const lum_box along = {column_of(m, box, 0.0f) - 1,
                           row_of(m, box, 0.0f) - 7, 3, 15};
    lum_canvas_fill(canvas, across, lum_ink);
    lum_canvas_fill(canvas, along, lum_ink);
}

void lum_draw_ground(lum_canvas *canvas, lum_box box, const lum_raster *raster,
                     lum_depth depth)
{
    const map m = make_map(raster, box);
    const float ring = lum_nice_step((float)box.height / m.scale, RINGS);
    lum_canvas_fill(canvas, box, lum_panel);
    draw_rings(canvas, box, &m, ring);
    paint(canvas, box, &m, depth);
    label_rings(canvas, box, &m, ring);
    mark_sensor(canvas, box, &m);
}
