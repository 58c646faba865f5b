#include "shape.h"

#include <math.h>
#include <stdlib.h>

typedef struct span {
    float enter;
    float leave;
    int axis; /* whose side the ray enters by */
} span;

static const lum_hit no_hit = {.cover = 1.0f};

lum_ray lum_ray_make(const float d[3])
{
    lum_ray ray;
    for (int i = 0; i < 3; i++) {
        const bool flat = d[i] > -1e-9f && d[i] < 1e-9f;
        ray.d[i] = d[i];
        ray.inverse[i] = flat ? 1e9f : 1.0f / d[i];
    }
    return ray;
}

/* --- Boxes --- */

static bool cross_box(const lum_shape *s, const lum_ray *ray, span *out)
{
    span found = {-1e9f, 1e9f, 0};
    for (int i = 0; i < 3; i++) {
        const float a = s->min[i] * ray->inverse[i];
        const float b = s->max[i] * ray->inverse[i];
        const float enter = a < b ? a : b;
        const float leave = a < b ? b : a;
        if (enter > found.enter) {
            found.enter = enter;
            found.axis = i;
        }
        found.leave = leave < found.leave ? leave : found.leave;
    }
    *out = found;
    return found.enter <= found.leave && found.enter > LUM_SHAPE_NEAREST;
}

static bool cast_box(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    span at;
    if (!cross_box(s, ray, &at)) {
        return false;
    }
    *hit = no_hit;
    hit->range = at.enter;
    hit->reflectivity = s->reflectivity;
    hit->cosine = fabsf(ray->d[at.axis]);
    return true;
}

/* Clip to the half-space n p >= offset; false when nothing is left. */
static bool clip(const lum_ray *ray, const float n[3], float offset, span *at,
                 float *cosine)
{
    const float along = n[0] * ray->d[0] + n[1] * ray->d[1] + n[2] * ray->d[2];
    if (along > -1e-9f && along < 1e-9f) {
        return offset <= 0.0f;
    }
    const float t = offset / along;
    if (along < 0.0f) {
        at->leave = t < at->leave ? t : at->leave;
    } else if (t > at->enter) {
        at->enter = t;
        *cosine = along / sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return at->enter <= at->leave;
}

static bool cast_cabin(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    const float height = s->max[2] - s->min[2];
    const float side = s->lean.side / height;
    const float lean[4] = {s->lean.back / height, s->lean.front / height, side,
                           side};
    span at;
    if (!cross_box(s, ray, &at)) {
        return false;
    }
    float cosine = fabsf(ray->d[at.axis]);
    for (int i = 0; i < 4; i++) {
        const int axis = i / 2;
        const float sign = (i & 1) ? -1.0f : 1.0f;
        const float wall = (i & 1) ? -s->max[axis] : s->min[axis];
        float n[3] = {0.0f, 0.0f, -lean[i]};
        n[axis] = sign;
        if (!clip(ray, n, wall - lean[i] * s->min[2], &at, &cosine)) {
            return false;
        }
    }
    *hit = no_hit;
    hit->range = at.enter;
    hit->reflectivity = s->reflectivity;
    hit->cosine = cosine;
    return true;
}

/* --- Facades --- */

typedef struct opening {
    float low[2];  /* x, z */
    float high[2]; /* x, z */
} opening;

/* The door or window of the bay and storey that x and z lie in. */
static opening opening_at(const lum_shape *s, float x, float z)
{
    const lum_shape_openings *o = &s->opening;
    const float bay = floorf((x - s->min[0]) / o->bay);
    const float storey = floorf((z - s->min[2]) / o->storey);
    const bool door = storey < 1.0f && bay == o->door;
    const float left = s->min[0] + bay * o->bay;
    const float floor_z = s->min[2] + storey * o->storey;
    const float margin = o->bay * (door ? 0.3f : 0.24f);
    const opening found = {{left + margin, floor_z + (door ? 0.0f : 0.95f)},
                           {left + o->bay - margin, floor_z + 2.35f}};
    return found;
}

/* A ray that enters an opening ends on the pane, or on the reveal. */
static void enter_opening(const lum_shape *s, const lum_ray *ray,
                          const opening *o, lum_hit *hit)
{
    static const int axes[2] = {0, 2};
    const float deeper = ray->d[1] > 0.0f ? s->min[1] + s->opening.recess
                                          : s->max[1] - s->opening.recess;
    float t = deeper * ray->inverse[1];
    int axis = 1;
    for (int i = 0; i < 2; i++) {
        const float edge = ray->d[axes[i]] > 0.0f ? o->high[i] : o->low[i];
        const float at = edge * ray->inverse[axes[i]];
        if (at < t && at > hit->range) {
            t = at;
            axis = axes[i];
        }
    }
    hit->range = t;
    hit->cosine = fabsf(ray->d[axis]);
    hit->reflectivity = axis == 1 ? 0.12f : s->reflectivity;
}

static bool cast_facade(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    span at;
    if (!cross_box(s, ray, &at)) {
        return false;
    }
    *hit = no_hit;
    hit->range = at.enter;
    hit->cosine = fabsf(ray->d[at.axis]);
    const float x = ray->d[0] * at.enter;
    const float z = ray->d[2] * at.enter;
    /* A plinth of darker stone. */
    hit->reflectivity = s->reflectivity * (z < s->min[2] + 0.6f ? 0.5f : 1.0f);
    if (at.axis != 1) {
        return true;
    }
    const opening o = opening_at(s, x, z);
    if (x > o.low[0] && x < o.high[0] && z > o.low[1] && z < o.high[1]) {
        enter_opening(s, ray, &o, hit);
    }
    return true;
}

/* --- Round shapes --- */

/* The share of a beam that an object of this radius stops, if the beam's axis
 * passes its centre at this distance. */
static float rim_cover(float radius, float distance, float range)
{
    const float w = LUM_BEAM_HALF_WIDTH * range;
    const float cover = (radius + w - distance) / (2.0f * w);
    return cover < 0.0f ? 0.0f : cover > 1.0f ? 1.0f : cover;
}

/* The flat end of a cylinder about axis c through which the ray may enter. */
static bool cast_end(const lum_shape *s, const lum_ray *ray, const int axes[3],
                     lum_hit *hit)
{
    const int a = axes[0];
    const int b = axes[1];
    const int c = axes[2];
    const float end = ray->d[c] > 0.0f ? s->min[c] : s->max[c];
    const float t = end * ray->inverse[c];
    const float da = ray->d[a] * t - 0.5f * (s->min[a] + s->max[a]);
    const float db = ray->d[b] * t - 0.5f * (s->min[b] + s->max[b]);
    const float radius = 0.5f * (s->max[a] - s->min[a]);
    if (t <= LUM_SHAPE_NEAREST || da * da + db * db > radius * radius) {
        return false;
    }
    *hit = no_hit;
    hit->range = t;
    hit->cosine = fabsf(ray->d[c]);
    hit->reflectivity = s->reflectivity;
    return true;
}

static bool cast_side(const lum_shape *s, const lum_ray *ray, const int axes[3],
                      lum_hit *hit)
{
    const float da = ray->d[axes[0]];
    const float db = ray->d[axes[1]];
    const float ca = 0.5f * (s->min[axes[0]] + s->max[axes[0]]);
    const float cb = 0.5f * (s->min[axes[1]] + s->max[axes[1]]);
    const float radius = 0.5f * (s->max[axes[0]] - s->min[axes[0]]);
    const float square = da * da + db * db;
    if (square < 1e-9f) {
        return false;
    }
    const float length = sqrtf(square);
    const float middle = (ca * da + cb * db) / square;
    const float distance = fabsf(ca * db - cb * da) / length;
    const float cover = rim_cover(radius, distance, middle);
    const float inside = radius * radius - distance * distance;
    const float half = inside > 0.0f ? sqrtf(inside) : 0.0f;
    const float t = middle - half / length;
    const float c = ray->d[axes[2]] * t;
    if (cover <= 0.0f || t <= LUM_SHAPE_NEAREST || c < s->min[axes[2]] ||
        c > s->max[axes[2]]) {
        return false;
    }
    hit->range = t;
    hit->cover = cover;
    hit->is_rim = cover < 1.0f;
    hit->reflectivity = s->reflectivity;
    hit->cosine = 0.1f + 0.9f * half / radius * length;
    return true;
}

static bool cast_pillar(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    static const int axes[3] = {0, 1, 2};
    return cast_side(s, ray, axes, hit) || cast_end(s, ray, axes, hit);
}

static bool cast_wheel(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    static const int axes[3] = {0, 2, 1};
    return cast_end(s, ray, axes, hit) || cast_side(s, ray, axes, hit);
}

static bool cast_ball(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    const float *d = ray->d;
    const float c[3] = {0.5f * (s->min[0] + s->max[0]),
                        0.5f * (s->min[1] + s->max[1]),
                        0.5f * (s->min[2] + s->max[2])};
    const float radius = 0.5f * (s->max[0] - s->min[0]);
    const float middle = c[0] * d[0] + c[1] * d[1] + c[2] * d[2];
    const float square =
        c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - middle * middle;
    const float limit = radius + LUM_BEAM_HALF_WIDTH * middle;
    if (middle <= LUM_SHAPE_NEAREST + radius || square >= limit * limit) {
        return false;
    }
    const float distance = sqrtf(square > 0.0f ? square : 0.0f);
    const float inside = radius * radius - square;
    const float half = inside > 0.0f ? sqrtf(inside) : 0.0f;
    hit->range = middle - half;
    hit->cover = rim_cover(radius, distance, middle);
    hit->is_rim = hit->cover < 1.0f;
    hit->reflectivity = s->reflectivity;
    hit->cosine = 0.1f + 0.9f * half / radius;
    return hit->cover > 0.0f;
}

static bool cast_leaves(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    if (!cast_ball(s, ray, hit)) {
        return false;
    }
    hit->cover *= s->cover;
    return true;
}

/* --- Faces --- */

static bool cast_face(const lum_shape *s, const lum_ray *ray, lum_hit *hit)
{
    const float middle[3] = {0.5f * (s->min[0] + s->max[0]),
                             0.5f * (s->min[1] + s->max[1]),
                             0.5f * (s->min[2] + s->max[2])};
    if (!lum_face_cast(s->face, middle, ray->d, &hit->range, &hit->cosine) ||
        hit->range <= LUM_SHAPE_NEAREST) {
        return false;
    }
    hit->reflectivity = s->reflectivity;
    hit->bias = s->face->bias_m;
    return true;
}

/* --- Any of them --- */

/* Turned back, as the ray is then. */
static lum_shape turn_back(const lum_shape *shape, const lum_ray *ray,
                           lum_ray *turned)
{
    lum_shape s = *shape;
    s.min[0] = shape->min[1];
    s.max[0] = shape->max[1];
    s.min[1] = -shape->max[0];
    s.max[1] = -shape->min[0];
    const float d[3] = {ray->d[1], -ray->d[0], ray->d[2]};
    *turned = lum_ray_make(d);
    return s;
}

bool lum_shape_cast(const lum_shape *shape, const lum_ray *ray, lum_hit *hit)
{
    static bool (*const casts[LUM_SHAPES])(const lum_shape *, const lum_ray *,
                                           lum_hit *) = {
        cast_box,   cast_cabin, cast_facade, cast_pillar,
        cast_wheel, cast_ball,  cast_leaves, cast_face,
    };
    lum_hit found = no_hit;
    lum_ray turned = *ray;
    lum_shape back;
    if (shape->is_turned) {
        back = turn_back(shape, ray, &turned);
        shape = &back;
    }
    if (!casts[shape->kind](shape, &turned, &found)) {
        return false;
    }
    found.object = shape->object;
    found.thing = shape->thing;
    *hit = found;
    return true;
}

bool lum_shape_cast_moved(const lum_shape *shape, const float by[3],
                          const lum_ray *ray, lum_hit *hit)
{
    lum_shape moved = *shape;
    for (int i = 0; i < 3; i++) {
        moved.min[i] += by[i];
        moved.max[i] += by[i];
    }
    return lum_shape_cast(&moved, ray, hit);
}

/* --- Lists --- */

void lum_shape_list_add(lum_shape_list *list, const lum_shape *shape)
{
    if (list->count == list->room) {
        const size_t room = list->room != 0 ? 2 * list->room : 4096;
        lum_shape *items = realloc(list->items, room * sizeof *items);
        if (items == NULL) {
            list->failed = true;
            return;
        }
        list->items = items;
        list->room = room;
    }
    list->items[list->count++] = *shape;
}

void lum_shape_list_free(lum_shape_list *list)
{
    free(list->items);
    *list = (lum_shape_list){NULL, 0, 0, false};
}
