#include "place.h"

#include "blocks.h"
#include "random.h"
#include "rotation.h"
#include "town.h"

#include <math.h>
#include <string.h>

/* Across the street, from the lane of the sensor: what is free of houses; and
 * up, from the road. Metres. */
#define STREET_RIGHT_M (-7.5)
#define STREET_LEFT_M  11.0
#define STREET_HIGH_M  30.0

/* What the usual heights above the floor of a room and a yard are. */
#define ROOM_Z 1.2
#define YARD_Z 1.5

/* --- Where the sensor stands --- */

lum_stance lum_place_usual_pose(lum_place_kind kind)
{
    const double z = kind == LUM_PLACE_ROOM   ? ROOM_Z
                     : kind == LUM_PLACE_YARD ? YARD_Z
                                              : LUM_STREET_SENSOR_HEIGHT;
    return (lum_stance){.at = {0.0, 0.0, z}};
}

/* A vehicle's frame is on the ground. */
static lum_stance usual_pose(const lum_place_options *options)
{
    const lum_stance on_ground = {.at = {0.0}};
    return options->is_on_vehicle ? on_ground
                                  : lum_place_usual_pose(options->kind);
}

bool lum_place_is_still(const lum_place *place)
{
    return place->options.has_pose;
}

bool lum_place_moves(const lum_place *place)
{
    return place->options.path.kind != LUM_PATH_NONE;
}

void lum_place_turn(const lum_place *place, const float sensor[3], float out[3])
{
    if (place->options.has_pose) {
        lum_rotation_turn(place->rotation, sensor, out);
    } else {
        memcpy(out, sensor, 3 * sizeof out[0]);
    }
}

/* To millionths, so that texts of one pose are one pose. */
static uint64_t micro(double x)
{
    return (uint64_t)(int64_t)floor(x * 1e6 + 0.5);
}

uint64_t lum_place_noise_seed(const lum_place *place)
{
    const lum_stance *p = &place->options.pose;
    const uint64_t parts[] = {micro(p->at[0]),     micro(p->at[1]),
                              micro(p->at[2]),     micro(p->roll_deg),
                              micro(p->pitch_deg), micro(p->yaw_deg)};
    uint64_t seed = place->seed;
    if (!place->options.has_pose) {
        return seed;
    }
    for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        lum_random random;
        lum_random_init(&random, seed, parts[i]);
        seed = lum_random_next(&random);
    }
    return seed;
}

/* Where an eye is in the place. */
static void find_eye(const lum_place *place, const float mount[3],
                     double out[3])
{
    float turned[3];
    lum_place_turn(place, mount, turned);
    for (int i = 0; i < 3; i++) {
        out[i] = place->options.pose.at[i] + (double)turned[i];
    }
}

/* --- Courses --- */

#define ROOM_TURN 0.6
#define YARD_TURN 2.0

static const lum_path_piece room_course[] = {
    {LUM_FULL_TURN * ROOM_TURN, ROOM_TURN},
    {LUM_FULL_TURN * ROOM_TURN, -ROOM_TURN}};
static const lum_path_piece yard_course[] = {
    {LUM_FULL_TURN * YARD_TURN, YARD_TURN},
    {LUM_FULL_TURN * YARD_TURN, -YARD_TURN}};

bool lum_place_has_path(lum_place_kind kind, lum_path_kind path)
{
    switch (kind) {
    case LUM_PLACE_ROOM:
    case LUM_PLACE_YARD:
        return path != LUM_PATH_STRAIGHT && path != LUM_PATH_STOP_AND_GO;
    case LUM_PLACE_TOWN:
        return path != LUM_PATH_STRAIGHT && path != LUM_PATH_EIGHT;
    case LUM_PLACE_STREET:
    default:
        return path != LUM_PATH_CIRCLE && path != LUM_PATH_EIGHT;
    }
}

/* A circle is the first half of an eight. */
static lum_course course_of(const lum_place_options *options)
{
    lum_course course = {.count =
                             options->path.kind == LUM_PATH_EIGHT ? 2u : 1u};
    const lum_stance usual = usual_pose(options);
    memcpy(course.at, usual.at, sizeof course.at);
    switch (options->kind) {
    case LUM_PLACE_ROOM:
        course.pieces = room_course;
        return course;
    case LUM_PLACE_YARD:
        course.pieces = yard_course;
        return course;
    case LUM_PLACE_TOWN:
        course = lum_town_circuit();
        course.at[2] = usual.at[2];
        return course;
    case LUM_PLACE_STREET:
    default:
        course.count = 0;
        return course;
    }
}

static double degrees(double radians)
{
    return radians * (360.0 / LUM_FULL_TURN);
}

/* Rz Ry Rx. */
static lum_pose pose_of(const lum_stance *p)
{
    lum_pose pose = lum_pose_identity();
    const double turns[3] = {p->yaw_deg, p->pitch_deg, p->roll_deg};
    for (int i = 0; i < 3; i++) {
        const double half = 0.5 * lum_radians(turns[i]);
        lum_pose turn = lum_pose_identity();
        turn.turn[2 - i] = sin(half);
        turn.turn[3] = cos(half);
        pose = lum_pose_compose(&pose, &turn);
    }
    memcpy(pose.at, p->at, sizeof pose.at);
    return pose;
}

/* Turned by a quarter up or down, roll and yaw are one: it is all yaw. */
#define UPRIGHT 1e-7

static lum_stance stance_of(const lum_pose *pose)
{
    double m[12];
    lum_pose_matrix(pose, m);
    const double level = hypot(m[9], m[10]);
    const bool is_steep = level < UPRIGHT;
    return (lum_stance){
        .at = {pose->at[0], pose->at[1], pose->at[2]},
        .roll_deg = is_steep ? 0.0 : degrees(atan2(m[9], m[10])),
        .pitch_deg = degrees(atan2(-m[8], level)),
        .yaw_deg = degrees(is_steep ? atan2(-m[1], m[5]) : atan2(m[4], m[0]))};
}

lum_pose lum_place_vehicle_pose(const lum_place *place, double time_s)
{
    if (lum_place_moves(place)) {
        return lum_path_at(&place->options.path, time_s);
    }
    lum_stance p = place->vehicle;
    if (!place->options.has_pose) {
        p = usual_pose(&place->options);
        p.at[0] += LUM_STREET_SENSOR_SPEED * time_s;
    }
    return pose_of(&p);
}

lum_pose lum_place_pose(const lum_place *place, double time_s)
{
    const lum_pose pose = lum_place_vehicle_pose(place, time_s);
    return place->options.is_on_vehicle
               ? lum_pose_compose(&pose, &place->options.on_vehicle)
               : pose;
}

/* --- Faces --- */

static lum_blocks blocks_of(lum_place_kind kind)
{
    switch (kind) {
    case LUM_PLACE_ROOM:
        return lum_blocks_of_room();
    case LUM_PLACE_YARD:
        return lum_blocks_of_yard();
    case LUM_PLACE_STREET:
    case LUM_PLACE_TOWN:
    default:
        return (lum_blocks){NULL, 0, false};
    }
}

/* How many times as rough as mild walls. */
static double roughness(const lum_place *place)
{
    return (double)place->options.walls;
}

double lum_place_encoder_deg(const lum_place *place)
{
    return roughness(place) * LUM_WALLS_ENCODER_DEG;
}

/* Of the first block, by the order of add_block(). */
#define FLOOR_FACE 4u

/* The face of a block at the end of an axis. */
static void add_face(lum_place *place, const lum_block *block,
                     const float turn[9], int axis, float sign, uint8_t number)
{
    const int along = (axis + 1) % 3;
    const int up = (axis + 2) % 3;
    const unsigned n = place->face_count++;
    lum_face *face = &place->faces[n];
    for (int i = 0; i < 3; i++) {
        face->normal[i] = turn[3 * i + axis];
        face->along[i] = turn[3 * i + along];
        face->up[i] = turn[3 * i + up];
        place->middle[n][i] = block->middle[i] +
                              sign * 0.5f * block->size[axis] * face->normal[i];
    }
    face->half[0] = 0.5f * block->size[along];
    face->half[1] = 0.5f * block->size[up];
    place->reflectivity[n] = block->reflectivity;
    place->block[n] = number;
    lum_face_roughen(face, place->seed, n, roughness(place) * LUM_WALLS_RMS_M,
                     roughness(place) * LUM_WALLS_BIAS_M);
}

static void add_block(lum_place *place, const lum_block *block, bool is_open,
                      uint8_t number)
{
    float turn[9];
    lum_rotation_make((double)block->turn_deg[0], (double)block->turn_deg[1],
                      (double)block->turn_deg[2], turn);
    for (int axis = 0; axis < 3; axis++) {
        add_face(place, block, turn, axis, -1.0f, number);
        if (axis < 2 || !is_open) {
            add_face(place, block, turn, axis, 1.0f, number);
        }
    }
}

void lum_place_init(lum_place *out, const lum_place_options *options,
                    uint64_t seed)
{
    const lum_blocks blocks = blocks_of(options->kind);
    memset(out, 0, sizeof *out);
    out->options = *options;
    out->seed = seed;
    out->options.path.course = course_of(options);
    if (options->kind != LUM_PLACE_STREET && !options->has_pose &&
        options->path.kind == LUM_PATH_NONE) {
        out->options.has_pose = true;
        out->options.pose = usual_pose(options);
    }
    out->vehicle = out->options.pose;
    if (out->options.has_pose && options->is_on_vehicle) {
        const lum_pose pose = lum_place_pose(out, 0.0);
        out->options.pose = stance_of(&pose);
    }
    const lum_stance *p = &out->options.pose;
    lum_rotation_make(p->roll_deg, p->pitch_deg, p->yaw_deg, out->rotation);
    for (size_t i = 0; i < blocks.count; i++) {
        add_block(out, &blocks.list[i], blocks.is_open && i == 0, (uint8_t)i);
    }
}

/* The face as a shape, around an eye. */
static lum_shape shape_of(const lum_place *place, unsigned n,
                          const double eye[3])
{
    const lum_face *face = &place->faces[n];
    lum_shape shape = {.reflectivity = place->reflectivity[n],
                       .face = face,
                       .kind = LUM_SHAPE_FACE,
                       .object = 2u + place->block[n],
                       .thing = LUM_THING_OTHER};
    if (place->block[n] == 0) { /* walls and floor of the place itself */
        const bool is_floor = n == FLOOR_FACE;
        shape.object = is_floor ? LUM_OBJECT_GROUND : shape.object;
        shape.thing = is_floor ? LUM_THING_GROUND : LUM_THING_BUILDING;
    }
    for (int i = 0; i < 3; i++) {
        const float at = (float)((double)place->middle[n][i] - eye[i]);
        const float half = fabsf(face->along[i]) * face->half[0] +
                           fabsf(face->up[i]) * face->half[1];
        shape.min[i] = at - half;
        shape.max[i] = at + half;
    }
    return shape;
}

/* --- Laying out --- */

static bool is_open(const lum_place *place, const double eye[3])
{
    const double margin = (double)LUM_SHAPE_NEAREST;
    switch (place->options.kind) {
    case LUM_PLACE_STREET:
        return eye[1] >= STREET_RIGHT_M && eye[1] <= STREET_LEFT_M &&
               eye[2] >= margin && eye[2] <= STREET_HIGH_M;
    case LUM_PLACE_TOWN:
        return lum_town_is_open(eye, margin);
    case LUM_PLACE_ROOM:
    case LUM_PLACE_YARD:
    default:
        return lum_blocks_leave_open(blocks_of(place->options.kind), eye,
                                     margin);
    }
}

bool lum_place_is_open(const lum_place *place, const float mount[3])
{
    double eye[3];
    find_eye(place, mount, eye);
    return !place->options.has_pose || is_open(place, eye);
}

bool lum_place_is_open_at(const lum_place *place, double time_s,
                          const float mount[3])
{
    const lum_pose pose = lum_place_pose(place, time_s);
    const double at[3] = {(double)mount[0], (double)mount[1], (double)mount[2]};
    double eye[3];
    lum_pose_apply(&pose, at, eye);
    return is_open(place, eye);
}

/* One that stands does so at the beginning of the drive, or ahead of it. What
 * is there goes by the vehicle, so that all sensors on it see the same. */
static void lay_out_street(const lum_place *place, double time_s,
                           const float mount[3], lum_shape_list *out,
                           lum_ground *ground)
{
    const lum_stance *p = &place->options.pose;
    float eye[3];
    if (!place->options.has_pose) {
        const lum_street_moment drive = {.time_s = time_s};
        lum_street_lay_out(place->seed, &drive, mount, out, ground);
        return;
    }
    lum_place_turn(place, mount, eye);
    eye[0] = (float)((double)eye[0] + (p->at[0] - place->vehicle.at[0]));
    eye[1] = (float)((double)eye[1] + p->at[1]);
    eye[2] = (float)((double)eye[2] + p->at[2] - LUM_STREET_SENSOR_HEIGHT);
    const lum_street_moment moment = {.ahead_m = place->vehicle.at[0]};
    lum_street_lay_out(place->seed, &moment, eye, out, ground);
}

static void lay_out_faces(const lum_place *place, const double eye[3],
                          lum_shape_list *out, lum_ground *ground)
{
    out->count = 0;
    *ground = (lum_ground){.is_there = false};
    for (unsigned n = 0; n < place->face_count; n++) {
        const lum_shape shape = shape_of(place, n, eye);
        lum_shape_list_add(out, &shape);
    }
}

/* Half the time over which a speed is taken. */
#define STEP_S 1e-3

static void lay_out_moving_street(const lum_place *place, double time_s,
                                  const double at[3], lum_shape_list *out,
                                  lum_ground *ground)
{
    const lum_pose before = lum_place_vehicle_pose(place, time_s - STEP_S);
    const lum_pose now = lum_place_vehicle_pose(place, time_s);
    const lum_pose after = lum_place_vehicle_pose(place, time_s + STEP_S);
    const lum_street_moment moment = {
        .time_s = time_s,
        .ahead_m = now.at[0] - LUM_STREET_SENSOR_SPEED * time_s,
        .leads = true,
        .speed = (after.at[0] - before.at[0]) / (2.0 * STEP_S)};
    const float eye[3] = {(float)(at[0] - now.at[0]), (float)at[1],
                          (float)(at[2] - LUM_STREET_SENSOR_HEIGHT)};
    lum_street_lay_out(place->seed, &moment, eye, out, ground);
}

void lum_place_lay_out_around(const lum_place *place, double time_s,
                              const lum_sight_view *view, lum_shape_list *out,
                              lum_ground *ground)
{
    switch (place->options.kind) {
    case LUM_PLACE_STREET:
        lay_out_moving_street(place, time_s, view->at, out, ground);
        return;
    case LUM_PLACE_TOWN:
        lum_town_lay_out(place->seed, time_s, view, out, ground);
        return;
    case LUM_PLACE_ROOM:
    case LUM_PLACE_YARD:
    default:
        lay_out_faces(place, view->at, out, ground);
    }
}

void lum_place_lay_out(const lum_place *place, double time_s,
                       const float mount[3], lum_shape_list *out,
                       lum_ground *ground)
{
    lum_sight_view view = {.reach_m = 0.0f};
    if (place->options.kind == LUM_PLACE_STREET) {
        lay_out_street(place, time_s, mount, out, ground);
        return;
    }
    find_eye(place, mount, view.at);
    lum_place_lay_out_around(place, 0.0, &view, out, ground);
}
