#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cells over the whole sphere: columns of azimuth, rows of the sine of the
 * elevation. */
#define COLUMNS 1024
#define ROWS    512
#define CELLS   ((size_t)COLUMNS * ROWS)

/* --- Cells of a shape --- */

typedef struct cells {
    uint16_t row[2];    /* first and last */
    uint16_t column[2]; /* first and last */
} cells;

/* A shape's place from near to far. */
struct lum_scene_place {
    const lum_shape *shape;
    float near_m; /* its own */
    cells cells;
};

/* Rises with azimuth from -2 behind by 0 ahead to 2 behind, as atan2 does, and
 * costs a division. */
static float diamond(float x, float y)
{
    const float sum = fabsf(x) + fabsf(y);
    if (sum <= 0.0f) {
        return 0.0f;
    }
    if (x >= 0.0f) {
        return y / sum;
    }
    return y >= 0.0f ? 2.0f - y / sum : -2.0f - y / sum;
}

static int clamp(int value, int high)
{
    return value < 0 ? 0 : value > high ? high : value;
}

static uint16_t column_of(float x, float y)
{
    return (uint16_t)clamp((int)((diamond(x, y) + 2.0f) * (COLUMNS / 4.0f)),
                           COLUMNS - 1);
}

static uint16_t row_of(float sine)
{
    return (uint16_t)clamp((int)((sine + 1.0f) * (ROWS / 2.0f)), ROWS - 1);
}

static float nearest(float low, float high)
{
    return low > 0.0f ? low : high < 0.0f ? -high : 0.0f;
}

static float farthest(float low, float high)
{
    return -low > high ? -low : high;
}

static float sine(float z, float away_square)
{
    const float length = sqrtf(z * z + away_square);
    return length > 0.0f ? z / length : 0.0f;
}

static float sum_of_squares(float a, float b)
{
    return a * a + b * b;
}

static void find_rows(const float low[3], const float high[3], cells *out)
{
    const float close =
        sum_of_squares(nearest(low[0], high[0]), nearest(low[1], high[1]));
    const float far =
        sum_of_squares(farthest(low[0], high[0]), farthest(low[1], high[1]));
    out->row[0] = row_of(sine(low[2], low[2] < 0.0f ? close : far));
    out->row[1] = row_of(sine(high[2], high[2] > 0.0f ? close : far));
}

static void find_columns(const float low[3], const float high[3], cells *out)
{
    if (low[0] <= 0.0f && low[1] <= 0.0f && high[1] >= 0.0f) {
        out->column[0] = 0;
        out->column[1] = COLUMNS - 1;
        return;
    }
    out->column[0] = COLUMNS - 1;
    out->column[1] = 0;
    for (int i = 0; i < 4; i++) {
        const uint16_t at =
            column_of((i & 1) ? high[0] : low[0], (i & 2) ? high[1] : low[1]);
        out->column[0] = at < out->column[0] ? at : out->column[0];
        out->column[1] = at > out->column[1] ? at : out->column[1];
    }
}

/* The box that a shape is in, as seen from any start of the section. */
static void bound(const lum_scene *scene, const lum_shape *s, float low[3],
                  float high[3])
{
    for (int i = 0; i < 3; i++) {
        const float more =
            scene->reach_m + fabsf(s->velocity[i]) * scene->half_s;
        low[i] = s->min[i] - more;
        high[i] = s->max[i] + more;
    }
}

/* The cells whose rays may hit a shape or, at its rim, pass within half a beam
 * of it. */
static cells cells_of(const lum_scene *scene, const lum_shape *s)
{
    float low[3];
    float high[3];
    cells found;
    const float away = s->near_m + (s->max[0] - s->min[0]);
    const float rim = 0.001f + 2.0f * LUM_BEAM_HALF_WIDTH * away;
    bound(scene, s, low, high);
    for (int i = 0; i < 3; i++) {
        low[i] -= rim;
        high[i] += rim;
    }
    find_rows(low, high, &found);
    find_columns(low, high, &found);
    return found;
}

/* --- From near to far --- */

static float distance_of(const lum_scene *scene, const lum_shape *s)
{
    float low[3];
    float high[3];
    float square = 0.0f;
    bound(scene, s, low, high);
    for (int k = 0; k < 3; k++) {
        const float d = nearest(low[k], high[k]);
        square += d * d;
    }
    return sqrtf(square);
}

static int compare_distance(const void *a, const void *b)
{
    const struct lum_scene_place *first = a;
    const struct lum_scene_place *second = b;
    if (first->near_m != second->near_m) {
        return first->near_m < second->near_m ? -1 : 1;
    }
    /* Equal ones may be in any order, if it is always the same. */
    const lum_shape *left = first->shape;
    const lum_shape *right = second->shape;
    for (int i = 0; i < 3; i++) {
        if (left->min[i] != right->min[i]) {
            return left->min[i] < right->min[i] ? -1 : 1;
        }
    }
    return (left->max[2] > right->max[2]) - (left->max[2] < right->max[2]);
}

static void sort(lum_scene *scene)
{
    for (size_t i = 0; i < scene->shapes.count; i++) {
        lum_shape *s = &scene->shapes.items[i];
        s->near_m = distance_of(scene, s);
        scene->order[i] = (struct lum_scene_place){
            .shape = s, .near_m = s->near_m, .cells = cells_of(scene, s)};
    }
    qsort(scene->order, scene->shapes.count, sizeof *scene->order,
          compare_distance);
}

static size_t count_entries(lum_scene *scene)
{
    memset(scene->cells, 0, (CELLS + 1) * sizeof *scene->cells);
    for (size_t i = 0; i < scene->shapes.count; i++) {
        const cells *c = &scene->order[i].cells;
        for (int row = c->row[0]; row <= c->row[1]; row++) {
            for (int column = c->column[0]; column <= c->column[1]; column++) {
                scene->cells[row * COLUMNS + column]++;
            }
        }
    }
    uint32_t sum = 0;
    for (size_t i = 0; i <= CELLS; i++) {
        sum += scene->cells[i];
        scene->cells[i] = sum;
    }
    return sum;
}

/* Filled from the far end, so that each cell's start ends up in cells[] and its
 * shapes stand from near to far. */
static void fill_entries(lum_scene *scene)
{
    for (size_t i = scene->shapes.count; i-- > 0;) {
        const cells *c = &scene->order[i].cells;
        const uint32_t shape =
            (uint32_t)(scene->order[i].shape - scene->shapes.items);
        for (int row = c->row[0]; row <= c->row[1]; row++) {
            for (int column = c->column[0]; column <= c->column[1]; column++) {
                scene->entries[--scene->cells[row * COLUMNS + column]] = shape;
            }
        }
    }
}

/* --- Setting --- */

static int make_room(lum_scene *scene, size_t count)
{
    if (count <= scene->room) {
        return 0;
    }
    const size_t room = count + count / 2;
    uint32_t *entries = realloc(scene->entries, room * sizeof *entries);
    if (entries == NULL) {
        return -1;
    }
    scene->entries = entries;
    scene->room = room;
    return 0;
}

static int make_order(lum_scene *scene)
{
    if (scene->shapes.count <= scene->order_room) {
        return 0;
    }
    free(scene->order);
    scene->order = malloc(scene->shapes.room * sizeof *scene->order);
    scene->order_room = scene->order != NULL ? scene->shapes.room : 0;
    return scene->order != NULL ? 0 : -1;
}

static int make_cells(lum_scene *scene)
{
    if (scene->cells == NULL) {
        scene->cells = malloc((CELLS + 1) * sizeof *scene->cells);
    }
    return scene->cells == NULL ? -1 : 0;
}

/* Of the shapes that are laid out. */
static int arrange(lum_scene *scene)
{
    if (scene->shapes.failed || make_order(scene) != 0) {
        return -1;
    }
    sort(scene);
    if (make_room(scene, count_entries(scene)) != 0) {
        return -1;
    }
    fill_entries(scene);
    return 0;
}

int lum_scene_set(lum_scene *scene, const lum_place *place, double time_s,
                  const float mount[3])
{
    if (make_cells(scene) != 0) {
        return -1;
    }
    lum_place_lay_out(place, time_s, mount, &scene->shapes, &scene->ground);
    return arrange(scene);
}

int lum_scene_set_section(lum_scene *scene, const lum_place *place,
                          const lum_section *section)
{
    if (make_cells(scene) != 0) {
        return -1;
    }
    scene->reach_m = section->view.reach_m;
    scene->half_s = (float)section->half_s;
    lum_place_lay_out_around(place, section->time_s, &section->view,
                             &scene->shapes, &scene->ground);
    return arrange(scene);
}

void lum_scene_free(lum_scene *scene)
{
    lum_shape_list_free(&scene->shapes);
    free(scene->cells);
    free(scene->entries);
    free(scene->order);
    scene->cells = NULL;
    scene->entries = NULL;
    scene->order = NULL;
    scene->room = 0;
    scene->order_room = 0;
}

/* --- Casting --- */

/* Hits from near to far; those beyond the last place are dropped. */
static size_t insert(lum_hit *hits, size_t count, const lum_hit *hit)
{
    size_t at = count;
    if (count == LUM_SCENE_HITS_MAX - 1) {
        if (hits[count - 1].range <= hit->range) {
            return count;
        }
        at = count - 1;
        count--;
    }
    for (; at > 0 && hits[at - 1].range > hit->range; at--) {
        hits[at] = hits[at - 1];
    }
    hits[at] = *hit;
    return count + 1;
}

static bool meet(const lum_shape *s, const lum_start *start, const lum_ray *ray,
                 lum_hit *hit)
{
    float by[3];
    if (start == NULL) {
        return lum_shape_cast(s, ray, hit);
    }
    for (int i = 0; i < 3; i++) {
        by[i] = s->velocity[i] * start->late_s - start->from[i];
    }
    return lum_shape_cast_moved(s, by, ray, hit);
}

/* start NULL: at the origin, at the moment of the scene. The last hit is the
 * one that stops the beam, or nothing where its cover is 0. */
static size_t cast(const lum_scene *scene, const lum_start *start,
                   const lum_ray *ray, lum_hit last, lum_hit *hits)
{
    const size_t cell = (size_t)row_of(ray->d[2]) * COLUMNS +
                        (size_t)column_of(ray->d[0], ray->d[1]);
    const uint32_t end = scene->cells[cell + 1];
    size_t count = 0;
    lum_hit hit;
    for (uint32_t i = scene->cells[cell]; i < end; i++) {
        const lum_shape *s = &scene->shapes.items[scene->entries[i]];
        if (s->near_m > last.range) {
            break;
        }
        if (!meet(s, start, ray, &hit) || hit.range >= last.range) {
            continue;
        }
        if (hit.cover >= 1.0f) {
            last = hit;
        } else {
            count = insert(hits, count, &hit);
        }
    }
    while (count > 0 && hits[count - 1].range >= last.range) {
        count--;
    }
    if (last.cover > 0.0f) {
        hits[count++] = last;
    }
    return count;
}

static lum_hit hit_ground(const lum_ground *ground, const lum_ray *ray)
{
    const lum_hit sky = {.range = LUM_STREET_REACH};
    lum_hit hit;
    return lum_ground_cast(ground, ray, &hit) ? hit : sky;
}

size_t lum_scene_cast(const lum_scene *scene, const lum_ray *ray, lum_hit *hits)
{
    return cast(scene, NULL, ray, hit_ground(&scene->ground, ray), hits);
}

size_t lum_scene_cast_from(const lum_scene *scene, const lum_start *start,
                           const lum_ray *ray, lum_hit *hits)
{
    const lum_ground ground = lum_ground_seen_from(&scene->ground, start->from);
    return cast(scene, start, ray, hit_ground(&ground, ray), hits);
}
