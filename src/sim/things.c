#include "things.h"

#include <math.h>

#define CROWN_LEAVES 260

/* --- Shapes --- */

/* A quarter turn to the left about the vertical. */
static void turn(lum_shape *s)
{
    const float low_x = s->min[0];
    const float high_x = s->max[0];
    const float speed = s->velocity[0];
    s->min[0] = -s->max[1];
    s->max[0] = -s->min[1];
    s->min[1] = low_x;
    s->max[1] = high_x;
    s->velocity[0] = -s->velocity[1];
    s->velocity[1] = speed;
    s->is_turned = true;
}

/* The next object, of all that is added until another one begins. */
static void begin(lum_things *s, lum_thing thing)
{
    s->object++;
    s->thing = (uint8_t)thing;
}

/* What moves is taken to be larger. */
static bool is_in_view(const lum_sight_view *view, const lum_shape *s)
{
    const float width = s->max[0] - s->min[0];
    const float depth = s->max[1] - s->min[1];
    const float radius = 0.5f * (width > depth ? width : depth) * 1.42f;
    const bool moves = s->velocity[0] != 0.0f || s->velocity[1] != 0.0f;
    return lum_view_has(view, 0.5f * (s->min[0] + s->max[0]),
                        0.5f * (s->min[1] + s->max[1]),
                        moves ? radius + 1.0f : radius);
}

static void add(const lum_things *s, lum_shape shape)
{
    const float at[3] = {s->x, s->y, s->z};
    for (int i = 0; i < 3; i++) {
        shape.min[i] += at[i];
        shape.max[i] += at[i];
    }
    shape.velocity[0] = s->velocity[0];
    shape.velocity[1] = s->velocity[1];
    shape.object = s->object;
    shape.thing = s->thing;
    if (s->is_turned) {
        turn(&shape);
    }
    for (int i = 0; i < 2; i++) {
        shape.min[i] += s->origin[i];
        shape.max[i] += s->origin[i];
        if (shape.max[i] <= s->low[i] || shape.min[i] >= s->high[i]) {
            return;
        }
    }
    if (s->view == NULL || is_in_view(s->view, &shape)) {
        lum_shape_list_add(s->list, &shape);
    }
}

static lum_shape box(lum_shape_kind kind, const float from[3],
                     const float size[3], float reflectivity)
{
    const lum_shape shape = {
        .min = {from[0], from[1], from[2]},
        .max = {from[0] + size[0], from[1] + size[1], from[2] + size[2]},
        .reflectivity = reflectivity,
        .kind = kind};
    return shape;
}

static void add_box(const lum_things *s, float x, float y, float z,
                    float length, float width, float height, float reflectivity)
{
    const float from[3] = {x, y - 0.5f * width, z};
    const float size[3] = {length, width, height};
    add(s, box(LUM_SHAPE_BOX, from, size, reflectivity));
}

static void add_pillar(const lum_things *s, float x, float y, float z,
                       float radius, float height, float reflectivity)
{
    const float from[3] = {x - radius, y - radius, z};
    const float size[3] = {2.0f * radius, 2.0f * radius, height};
    add(s, box(LUM_SHAPE_PILLAR, from, size, reflectivity));
}

static void add_wheel(const lum_things *s, float x, float y, float radius,
                      float width)
{
    const float from[3] = {x - radius, y - 0.5f * width, 0.0f};
    const float size[3] = {2.0f * radius, width, 2.0f * radius};
    add(s, box(LUM_SHAPE_WHEEL, from, size, 0.1f));
}

static void add_ball(const lum_things *s, lum_shape_kind kind,
                     const float at[3], float radius, float reflectivity,
                     float cover)
{
    const float from[3] = {at[0] - radius, at[1] - radius, at[2] - radius};
    const float size[3] = {2.0f * radius, 2.0f * radius, 2.0f * radius};
    lum_shape shape = box(kind, from, size, reflectivity);
    shape.cover = cover;
    add(s, shape);
}

/* --- Things of a street --- */

/* Leaves in an ellipsoid about (x, y, z). */
static void add_crown(lum_things *s, const float at[3], const float radius[3],
                      unsigned leaves)
{
    lum_random *r = &s->random;
    for (unsigned i = 0; i < leaves; i++) {
        float p[3];
        float square;
        do {
            square = 0.0f;
            for (int k = 0; k < 3; k++) {
                p[k] = lum_random_between(r, -1.0f, 1.0f);
                square += p[k] * p[k];
            }
        } while (square > 1.0f);
        for (int k = 0; k < 3; k++) {
            p[k] = at[k] + p[k] * radius[k];
        }
        const float size = lum_random_between(r, 0.08f, 0.18f);
        const float cover = lum_random_between(r, 0.25f, 0.6f);
        add_ball(s, LUM_SHAPE_LEAVES, p, size, 0.45f, cover);
    }
}

void lum_things_add_tree(lum_things *s, float x, float y)
{
    begin(s, LUM_THING_TREE);
    lum_random *r = &s->random;
    const float width = lum_random_between(r, 1.3f, 2.0f);
    const float height = lum_random_between(r, 1.4f, 2.1f);
    const float bottom = lum_random_between(r, 1.4f, 2.0f);
    const float at[3] = {x, y, bottom + height};
    const float radius[3] = {width, width, height};
    add_pillar(s, x, y, LUM_PAVEMENT_Z, lum_random_between(r, 0.1f, 0.18f),
               bottom + 0.8f, 0.3f);
    add_crown(s, at, radius, CROWN_LEAVES);
}

void lum_things_add_bush(lum_things *s, float x, float y)
{
    begin(s, LUM_THING_TREE);
    const float at[3] = {x, y, 0.75f};
    const float radius[3] = {0.85f, 0.5f, 0.65f};
    add_crown(s, at, radius, 60);
}

void lum_things_add_lamp(lum_things *s, float x, float y)
{
    begin(s, LUM_THING_POLE);
    const float arm = y > 0.0f ? -0.7f : 0.7f;
    add_pillar(s, x, y, LUM_PAVEMENT_Z, 0.09f, 6.0f, 0.35f);
    add_pillar(s, x, y, LUM_PAVEMENT_Z, 0.16f, 0.9f, 0.35f);
    add_box(s, x - 0.05f, y + arm, 5.9f, 0.1f, 1.4f, 0.1f, 0.35f);
}

void lum_things_add_sign(lum_things *s, float x, float y)
{
    begin(s, LUM_THING_SIGN);
    add_pillar(s, x, y, LUM_PAVEMENT_Z, 0.05f, 2.5f, 0.5f);
    add_box(s, x - 0.07f, y, 1.95f, 0.02f, 0.7f, 0.7f, 1.0f);
}

void lum_things_add_bin(lum_things *s, float x, float y)
{
    begin(s, LUM_THING_OTHER);
    add_pillar(s, x, y, LUM_PAVEMENT_Z, 0.28f, 1.0f, 0.2f);
}

void lum_things_add_posts(lum_things *s, float x)
{
    for (int i = 0; i < 4; i++) {
        begin(s, LUM_THING_POLE);
        add_pillar(s, x + 1.6f * (float)i, s->side * (LUM_ROAD_HALF + 0.3f),
                   LUM_PAVEMENT_Z, 0.08f, 0.9f, 0.5f);
    }
}

/* Two legs in mid-stride, a body, a head. */
void lum_things_add_person(lum_things *s, float x, float y, float z,
                           float speed)
{
    begin(s, LUM_THING_PERSON);
    const double cycle = s->time_s * 0.9 + (double)x;
    const float phase = (float)(cycle - floor(cycle)) * 4.0f;
    const float swing = (phase < 2.0f ? phase - 1.0f : 3.0f - phase);
    const float step = speed != 0.0f ? 0.28f * swing : 0.05f;
    const float head[3] = {x, y, z + 1.62f};
    add_pillar(s, x + step, y - 0.1f, z, 0.09f, 0.85f, 0.25f);
    add_pillar(s, x - step, y + 0.1f, z, 0.09f, 0.85f, 0.25f);
    add_pillar(s, x, y, z + 0.82f, 0.2f, 0.65f, 0.5f);
    add_pillar(s, x - 0.6f * step, y - 0.27f, z + 0.8f, 0.06f, 0.6f, 0.5f);
    add_pillar(s, x + 0.6f * step, y + 0.27f, z + 0.8f, 0.06f, 0.6f, 0.5f);
    add_ball(s, LUM_SHAPE_BALL, head, 0.13f, 0.5f, 1.0f);
}

/* --- Vehicles --- */

static void add_wheels(lum_things *s, float x, float y, float length,
                       float width, float radius)
{
    for (int i = 0; i < 4; i++) {
        const float along = (i & 1) ? length * 0.8f : length * 0.18f;
        const float across = (i & 2) ? 0.5f * width : -0.5f * width;
        add_wheel(s, x + along, y + across * 0.92f, radius, 0.24f);
    }
}

static void add_cabin(lum_things *s, const float from[3], const float size[3],
                      lum_shape_lean lean, float reflectivity)
{
    lum_shape shape = box(LUM_SHAPE_CABIN, from, size, reflectivity);
    shape.lean = lean;
    add(s, shape);
}

/* Vehicles begin at x and face +x when facing is 1, -x when it is -1. */
void lum_things_add_car(lum_things *s, float x, float y, float facing,
                        float paint)
{
    begin(s, LUM_THING_CAR);
    const float hood = facing > 0.0f ? 0.5f : 1.2f;
    const float from[3] = {x + hood, y - 0.78f, 0.88f};
    const float size[3] = {2.65f, 1.56f, 0.56f};
    const lum_shape_lean lean = {facing > 0.0f ? 0.75f : 0.4f,
                                 facing > 0.0f ? 0.4f : 0.75f, 0.16f};
    add_box(s, x, y, 0.22f, 4.35f, 1.78f, 0.4f, paint);
    add_box(s, x + 0.08f, y, 0.62f, 4.19f, 1.7f, 0.27f, paint);
    add_cabin(s, from, size, lean, 0.3f);
    add_wheels(s, x, y, 4.35f, 1.78f, 0.32f);
    /* Number plates: retroreflectors at both ends. */
    add_box(s, x - 0.02f, y, 0.45f, 0.03f, 0.5f, 0.12f, 1.0f);
    add_box(s, x + 4.34f, y, 0.45f, 0.03f, 0.5f, 0.12f, 1.0f);
}

void lum_things_add_van(lum_things *s, float x, float y, float facing,
                        float paint)
{
    begin(s, LUM_THING_TRUCK);
    const float cargo = facing > 0.0f ? x : x + 1.1f;
    const float hood = facing > 0.0f ? x + 4.1f : x;
    const float from[3] = {hood, y - 0.92f, 1.15f};
    const float size[3] = {1.1f, 1.84f, 0.95f};
    const lum_shape_lean lean = {facing > 0.0f ? 0.85f : 0.0f,
                                 facing > 0.0f ? 0.0f : 0.85f, 0.1f};
    add_box(s, cargo, y, 0.35f, 4.1f, 1.95f, 1.95f, paint);
    add_box(s, hood, y, 0.35f, 1.1f, 1.9f, 0.8f, paint);
    add_cabin(s, from, size, lean, 0.3f);
    add_wheels(s, x, y, 5.2f, 1.95f, 0.36f);
}

void lum_things_add_truck(lum_things *s, float x, float y, float facing,
                          float paint)
{
    begin(s, LUM_THING_TRUCK);
    const float cargo = facing > 0.0f ? x : x + 2.2f;
    const float cab = facing > 0.0f ? x + 6.2f : x;
    add_box(s, cargo, y, 1.0f, 6.0f, 2.5f, 2.6f, paint);
    add_box(s, x, y, 0.7f, 8.0f, 0.9f, 0.3f, 0.2f);
    add_box(s, cab, y, 0.5f, 1.9f, 2.4f, 2.3f, 0.45f);
    add_wheels(s, x, y, 8.0f, 2.4f, 0.5f);
}

void lum_things_add_cyclist(lum_things *s, float x, float y, float facing,
                            float paint)
{
    begin(s, LUM_THING_CYCLIST);
    (void)facing;
    const float head[3] = {x + 1.05f, y, 1.7f};
    add_wheel(s, x + 0.33f, y, 0.33f, 0.06f);
    add_wheel(s, x + 1.37f, y, 0.33f, 0.06f);
    add_box(s, x + 0.35f, y, 0.5f, 1.0f, 0.08f, 0.2f, 0.3f);
    add_pillar(s, x + 0.75f, y, 0.5f, 0.12f, 0.5f, 0.3f);
    add_pillar(s, x + 0.9f, y, 0.95f, 0.19f, 0.6f, paint);
    add_ball(s, LUM_SHAPE_BALL, head, 0.14f, 0.5f, 1.0f);
}

/* --- Houses --- */

void lum_things_add_facade(lum_things *s, float x, float length, float setback)
{
    begin(s, LUM_THING_BUILDING);
    lum_random *r = &s->random;
    const float depth = LUM_HOUSE_DEPTH;
    const float bays = floorf(length / lum_random_between(r, 2.3f, 3.3f));
    const float y = s->side * (LUM_HOUSES_Y + setback + 0.5f * depth);
    const float from[3] = {x, y - 0.5f * depth, LUM_PAVEMENT_Z};
    const float size[3] = {length, depth, lum_random_between(r, 8.0f, 17.0f)};
    lum_shape shape =
        box(LUM_SHAPE_FACADE, from, size, lum_random_between(r, 0.3f, 0.75f));
    shape.opening.bay = length / bays;
    shape.opening.storey = 3.2f;
    shape.opening.recess = 0.35f;
    shape.opening.door = (float)lum_random_below(r, (uint32_t)bays);
    add(s, shape);
    const float door = x + (shape.opening.door + 0.3f) * shape.opening.bay;
    add_box(s, door, s->side * (LUM_HOUSES_Y + setback - 0.25f), LUM_PAVEMENT_Z,
            0.4f * shape.opening.bay, 0.5f, 0.16f, 0.4f);
    /* Some houses have bay windows on their upper floors. */
    if (lum_random_below(r, 3) == 0) {
        add_box(s, x + shape.opening.bay,
                s->side * (LUM_HOUSES_Y + setback - 0.3f), 3.3f,
                shape.opening.bay, 1.0f, 5.5f, 0.5f);
    }
}

/* --- Places --- */

float lum_things_wrap(double x, double low, double high)
{
    const double span = high - low;
    return (float)(x - span * floor((x - low) / span));
}
