#include "street.h"

#include "things.h"

#include <math.h>
#include <stddef.h>

#define LOT_M        24.0
#define LOTS_A_BLOCK 6 /* a side street opens once a block */
#define BEHIND_M     40.0
#define AHEAD_M      260.0
#define FAR_M        1e6f /* across, all is there */

/* Numbers of objects: of a lot, of a vehicle, of people who cross. */
#define LOT_OBJECTS      128
#define FIRST_LOT        0x10000000
#define FIRST_VEHICLE    0x20000000
#define FIRST_CROSSING   0x30000000
#define OBJECTS_FROM_MID 0x08000000

/* Streams of random numbers. */
enum {
    STREAM_LOT = 1
};

/* --- Houses and side streets --- */

/* Parking, one place after the other. */
static void add_parked(lum_things *s, bool side_street)
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
        (kind == 6 ? lum_things_add_van : lum_things_add_car)(
            s, x, s->side * (LUM_PARKING_Y + shift), -s->side, paint);
    }
}

static void add_garden(lum_things *s)
{
    lum_random *r = &s->random;
    for (int i = 0; i < 12; i++) {
        lum_things_add_bush(s, 1.0f + 2.0f * (float)i,
                            s->side * (LUM_HOUSES_Y - 0.2f));
    }
    for (int i = 0; i < 3; i++) {
        lum_things_add_tree(
            s, 4.0f + 8.0f * (float)i,
            s->side * (LUM_HOUSES_Y + lum_random_between(r, 3.0f, 5.0f)));
    }
    lum_things_add_facade(s, 2.0f, 20.0f, 9.0f);
}

/* The gap between two blocks: a street that ends at a house far back. */
static void add_side_street(lum_things *s)
{
    lum_things_add_facade(s, 0.0f, 7.0f, 0.0f);
    lum_things_add_facade(s, 17.0f, 7.0f, 0.0f);
    lum_things_add_facade(s, 5.0f, 14.0f, 34.0f);
    lum_things_add_sign(s, 6.6f, s->side * 6.2f);
    lum_things_add_sign(s, 17.6f, s->side * 6.2f);
    lum_things_add_car(s, 10.2f, s->side * 24.0f, 1.0f, 0.6f);
}

static void add_houses(lum_things *s, bool side_street)
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
        lum_things_add_facade(s, 0.0f, (float)LOT_M, setback);
    } else {
        lum_things_add_facade(s, 0.0f, split, setback);
        lum_things_add_facade(s, split, (float)LOT_M - split, 0.0f);
    }
}

/* --- People and furniture, by the lots of the street --- */

static void add_walkers(lum_things *s)
{
    lum_random *r = &s->random;
    for (int i = 0; i < 2; i++) {
        const float x = lum_random_between(r, 0.0f, (float)LOT_M);
        const float y = s->side * lum_random_between(r, LUM_WALK_Y - 0.9f,
                                                     LUM_HOUSES_Y - 0.9f);
        const uint32_t kind = lum_random_below(r, 6);
        const float speed = kind == 0 ? 0.0f : kind < 3 ? 1.3f : -1.2f;
        if (kind < 4) {
            s->velocity[0] = speed;
            lum_things_add_person(
                s,
                lum_things_wrap((double)x + (double)speed * s->time_s, 0,
                                LOT_M),
                y, LUM_PAVEMENT_Z, speed);
            s->velocity[0] = 0.0f;
        }
    }
}

static void add_furniture(lum_things *s, bool side_street)
{
    lum_random *r = &s->random;
    const float y = s->side * (LUM_ROAD_HALF + 0.7f);
    static const float trees[2] = {3.0f, 20.5f};
    for (int i = 0; i < 2; i++) {
        if (lum_random_below(r, 10) < 7) {
            lum_things_add_tree(s, trees[i], y);
        }
    }
    if (!side_street) {
        lum_things_add_lamp(s, 12.0f, y);
    }
    if (lum_random_below(r, 3) == 0) {
        lum_things_add_bin(s, 14.0f, y);
    }
    if (lum_random_below(r, 5) == 0) {
        lum_things_add_sign(s, 8.0f, s->side * (LUM_ROAD_HALF + 0.5f));
    }
    if (lum_random_below(r, 3) == 0) {
        lum_things_add_posts(s, 5.5f);
    }
}

/* A number that is the same from wherever the sensor looks. */
static uint32_t number_of(uint32_t first, int64_t at, int64_t each)
{
    return first + OBJECTS_FROM_MID + (uint32_t)(at * each);
}

static void add_lot(lum_things *s, uint64_t seed, int64_t lot, unsigned side)
{
    const bool side_street =
        (lot % LOTS_A_BLOCK + LOTS_A_BLOCK) % LOTS_A_BLOCK == 3;
    lum_random_init(&s->random, seed,
                    ((uint64_t)lot << 16) | (side << 8) | STREAM_LOT);
    s->side = side == 0 ? 1.0f : -1.0f;
    s->object = number_of(FIRST_LOT, 2 * lot + side, LOT_OBJECTS);
    add_houses(s, side_street);
    add_furniture(s, side_street);
    add_parked(s, side_street);
    add_walkers(s);
}

typedef struct mover {
    void (*add)(lum_things *s, float x, float y, float facing, float paint);
    float x;     /* ahead of the sensor when the drive begins */
    float y;     /* across, from the middle of the street */
    float speed; /* m/s along the street */
    float paint;
} mover;

static const mover movers[] = {
    {lum_things_add_car, 15.0f, -LUM_LANE_Y, 5.0f, 0.7f},
    {lum_things_add_truck, 62.0f, -LUM_LANE_Y, 5.0f, 0.6f},
    {lum_things_add_car, 110.0f, -LUM_LANE_Y, 5.0f, 0.3f},
    {lum_things_add_cyclist, 9.5f, -3.45f, 4.4f, 0.8f},
    {lum_things_add_car, 26.0f, LUM_LANE_Y, -8.0f, 0.35f},
    {lum_things_add_van, 52.0f, LUM_LANE_Y, -8.0f, 0.75f},
    {lum_things_add_car, 94.0f, LUM_LANE_Y, -8.0f, 0.5f},
    {lum_things_add_truck, 150.0f, LUM_LANE_Y, -8.0f, 0.4f},
    {lum_things_add_car, 215.0f, LUM_LANE_Y, -8.0f, 0.6f},
};

/* --- The whole street --- */

/* Whether it keeps its distance to the sensor. */
static bool keeps_distance(const lum_street_moment *at, const mover *m)
{
    return at->leads && (double)m->speed == LUM_STREET_SENSOR_SPEED;
}

static double along_of(const lum_street_moment *at, const mover *m)
{
    return keeps_distance(at, m)
               ? 0.0
               : ((double)m->speed - LUM_STREET_SENSOR_SPEED) * at->time_s -
                     at->ahead_m;
}

/* One that comes round again is another one. */
static void add_movers(lum_things *s, const lum_street_moment *at, float eye_x)
{
    const int64_t count = (int64_t)(sizeof movers / sizeof movers[0]);
    for (int64_t i = 0; i < count; i++) {
        const mover *m = &movers[i];
        const double x = (double)m->x + along_of(at, m);
        const double round = floor((x + BEHIND_M) / (AHEAD_M + BEHIND_M));
        s->x = lum_things_wrap(x, -BEHIND_M, AHEAD_M) - eye_x;
        s->velocity[0] = keeps_distance(at, m) ? (float)at->speed : m->speed;
        s->object =
            number_of(FIRST_VEHICLE, (int64_t)round, count) + (uint32_t)i;
        m->add(s, 0.0f, m->y, m->speed > 0.0f ? 1.0f : -1.0f, m->paint);
    }
    s->velocity[0] = 0.0f;
}

/* People who cross the road ahead, to and fro. */
static void add_crossing(lum_things *s, float x, int64_t block)
{
    const float speed = 1.3f;
    const float y =
        lum_things_wrap(1.3 * s->time_s, -LUM_ROAD_HALF, LUM_ROAD_HALF);
    s->x = x;
    s->object = number_of(FIRST_CROSSING, block, 2);
    s->velocity[1] = speed;
    lum_things_add_person(s, 1.2f, y, 0.0f, 1.0f);
    s->velocity[1] = -0.8f * speed;
    lum_things_add_person(s, 2.4f, -y * 0.8f, 0.0f, 1.0f);
    s->velocity[1] = 0.0f;
}

void lum_street_lay_out(uint64_t seed, const lum_street_moment *at,
                        const float eye[3], lum_shape_list *out,
                        lum_ground *ground)
{
    const double x = LUM_STREET_SENSOR_SPEED * at->time_s + at->ahead_m;
    const int64_t first = (int64_t)floor((x - BEHIND_M) / LOT_M);
    const int64_t last = (int64_t)floor((x + AHEAD_M) / LOT_M);
    const double block = LOT_M * LOTS_A_BLOCK;
    lum_things s = {.list = out,
                    .y = LUM_LANE_Y - eye[1],
                    .z = (float)-LUM_STREET_SENSOR_HEIGHT - eye[2],
                    .time_s = at->time_s,
                    .low = {(float)-BEHIND_M, -FAR_M},
                    .high = {(float)AHEAD_M, FAR_M}};
    out->count = 0;
    for (int64_t lot = first; lot <= last; lot++) {
        s.x = (float)((double)lot * LOT_M - x) - eye[0];
        add_lot(&s, seed, lot, 0);
        add_lot(&s, seed, lot, 1);
    }
    *ground = (lum_ground){.is_there = true};
    ground->road_z = s.z;
    ground->pavement_z = s.z + LUM_PAVEMENT_Z;
    ground->kerb_right_y = s.y - LUM_ROAD_HALF;
    ground->kerb_left_y = s.y + LUM_ROAD_HALF;
    ground->marks_x = lum_things_wrap(-x, -6.0, 0.0) - eye[0];
    ground->crossing_x = lum_things_wrap(21.0 - x, 0.0, block) - eye[0];
    add_crossing(&s, ground->crossing_x, (int64_t)floor((x - 21.0) / block));
    add_movers(&s, at, eye[0]);
}
