#include "street.h"

#include "random.h"

#include <math.h>
#include <stddef.h>

/* Across the street, from its middle: two lanes, parked cars, the kerb, the
 * pavement, the houses. Metres. */
#define LANE_Y     1.75f
#define PARKING_Y  4.6f
#define KERB_Y     5.7f
#define WALK_Y     8.0f
#define HOUSES_Y   10.0f
#define PAVEMENT_Z 0.13f

#define LOT_M        24.0
#define LOTS_A_BLOCK 6 /* a side street opens once a block */
#define BEHIND_M     40.0
#define AHEAD_M      260.0
#define CROWN_LEAVES 260

/* Streams of random numbers. */
enum {
    STREAM_LOT = 1
};

typedef struct street {
    lum_shape_list *list;
    lum_random random;
    float x;    /* where the lot or the thing at hand begins */
    float y;    /* the middle of the street */
    float z;    /* the road */
    float side; /* +1 left, -1 right */
    double time_s;
    double ahead_m; /* the sensor, of its place in the drive */
} street;

/* --- Shapes --- */

static void add(const street *s, lum_shape shape)
{
    const float at[3] = {s->x, s->y, s->z};
    for (int i = 0; i < 3; i++) {
        shape.min[i] += at[i];
        shape.max[i] += at[i];
    }
    if (shape.max[0] > -(float)BEHIND_M && shape.min[0] < (float)AHEAD_M) {
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

static void add_box(const street *s, float x, float y, float z, float length,
                    float width, float height, float reflectivity)
{
    const float from[3] = {x, y - 0.5f * width, z};
    const float size[3] = {length, width, height};
    add(s, box(LUM_SHAPE_BOX, from, size, reflectivity));
}

static void add_pillar(const street *s, float x, float y, float z, float radius,
                       float height, float reflectivity)
{
    const float from[3] = {x - radius, y - radius, z};
    const float size[3] = {2.0f * radius, 2.0f * radius, height};
    add(s, box(LUM_SHAPE_PILLAR, from, size, reflectivity));
}

static void add_wheel(const street *s, float x, float y, float radius,
                      float width)
{
    const float from[3] = {x - radius, y - 0.5f * width, 0.0f};
    const float size[3] = {2.0f * radius, width, 2.0f * radius};
    add(s, box(LUM_SHAPE_WHEEL, from, size, 0.1f));
}

static void add_ball(const street *s, lum_shape_kind kind, const float at[3],
                     float radius, float reflectivity, float cover)
{
    const float from[3] = {at[0] - radius, at[1] - radius, at[2] - radius};
    const float size[3] = {2.0f * radius, 2.0f * radius, 2.0f * radius};
    lum_shape shape = box(kind, from, size, reflectivity);
    shape.cover = cover;
    add(s, shape);
}

/* --- Things of a street --- */

/* Leaves in an ellipsoid about (x, y, z). */
static void add_crown(street *s, const float at[3], const float radius[3],
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

static void add_tree(street *s, float x, float y)
{
    lum_random *r = &s->random;
    const float width = lum_random_between(r, 1.3f, 2.0f);
    const float height = lum_random_between(r, 1.4f, 2.1f);
    const float bottom = lum_random_between(r, 1.4f, 2.0f);
    const float at[3] = {x, y, bottom + height};
    const float radius[3] = {width, width, height};
    add_pillar(s, x, y, PAVEMENT_Z, lum_random_between(r, 0.1f, 0.18f),
               bottom + 0.8f, 0.3f);
    add_crown(s, at, radius, CROWN_LEAVES);
}

static void add_bush(street *s, float x, float y)
{
    const float at[3] = {x, y, 0.75f};
    const float radius[3] = {0.85f, 0.5f, 0.65f};
    add_crown(s, at, radius, 60);
}

static void add_lamp(street *s, float x, float y)
{
    const float arm = y > 0.0f ? -0.7f : 0.7f;
    add_pillar(s, x, y, PAVEMENT_Z, 0.09f, 6.0f, 0.35f);
    add_pillar(s, x, y, PAVEMENT_Z, 0.16f, 0.9f, 0.35f);
    add_box(s, x - 0.05f, y + arm, 5.9f, 0.1f, 1.4f, 0.1f, 0.35f);
}

static void add_sign(street *s, float x, float y)
{
    add_pillar(s, x, y, PAVEMENT_Z, 0.05f, 2.5f, 0.5f);
    add_box(s, x - 0.07f, y, 1.95f, 0.02f, 0.7f, 0.7f, 1.0f);
}

static void add_bin(street *s, float x, float y)
{
    add_pillar(s, x, y, PAVEMENT_Z, 0.28f, 1.0f, 0.2f);
}

/* Two legs in mid-stride, a body, a head. */
static void add_person(street *s, float x, float y, float z, float speed)
{
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

static void add_wheels(street *s, float x, float y, float length, float width,
                       float radius)
{
    for (int i = 0; i < 4; i++) {
        const float along = (i & 1) ? length * 0.8f : length * 0.18f;
        const float across = (i & 2) ? 0.5f * width : -0.5f * width;
        add_wheel(s, x + along, y + across * 0.92f, radius, 0.24f);
    }
}

static void add_cabin(street *s, const float from[3], const float size[3],
                      lum_shape_lean lean, float reflectivity)
{
    lum_shape shape = box(LUM_SHAPE_CABIN, from, size, reflectivity);
    shape.lean = lean;
    add(s, shape);
}

/* Vehicles begin at x and face +x when facing is 1, -x when it is -1. */
static void add_car(street *s, float x, float y, float facing, float paint)
{
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

static void add_van(street *s, float x, float y, float facing, float paint)
{
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

static void add_truck(street *s, float x, float y, float facing, float paint)
{
    const float cargo = facing > 0.0f ? x : x + 2.2f;
    const float cab = facing > 0.0f ? x + 6.2f : x;
    add_box(s, cargo, y, 1.0f, 6.0f, 2.5f, 2.6f, paint);
    add_box(s, x, y, 0.7f, 8.0f, 0.9f, 0.3f, 0.2f);
    add_box(s, cab, y, 0.5f, 1.9f, 2.4f, 2.3f, 0.45f);
    add_wheels(s, x, y, 8.0f, 2.4f, 0.5f);
}

static void add_cyclist(street *s, float x, float y, float facing, float paint)
{
    (void)facing;
    const float head[3] = {x + 1.05f, y, 1.7f};
    add_wheel(s, x + 0.33f, y, 0.33f, 0.06f);
    add_wheel(s, x + 1.37f, y, 0.33f, 0.06f);
    add_box(s, x + 0.35f, y, 0.5f, 1.0f, 0.08f, 0.2f, 0.3f);
    add_pillar(s, x + 0.75f, y, 0.5f, 0.12f, 0.5f, 0.3f);
    add_pillar(s, x + 0.9f, y, 0.95f, 0.19f, 0.6f, paint);
    add_ball(s, LUM_SHAPE_BALL, head, 0.14f, 0.5f, 1.0f);
}

/* --- Houses and side streets --- */

/* Parking, one place after the other. */
static void add_parked(street *s, bool side_street)
{
    lum_random *r = &s->random;
    for (int place = 0; place < 4; place++) {
        const float x = 6.0f * (float)place + lum_random_between(r, 0.2f, 0.9f);
        const float shift = lum_random_between(r, -0.12f, 0.12f);
        const float paint = lum_random_between(r, 0.15f, 0.8f);
        const uint32_t kind = lum_random_below(r, 10);
        if (kind > 6 || (side_street && (place == 1 || place == 2))) {
            continue;
        }
        (kind == 6 ? add_van : add_car)(s, x, s->side * (PARKING_Y + shift),
                                        -s->side, paint);
    }
}

static void add_facade(street *s, float x, float length, float setback)
{
    lum_random *r = &s->random;
    const float depth = 12.0f;
    const float bays = floorf(length / lum_random_between(r, 2.3f, 3.3f));
    const float y = s->side * (HOUSES_Y + setback + 0.5f * depth);
    const float from[3] = {x, y - 0.5f * depth, PAVEMENT_Z};
    const float size[3] = {length, depth, lum_random_between(r, 8.0f, 17.0f)};
    lum_shape shape =
        box(LUM_SHAPE_FACADE, from, size, lum_random_between(r, 0.3f, 0.75f));
    shape.opening.bay = length / bays;
    shape.opening.storey = 3.2f;
    shape.opening.recess = 0.35f;
    shape.opening.door = (float)lum_random_below(r, (uint32_t)bays);
    add(s, shape);
    const float door = x + (shape.opening.door + 0.3f) * shape.opening.bay;
    add_box(s, door, s->side * (HOUSES_Y + setback - 0.25f), PAVEMENT_Z,
            0.4f * shape.opening.bay, 0.5f, 0.16f, 0.4f);
    /* Some houses have bay windows on their upper floors. */
    if (lum_random_below(r, 3) == 0) {
        add_box(s, x + shape.opening.bay, s->side * (HOUSES_Y + setback - 0.3f),
                3.3f, shape.opening.bay, 1.0f, 5.5f, 0.5f);
    }
}

static void add_garden(street *s)
{
    lum_random *r = &s->random;
    for (int i = 0; i < 12; i++) {
        add_bush(s, 1.0f + 2.0f * (float)i, s->side * (HOUSES_Y - 0.2f));
    }
    for (int i = 0; i < 3; i++) {
        add_tree(s, 4.0f + 8.0f * (float)i,
                 s->side * (HOUSES_Y + lum_random_between(r, 3.0f, 5.0f)));
    }
    add_facade(s, 2.0f, 20.0f, 9.0f);
}

/* The gap between two blocks: a street that ends at a house far back. */
static void add_side_street(street *s)
{
    add_facade(s, 0.0f, 7.0f, 0.0f);
    add_facade(s, 17.0f, 7.0f, 0.0f);
    add_facade(s, 5.0f, 14.0f, 34.0f);
    add_sign(s, 6.6f, s->side * 6.2f);
    add_sign(s, 17.6f, s->side * 6.2f);
    add_car(s, 10.2f, s->side * 24.0f, 1.0f, 0.6f);
}

static void add_houses(street *s, bool side_street)
{
    lum_random *r = &s->random;
    const uint32_t kind = lum_random_below(r, 10);
    const float setback = lum_random_between(r, 0.0f, 0.8f);
    const float split = lum_random_between(r, 9.0f, 15.0f);
    if (side_street) {
        add_side_street(s);
    } else if (kind < 2) {
        add_garden(s);
    } else if (kind < 6) {
        add_facade(s, 0.0f, (float)LOT_M, setback);
    } else {
        add_facade(s, 0.0f, split, setback);
        add_facade(s, split, (float)LOT_M - split, 0.0f);
    }
}

/* --- People and furniture, by the lots of the street --- */

static float wrap(double x, double low, double high)
{
    const double span = high - low;
    return (float)(x - span * floor((x - low) / span));
}

static void add_walkers(street *s)
{
    lum_random *r = &s->random;
    for (int i = 0; i < 2; i++) {
        const float x = lum_random_between(r, 0.0f, (float)LOT_M);
        const float y =
            s->side * lum_random_between(r, WALK_Y - 0.9f, HOUSES_Y - 0.9f);
        const uint32_t kind = lum_random_below(r, 6);
        const float speed = kind == 0 ? 0.0f : kind < 3 ? 1.3f : -1.2f;
        if (kind < 4) {
            add_person(s, wrap((double)x + (double)speed * s->time_s, 0, LOT_M),
                       y, PAVEMENT_Z, speed);
        }
    }
}

static void add_furniture(street *s, bool side_street)
{
    lum_random *r = &s->random;
    const float y = s->side * (KERB_Y + 0.7f);
    static const float trees[2] = {3.0f, 20.5f};
    for (int i = 0; i < 2; i++) {
        if (lum_random_below(r, 10) < 7) {
            add_tree(s, trees[i], y);
        }
    }
    if (!side_street) {
        add_lamp(s, 12.0f, y);
    }
    if (lum_random_below(r, 3) == 0) {
        add_bin(s, 14.0f, y);
    }
    if (lum_random_below(r, 5) == 0) {
        add_sign(s, 8.0f, s->side * (KERB_Y + 0.5f));
    }
    if (lum_random_below(r, 3) == 0) {
        for (int i = 0; i < 4; i++) {
            add_pillar(s, 5.5f + 1.6f * (float)i, s->side * (KERB_Y + 0.3f),
                       PAVEMENT_Z, 0.08f, 0.9f, 0.5f);
        }
    }
}

static void add_lot(street *s, uint64_t seed, int64_t lot, unsigned side)
{
    const bool side_street =
        (lot % LOTS_A_BLOCK + LOTS_A_BLOCK) % LOTS_A_BLOCK == 3;
    lum_random_init(&s->random, seed,
                    ((uint64_t)lot << 16) | (side << 8) | STREAM_LOT);
    s->side = side == 0 ? 1.0f : -1.0f;
    add_houses(s, side_street);
    add_furniture(s, side_street);
    add_parked(s, side_street);
    add_walkers(s);
}

typedef struct mover {
    void (*add)(street *s, float x, float y, float facing, float paint);
    float x;     /* ahead of the sensor when the drive begins */
    float y;     /* across, from the middle of the street */
    float speed; /* m/s along the street */
    float paint;
} mover;

static const mover movers[] = {
    {add_car, 15.0f, -LANE_Y, 5.0f, 0.7f},
    {add_truck, 62.0f, -LANE_Y, 5.0f, 0.6f},
    {add_car, 110.0f, -LANE_Y, 5.0f, 0.3f},
    {add_cyclist, 9.5f, -3.45f, 4.4f, 0.8f},
    {add_car, 26.0f, LANE_Y, -8.0f, 0.35f},
    {add_van, 52.0f, LANE_Y, -8.0f, 0.75f},
    {add_car, 94.0f, LANE_Y, -8.0f, 0.5f},
    {add_truck, 150.0f, LANE_Y, -8.0f, 0.4f},
    {add_car, 215.0f, LANE_Y, -8.0f, 0.6f},
};

/* --- The whole street --- */

static void add_movers(street *s)
{
    for (size_t i = 0; i < sizeof movers / sizeof movers[0]; i++) {
        const mover *m = &movers[i];
        const double along =
            ((double)m->speed - LUM_STREET_SENSOR_SPEED) * s->time_s -
            s->ahead_m;
        s->x = wrap((double)m->x + along, -BEHIND_M, AHEAD_M);
        m->add(s, 0.0f, m->y, m->speed > 0.0f ? 1.0f : -1.0f, m->paint);
    }
}

/* People who cross the road ahead, to and fro. */
static void add_crossing(street *s, float x)
{
    const float y = wrap(1.3 * s->time_s, -KERB_Y, KERB_Y);
    s->x = x;
    add_person(s, 1.2f, y, 0.0f, 1.0f);
    add_person(s, 2.4f, -y * 0.8f, 0.0f, 1.0f);
}

void lum_street_lay_out(uint64_t seed, double time_s, double ahead_m,
                        const float eye[3], lum_shape_list *out,
                        lum_ground *ground)
{
    const double x = LUM_STREET_SENSOR_SPEED * time_s + ahead_m;
    const int64_t first = (int64_t)floor((x - BEHIND_M) / LOT_M);
    const int64_t last = (int64_t)floor((x + AHEAD_M) / LOT_M);
    const double block = LOT_M * LOTS_A_BLOCK;
    street s = {.list = out,
                .y = LANE_Y - eye[1],
                .z = (float)-LUM_STREET_SENSOR_HEIGHT - eye[2],
                .time_s = time_s,
                .ahead_m = ahead_m};
    out->count = 0;
    for (int64_t lot = first; lot <= last; lot++) {
        s.x = (float)((double)lot * LOT_M - x) - eye[0];
        add_lot(&s, seed, lot, 0);
        add_lot(&s, seed, lot, 1);
    }
    ground->is_there = true;
    ground->road_z = s.z;
    ground->pavement_z = s.z + PAVEMENT_Z;
    ground->kerb_right_y = s.y - KERB_Y;
    ground->kerb_left_y = s.y + KERB_Y;
    ground->marks_x = wrap(-x, -6.0, 0.0) - eye[0];
    ground->crossing_x = wrap(21.0 - x, 0.0, block) - eye[0];
    add_crossing(&s, ground->crossing_x);
    add_movers(&s);
}

/* --- The ground --- */

/* Paint on the road returns more light than asphalt. */
static float road_reflectivity(const lum_ground *g, float x, float y)
{
    const float middle = 0.5f * (g->kerb_left_y + g->kerb_right_y);
    const float across = y - middle;
    const float dash = (x - g->marks_x) / 6.0f;
    const float zebra = x - g->crossing_x;
    if (zebra > 0.0f && zebra < 3.5f) {
        return across - floorf(across) < 0.5f ? 0.75f : 0.18f;
    }
    if (fabsf(across) < 0.08f && dash - floorf(dash) < 0.5f) {
        return 0.75f;
    }
    return 0.18f;
}

/* A low ray reaches the road over a pavement, hits a kerb's face, or comes from
 * above; both kerbs are between the same two heights. */
bool lum_ground_cast(const lum_ground *g, const lum_ray *ray, lum_hit *hit)
{
    if (!g->is_there || ray->d[2] >= 0.0f) {
        return false;
    }
    const float high = g->pavement_z * ray->inverse[2];
    const float y = high * ray->d[1];
    const bool on_road = y > g->kerb_right_y && y < g->kerb_left_y;
    const float kerb = ray->d[1] > 0.0f ? g->kerb_left_y : g->kerb_right_y;
    const float face = kerb * ray->inverse[1];
    const float low = g->road_z * ray->inverse[2];
    hit->cover = 1.0f;
    hit->cosine = -ray->d[2];
    hit->bias = 0.0f;
    if (!on_road) {
        hit->range = high;
        hit->reflectivity = 0.3f;
    } else if (face > high && face < low) {
        hit->range = face;
        hit->reflectivity = 0.35f;
        hit->cosine = fabsf(ray->d[1]);
    } else {
        hit->range = low;
        hit->reflectivity =
            road_reflectivity(g, low * ray->d[0], low * ray->d[1]);
    }
    return hit->range > LUM_SHAPE_NEAREST && hit->range < LUM_STREET_REACH;
}
