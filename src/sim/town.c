#include "town.h"

#include "rotation.h"
#include "things.h"

#include <math.h>

/* The lanes of the way round the block: a rectangle, and its turns. Metres. */
#define WEST_X   (-30.0)
#define EAST_X   170.0
#define NORTH_Y  0.0
#define SOUTH_Y  (-110.0)
#define TURN_M   8.0
#define HEIGHT_M 1.8
#define QUARTER  (0.25 * LUM_FULL_TURN)

/* Middles of streets. */
#define LANE     1.75
#define NORTH    (NORTH_Y + LANE)
#define SOUTH    (SOUTH_Y - LANE)
#define WEST     (WEST_X - LANE)
#define EAST     (EAST_X + LANE)
#define MIDDLE_X (0.5 * (WEST + EAST))

/* How far streets go on behind the last crossing: what comes and goes there is
 * out of sight. */
#define BEYOND_M 260.0

/* From the middle of a crossing to the first lot: of streets along x, and of
 * those along y, which begin behind the houses of the others. */
#define CORNER_M      10.0
#define SECOND_ROW_M  22.5
#define LOT_M         24.0
#define HOUSES_HIGH_M 20.0

/* Vehicles drive the other way round in the outer lanes. Their distance is a
 * part of the way round, and half of it is between those of streets that cross,
 * so that none meets another there. */
#define SPEED       8.0
#define LOOP_M      (2.0 * (EAST - WEST + NORTH - SOUTH + 4.0 * LANE))
#define LOOPS       5.0
#define DISTANCE_M  (LOOP_M / LOOPS)
#define WALK_M_S    1.25
#define LOT_OBJECTS 128u
#define FIRST_LOT   0x10000u
#define FIRST_MOVER 0x10000000u
#define STREAM_TOWN 6u
#define STREET_LOTS 256u

/* --- Streets --- */

typedef struct road {
    double from[2]; /* where it begins, its middle */
    double length;
    bool is_turned; /* along y */
} road;

#define ROADS 5u

static const double streets_y[2] = {NORTH, SOUTH};
static const double streets_x[3] = {WEST, MIDDLE_X, EAST};

static const road roads[ROADS] = {
    {{WEST - BEYOND_M, NORTH}, EAST - WEST + 2.0 * BEYOND_M, false},
    {{WEST - BEYOND_M, SOUTH}, EAST - WEST + 2.0 * BEYOND_M, false},
    {{WEST, SOUTH - BEYOND_M}, NORTH - SOUTH + 2.0 * BEYOND_M, true},
    {{MIDDLE_X, SOUTH - BEYOND_M}, NORTH - SOUTH + 2.0 * BEYOND_M, true},
    {{EAST, SOUTH - BEYOND_M}, NORTH - SOUTH + 2.0 * BEYOND_M, true},
};

static double place_on(const road *way, const double at[3], double along,
                       int axis)
{
    const bool is_along = (axis == 1) == way->is_turned;
    return way->from[axis] + (is_along ? along : 0.0) - at[axis];
}

/* Things are added from here on. */
static void stand(lum_things *s, const road *way, const double at[3],
                  double along)
{
    s->is_turned = way->is_turned;
    for (int i = 0; i < 2; i++) {
        s->origin[i] = (float)place_on(way, at, along, i);
    }
}

/* --- Lots --- */

static void add_houses(lum_things *s, float length)
{
    lum_random *r = &s->random;
    const uint32_t kind = lum_random_below(r, 10);
    const float setback = lum_random_between(r, 0.0f, 0.8f);
    const float split = length * lum_random_between(r, 0.4f, 0.6f);
    if (kind < 2) {
        for (int i = 0; 2.0f * (float)i < length - 2.0f; i++) {
            lum_things_add_bush(s, 1.0f + 2.0f * (float)i,
                                s->side * (LUM_HOUSES_Y - 0.2f));
        }
        lum_things_add_tree(s, 0.3f * length, s->side * 14.0f);
        lum_things_add_tree(s, 0.7f * length, s->side * 15.0f);
        lum_things_add_facade(s, 2.0f, length - 4.0f, 9.0f);
    } else if (kind < 5) {
        lum_things_add_facade(s, 0.0f, length, setback);
    } else {
        lum_things_add_facade(s, 0.0f, split, setback);
        lum_things_add_facade(s, split, length - split, 0.0f);
    }
}

static void add_furniture(lum_things *s, float length)
{
    lum_random *r = &s->random;
    const float y = s->side * (LUM_ROAD_HALF + 0.7f);
    for (int i = 0; i < 2; i++) {
        if (lum_random_below(r, 10) < 6) {
            lum_things_add_tree(s, i == 0 ? 3.0f : length - 3.5f, y);
        }
    }
    lum_things_add_lamp(s, 0.5f * length, y);
    if (lum_random_below(r, 3) == 0) {
        lum_things_add_bin(s, 0.5f * length + 2.0f, y);
    }
    if (lum_random_below(r, 3) == 0) {
        lum_things_add_sign(s, 8.0f, s->side * (LUM_ROAD_HALF + 0.5f));
    }
    if (lum_random_below(r, 4) == 0) {
        lum_things_add_posts(s, 5.5f);
    }
}

static void add_parked(lum_things *s, float length)
{
    lum_random *r = &s->random;
    for (int i = 0; 6.0f * (float)(i + 1) < length; i++) {
        const float x = 6.0f * (float)i + lum_random_between(r, 0.2f, 0.7f);
        const float shift = lum_random_between(r, -0.12f, 0.12f);
        const float paint = lum_random_between(r, 0.15f, 0.8f);
        const uint32_t kind = lum_random_below(r, 10);
        if (kind < 6) {
            (kind == 5 ? lum_things_add_van : lum_things_add_car)(
                s, x, s->side * (LUM_PARKING_Y + shift), -s->side, paint);
        }
    }
}

/* To and fro, from `begin` on. */
static void add_walker(lum_things *s, float length, float begin, float y)
{
    const double way = (double)length - 2.0;
    const float there =
        lum_things_wrap((double)begin + WALK_M_S * s->time_s, 0.0, 2.0 * way);
    const bool is_back = (double)there > way;
    s->velocity[0] = (float)(is_back ? -WALK_M_S : WALK_M_S);
    lum_things_add_person(s,
                          1.0f + (is_back ? (float)(2.0 * way) - there : there),
                          y, LUM_PAVEMENT_Z, s->velocity[0]);
    s->velocity[0] = 0.0f;
}

static void add_people(lum_things *s, float length)
{
    lum_random *r = &s->random;
    for (int i = 0; i < 2; i++) {
        const float x = lum_random_between(r, 0.0f, length);
        const float y = s->side * lum_random_between(r, LUM_WALK_Y - 0.6f,
                                                     LUM_HOUSES_Y - 0.9f);
        const uint32_t kind = lum_random_below(r, 6);
        if (kind == 0) {
            lum_things_add_person(s, x, y, LUM_PAVEMENT_Z, 0.0f);
        } else if (kind < 4) {
            add_walker(s, length, x, y);
        }
    }
}

static void add_lot(lum_things *s, uint64_t seed, uint32_t number, float length)
{
    lum_random_init(&s->random, seed, ((uint64_t)number << 8) | STREAM_TOWN);
    s->object = FIRST_LOT + number * LOT_OBJECTS;
    add_houses(s, length);
    add_furniture(s, length);
    add_parked(s, length);
    add_people(s, length);
}

/* --- Rows of lots between two crossings --- */

/* Whether something of a lot may be in sight: the middle of the street there is
 * not farther from it than this. */
static bool is_near(const lum_things *s, float length)
{
    const float most = 0.5f * length + 35.0f;
    const float half = 0.5f * length;
    const float x = s->origin[0] + (s->is_turned ? 0.0f : half);
    const float y = s->origin[1] + (s->is_turned ? half : 0.0f);
    return fabsf(x) < LUM_STREET_REACH + most &&
           fabsf(y) < LUM_STREET_REACH + most &&
           lum_view_has(s->view, x, y, most);
}

static void add_row(lum_things *s, uint64_t seed, uint32_t number,
                    const double at[3], double from, double to)
{
    const road *way = &roads[number / STREET_LOTS];
    const uint32_t count = (uint32_t)((to - from) / LOT_M);
    const double length = (to - from) / count;
    for (uint32_t i = 0; i < count; i++) {
        stand(s, way, at, from + i * length);
        for (unsigned side = 0; side < 2 && is_near(s, (float)length); side++) {
            s->side = side == 0 ? 1.0f : -1.0f;
            add_lot(s, seed, number + 2u * i + side, (float)length);
        }
    }
}

static void add_street(lum_things *s, uint64_t seed, unsigned n,
                       const double at[3])
{
    const road *way = &roads[n];
    const double *crossings = way->is_turned ? streets_y : streets_x;
    const int count = way->is_turned ? 2 : 3;
    const double margin = way->is_turned ? SECOND_ROW_M : CORNER_M;
    const double begin = way->from[way->is_turned ? 1 : 0];
    double from = 0.0;
    for (int i = 0; i <= count; i++) {
        /* From south to north they are counted the other way. */
        const int next = way->is_turned ? count - 1 - i : i;
        const double to =
            i < count ? crossings[next] - begin - margin : way->length;
        add_row(s, seed, n * STREET_LOTS + 48u * (uint32_t)i, at, from, to);
        from = to + 2.0 * margin;
    }
}

/* --- Vehicles --- */

/* One that comes round again is another one. The way round: south, east, north,
 * west. Each begins where it crosses the one before it, half a distance later
 * than what comes along there. */
static void add_flow(lum_things *s, unsigned n, const double at[3])
{
    static const struct {
        unsigned road;
        float facing;
    } flows[4] = {{1, 1.0f}, {4, 1.0f}, {0, -1.0f}, {2, -1.0f}};
    static const float paints[3] = {0.35f, 0.7f, 0.5f};
    const road *way = &roads[flows[n].road];
    const double before = n == 0   ? 0.0
                          : n == 1 ? EAST - WEST + 2.0 * LANE
                          : n == 2 ? LOOP_M / 2.0
                                   : LOOP_M / 2.0 + EAST - WEST + 2.0 * LANE;
    /* The crossing where it begins is this far from the end that it comes
     * from; there it is when it has driven `before`, and half a distance. */
    const double begin = BEYOND_M - LANE;
    const double span = DISTANCE_M * ceil((way->length + 20.0) / DISTANCE_M);
    const uint32_t count = (uint32_t)(span / DISTANCE_M + 0.5);
    for (uint32_t i = 0; i < count; i++) {
        const double driven = begin - before - (n % 2u) * 0.5 * DISTANCE_M +
                              (double)i * DISTANCE_M + SPEED * s->time_s;
        const double round = floor(driven / span) + 1.0;
        const double x = (double)lum_things_wrap(driven, 0.0, span);
        const double along = flows[n].facing > 0.0f ? x : way->length - x;
        const float y = -flows[n].facing * LUM_LANE_Y;
        stand(s, way, at, along);
        s->velocity[0] = (float)(SPEED * (double)flows[n].facing);
        s->object = FIRST_MOVER + 4u * ((uint32_t)round * count + i) + n;
        (i % 4u == 3u ? lum_things_add_van : lum_things_add_car)(
            s, 0.0f, y, flows[n].facing, paints[i % 3u]);
    }
    s->velocity[0] = 0.0f;
}

/* --- The whole town --- */

lum_course lum_town_circuit(void)
{
    static const lum_path_piece pieces[] = {
        {EAST_X - TURN_M, 0.0},
        {QUARTER * TURN_M, -TURN_M},
        {NORTH_Y - SOUTH_Y - 2.0 * TURN_M, 0.0},
        {QUARTER * TURN_M, -TURN_M},
        {EAST_X - WEST_X - 2.0 * TURN_M, 0.0},
        {QUARTER * TURN_M, -TURN_M},
        {NORTH_Y - SOUTH_Y - 2.0 * TURN_M, 0.0},
        {QUARTER * TURN_M, -TURN_M},
        {-WEST_X - TURN_M, 0.0}};
    return (lum_course){.at = {0.0, NORTH_Y, HEIGHT_M},
                        .pieces = pieces,
                        .count = sizeof pieces / sizeof pieces[0]};
}

bool lum_town_is_open(const double at[3], double margin_m)
{
    const double free = (double)LUM_HOUSES_Y - margin_m;
    bool is_in_street = at[2] >= HOUSES_HIGH_M + margin_m;
    for (int i = 0; i < 2; i++) {
        is_in_street = is_in_street || fabs(at[1] - streets_y[i]) <= free;
    }
    for (int i = 0; i < 3; i++) {
        is_in_street = is_in_street || fabs(at[0] - streets_x[i]) <= free;
    }
    return is_in_street && at[2] >= margin_m;
}

static void set_ground(const double at[3], lum_ground *out)
{
    *out =
        (lum_ground){.is_there = true,
                     .road_z = (float)-at[2],
                     .pavement_z = LUM_PAVEMENT_Z - (float)at[2],
                     .marks_x = lum_things_wrap(-at[0], -6.0, 0.0),
                     .roads = {.count = {2, 3},
                               .marks_y = lum_things_wrap(-at[1], -6.0, 0.0)}};
    for (int i = 0; i < 2; i++) {
        out->roads.middle[0][i] = (float)(streets_y[i] - at[1]);
    }
    for (int i = 0; i < 3; i++) {
        out->roads.middle[1][i] = (float)(streets_x[i] - at[0]);
    }
}

void lum_town_lay_out(uint64_t seed, double time_s, const lum_sight_view *view,
                      lum_shape_list *out, lum_ground *ground)
{
    const double *at = view->at;
    lum_things s = {.list = out,
                    .z = (float)-at[2],
                    .time_s = time_s,
                    .low = {-LUM_STREET_REACH, -LUM_STREET_REACH},
                    .high = {LUM_STREET_REACH, LUM_STREET_REACH},
                    .view = view};
    out->count = 0;
    for (unsigned n = 0; n < ROADS; n++) {
        add_street(&s, seed, n, at);
    }
    for (unsigned n = 0; n < 4; n++) {
        add_flow(&s, n, at);
    }
    set_ground(at, ground);
}
