#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/points.h"
#include "sim/blocks.h"
#include "sim/face.h"
#include "sim/place.h"
#include "sim/random.h"
#include "sim/render.h"
#include "sim/scan.h"
#include "sim/scene.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI     3.14159265358979
#define TOF_M  0.00195 /* of one bit */
#define EXACT  2e-5    /* what single precision leaves of 30 m */
#define FRAMES 4

/* --- Where things stand --- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Rz(yaw) Ry(pitch) Rx(roll) v, one turn after the other. */
static void turn(double roll_deg, double pitch_deg, double yaw_deg, double v[3])
{
    static const int axes[3][2] = {{1, 2}, {2, 0}, {0, 1}};
    const double degrees[3] = {roll_deg, pitch_deg, yaw_deg};
    for (int i = 0; i < 3; i++) {
        const int a = axes[i][0];
        const int b = axes[i][1];
        const double c = cos(degrees[i] * PI / 180.0);
        const double s = sin(degrees[i] * PI / 180.0);
        const double before = v[a];
        v[a] = c * before - s * v[b];
        v[b] = s * before + c * v[b];
    }
}

static void to_place(const lum_stance *pose, const lum_sample *p, double out[3])
{
    out[0] = (double)p->x;
    out[1] = (double)p->y;
    out[2] = (double)p->z;
    turn(pose->roll_deg, pose->pitch_deg, pose->yaw_deg, out);
    for (int i = 0; i < 3; i++) {
        out[i] += pose->at[i];
    }
}

/* How far a point is from the nearest face of a block. */
static double distance_to_block(const lum_block *b, const double at[3])
{
    double away[3];
    double outside = 0.0;
    double inside = -1e9;
    for (int i = 0; i < 3; i++) {
        double axis[3] = {i == 0, i == 1, i == 2};
        double from[3];
        turn((double)b->turn_deg[0], (double)b->turn_deg[1],
             (double)b->turn_deg[2], axis);
        for (int k = 0; k < 3; k++) {
            from[k] = at[k] - (double)b->middle[k];
        }
        away[i] = fabs(dot(axis, from)) - 0.5 * (double)b->size[i];
        outside += away[i] > 0.0 ? away[i] * away[i] : 0.0;
        inside = away[i] > inside ? away[i] : inside;
    }
    return outside > 0.0 ? sqrt(outside) : -inside;
}

static double distance_to_blocks(lum_blocks blocks, const double at[3])
{
    double least = 1e9;
    for (size_t i = 0; i < blocks.count; i++) {
        least = fmin(least, distance_to_block(&blocks.list[i], at));
    }
    return least;
}

/* --- Lines of a place --- */

struct fixture {
    lum_render_options options;
    lum_render render;
    lum_sim_line line;
    lum_sim_line other;
};

/* A sensor whose eyes are mounted at odd places. */
static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return -1;
    }
    lum_render_options_default(&f->options);
    f->options.seed = 5;
    lum_eye_calibration *blue = &f->options.calibration.eye[LUM_EYE_BLUE];
    lum_eye_calibration *green = &f->options.calibration.eye[LUM_EYE_GREEN];
    blue->mount_um[0] = 43000;
    blue->mount_um[1] = -31000;
    blue->mount_um[2] = 12000;
    blue->mount_roll_udeg = 1700000;
    blue->mount_pitch_udeg = -900000;
    blue->mount_yaw_udeg = -31300000;
    blue->tof_offset_fs = 150000;
    green->mount_um[1] = 50000;
    green->mount_pitch_udeg = 1200000;
    green->azimuth_width_udeg = 60500000;
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    lum_render_free(&f->render);
    free(f);
    return 0;
}

static void begin(struct fixture *f)
{
    lum_render_free(&f->render);
    assert_int_equal(lum_render_init(&f->render, &f->options), LUM_OK);
}

static void look_at(struct fixture *f, lum_place_kind kind, lum_stance pose)
{
    f->options.place =
        (lum_place_options){.kind = kind, .has_pose = true, .pose = pose};
    begin(f);
}

static void render(struct fixture *f, int64_t frame, uint32_t line,
                   unsigned eye)
{
    assert_int_equal(lum_render_line(&f->render, frame, line, eye, &f->line),
                     LUM_OK);
}

/* The range of the rising word of a truth, as decoders compute it. */
static double range_of(const struct fixture *f, size_t i)
{
    const lum_calibration *c = &f->options.calibration;
    const double ps = (double)lum_word_tof(f->line.words[2 * i]) * 13.0 +
                      (double)c->eye[f->line.eye].tof_offset_fs * 1e-3;
    return ps * 1e-12 * 3.0e8 / 2.0;
}

static double error_of(const struct fixture *f, size_t i)
{
    return range_of(f, i) - (double)f->line.truth[i].range;
}

/* --- Rooms and yards --- */

static const lum_stance poses[] = {
    {{0.0, 0.0, 1.2}, 0.0, 0.0, 0.0},
    {{0.1, -0.2, 1.1}, 0.0, 0.0, 25.0},
    {{-0.3, 0.2, 1.4}, 12.0, -8.0, 155.0},
    {{0.2, 0.1, 1.3}, -12.0, 30.0, -100.0},
};

static void check_points(struct fixture *f, lum_blocks blocks)
{
    const uint32_t lines[] = {0, 13, 40, 63};
    for (size_t i = 0; i < 2 * sizeof lines / sizeof lines[0]; i++) {
        render(f, 1, lines[i / 2], (unsigned)i % 2);
        for (size_t k = 0; k < f->line.truth_count; k++) {
            double at[3];
            to_place(&f->options.place.pose, &f->line.truth[k], at);
            assert_true(distance_to_blocks(blocks, at) < EXACT);
        }
    }
}

static void points_lie_on_the_planes_from_each_pose(void **state)
{
    struct fixture *f = *state;
    for (size_t i = 0; i < sizeof poses / sizeof poses[0]; i++) {
        look_at(f, LUM_PLACE_ROOM, poses[i]);
        check_points(f, lum_blocks_of_room());
        assert_int_equal(f->line.truth_count, LUM_LINE_PIXELS);
        look_at(f, LUM_PLACE_YARD, poses[i]);
        check_points(f, lum_blocks_of_yard());
    }
}

static float range_along(lum_place_kind kind, const double at[3], float x,
                         float y, float z)
{
    static const float mount[3] = {0.0f, 0.0f, 0.0f};
    const float d[3] = {x, y, z};
    const lum_ray ray = lum_ray_make(d);
    const lum_place_options options = {
        .kind = kind, .has_pose = true, .pose = {.at = {at[0], at[1], at[2]}}};
    lum_place place;
    lum_scene scene;
    lum_hit hits[LUM_SCENE_HITS_MAX];
    memset(&scene, 0, sizeof scene);
    lum_place_init(&place, &options, 1);
    assert_int_equal(lum_scene_set(&scene, &place, 0.0, mount), 0);
    const size_t n = lum_scene_cast(&scene, &ray, hits);
    lum_scene_free(&scene);
    return n > 0 ? hits[0].range : 0.0f;
}

static void walls_floor_and_ceiling_are_where_they_are_told(void **state)
{
    const double room[3] = {0.0, 0.0, 1.2};
    const double ahead[3] = {1.0, 0.25, 1.5};
    const double yard[3] = {0.0, 0.0, 1.5};
    (void)state;
    assert_float_equal(range_along(LUM_PLACE_ROOM, room, 1, 0, 0), 4.6, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, room, 0, -1, 0), 3.4, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, room, 0, 1, 0), 2.6, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, room, 0, 0, 1), 1.8, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, room, 0, 0, -1), 1.2, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, ahead, 1, 0, 0), 3.6, EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, ahead, 0, 1, 0), 2.35,
                       EXACT);
    assert_float_equal(range_along(LUM_PLACE_ROOM, ahead, 0, 0, 1), 1.5, EXACT);
    assert_float_equal(range_along(LUM_PLACE_YARD, yard, 0, 0, -1), 1.5, EXACT);
    assert_float_equal(range_along(LUM_PLACE_YARD, yard, -1, 0, 0), 15.0,
                       EXACT);
    assert_true(range_along(LUM_PLACE_YARD, yard, 0, 0, 1) == 0.0f);
}

/* By the shapes one by one. */
static float nearest_of(const lum_scene *scene, const lum_ray *ray)
{
    float nearest = LUM_STREET_REACH;
    for (size_t i = 0; i < scene->shapes.count; i++) {
        lum_hit hit;
        if (lum_shape_cast(&scene->shapes.items[i], ray, &hit)) {
            nearest = hit.range < nearest ? hit.range : nearest;
        }
    }
    return nearest;
}

static void cells_lose_no_face(void **state)
{
    static const float mount[3] = {0.05f, -0.03f, 0.02f};
    (void)state;
    for (int kind = LUM_PLACE_ROOM; kind <= LUM_PLACE_YARD; kind++) {
        const lum_place_options options = {.kind = (lum_place_kind)kind,
                                           .walls = LUM_WALLS_MILD};
        lum_place place;
        lum_scene scene;
        lum_random r;
        memset(&scene, 0, sizeof scene);
        lum_random_init(&r, 2, 2);
        lum_place_init(&place, &options, 9);
        assert_int_equal(lum_scene_set(&scene, &place, 0.0, mount), 0);
        for (int i = 0; i < 20000; i++) {
            lum_hit hits[LUM_SCENE_HITS_MAX];
            const float u = lum_random_between(&r, -1.0f, 1.0f);
            const float away = sqrtf(1.0f - u * u);
            const float heading = lum_random_between(&r, -3.14f, 3.14f);
            const float d[3] = {away * cosf(heading), away * sinf(heading), u};
            const lum_ray ray = lum_ray_make(d);
            const size_t n = lum_scene_cast(&scene, &ray, hits);
            const float nearest = nearest_of(&scene, &ray);
            assert_int_equal(n, nearest < LUM_STREET_REACH);
            assert_true(n == 0 || hits[0].range == nearest);
        }
        lum_scene_free(&scene);
    }
}

static bool is_open(lum_place_kind kind, double x, double y, double z)
{
    static const float mount[3] = {0.0f, 0.0f, 0.0f};
    const lum_place_options options = {
        .kind = kind, .has_pose = true, .pose = {.at = {x, y, z}}};
    lum_place place;
    lum_place_init(&place, &options, 1);
    return lum_place_is_open(&place, mount);
}

static void a_sensor_stands_in_the_open(void **state)
{
    const float mount[3] = {0.0f, 0.0f, 0.0f};
    (void)state;
    for (int kind = LUM_PLACE_STREET; kind <= LUM_PLACE_YARD; kind++) {
        const lum_place_options options = {.kind = (lum_place_kind)kind};
        const lum_stance p = lum_place_usual_pose((lum_place_kind)kind);
        lum_place place;
        lum_place_init(&place, &options, 1);
        assert_true(lum_place_is_open(&place, mount));
        assert_true(lum_place_is_still(&place) == (kind != LUM_PLACE_STREET));
        assert_true(is_open((lum_place_kind)kind, p.at[0], p.at[1], p.at[2]));
    }
    assert_true(is_open(LUM_PLACE_ROOM, 4.09, 0.0, 1.2));
    assert_false(is_open(LUM_PLACE_ROOM, 4.11, 0.0, 1.2));
    assert_false(is_open(LUM_PLACE_ROOM, 0.0, 0.0, 0.4));
    assert_false(is_open(LUM_PLACE_ROOM, 0.0, 0.0, 2.6));
    assert_false(is_open(LUM_PLACE_ROOM, 5.0, 0.0, 1.2));
    assert_false(is_open(LUM_PLACE_ROOM, -1.6, 1.6, 0.5)); /* a crate */
    assert_false(is_open(LUM_PLACE_ROOM, -1.6, 1.6, 1.45));
    assert_true(is_open(LUM_PLACE_ROOM, -1.6, 1.6, 1.55));
    assert_false(is_open(LUM_PLACE_YARD, 9.5, 6.0, 1.5)); /* the garage */
    assert_true(is_open(LUM_PLACE_YARD, 0.0, 0.0, 8.9));
    assert_false(is_open(LUM_PLACE_YARD, 0.0, 0.0, 9.1));
    assert_false(is_open(LUM_PLACE_STREET, 0.0, 12.0, 1.8));
    assert_false(is_open(LUM_PLACE_STREET, 0.0, 0.0, 0.4));
}

/* --- A street that stands still --- */

static void a_street_stands_still_from_a_pose(void **state)
{
    struct fixture *f = *state;
    begin(f);
    render(f, 1, 30, LUM_EYE_BLUE);
    f->other = f->line;
    look_at(f, LUM_PLACE_STREET, lum_place_usual_pose(LUM_PLACE_STREET));
    for (int64_t frame = 1; frame <= FRAMES; frame++) {
        render(f, frame, 30, LUM_EYE_BLUE);
        size_t same = 0;
        for (size_t i = 0; i < f->line.truth_count; i++) {
            same +=
                i < f->other.truth_count &&
                fabsf(f->line.truth[i].range - f->other.truth[i].range) < 1e-4f;
        }
        assert_true(same > LUM_LINE_PIXELS / 2);
    }
    look_at(f, LUM_PLACE_STREET, (lum_stance){{0.0, 0.0, 3.3}, 0.0, 0.0, 0.0});
    render(f, 1, 63, LUM_EYE_BLUE);
    f->other = f->line;
    look_at(f, LUM_PLACE_STREET, (lum_stance){{0.0, 0.0, 1.8}, 0.0, 0.0, 0.0});
    render(f, 1, 63, LUM_EYE_BLUE);
    assert_true(f->other.truth[0].range > 1.5f * f->line.truth[0].range);
}

/* --- Frames of a still place --- */

static void a_kept_line_is_the_line_that_is_looked_at(void **state)
{
    struct fixture *f = *state;
    f->options.place.walls = LUM_WALLS_MILD;
    f->options.place.kind = LUM_PLACE_ROOM;
    begin(f);
    render(f, 2, 20, LUM_EYE_GREEN);
    f->other = f->line;
    begin(f);
    render(f, 1, 20, LUM_EYE_GREEN);
    assert_memory_not_equal(f->line.words, f->other.words,
                            f->other.word_count * sizeof f->other.words[0]);
    render(f, 2, 20, LUM_EYE_GREEN);
    assert_int_equal(f->line.word_count, f->other.word_count);
    assert_memory_equal(f->line.words, f->other.words,
                        f->other.word_count * sizeof f->other.words[0]);
    assert_memory_equal(f->line.truth, f->other.truth,
                        f->other.truth_count * sizeof f->other.truth[0]);
}

/* Errors of two poses have nothing in common. */
static void each_pose_has_noise_of_its_own(void **state)
{
    struct fixture *f = *state;
    double first[LUM_LINE_PIXELS];
    double product = 0.0;
    look_at(f, LUM_PLACE_ROOM, poses[0]);
    render(f, 1, 5, LUM_EYE_BLUE);
    for (size_t i = 0; i < LUM_LINE_PIXELS; i++) {
        first[i] = error_of(f, i);
    }
    look_at(f, LUM_PLACE_ROOM, poses[1]);
    render(f, 1, 5, LUM_EYE_BLUE);
    for (size_t i = 0; i < LUM_LINE_PIXELS; i++) {
        product += first[i] * error_of(f, i);
    }
    assert_true(fabs(product / LUM_LINE_PIXELS) < 0.15 * 0.02 * 0.02);
}

/* --- Noise --- */

static void ranges_have_the_noise_of_their_return(void **state)
{
    struct fixture *f = *state;
    double squares[LUM_RENDER_RETURNS_MAX] = {0.0};
    double counts[LUM_RENDER_RETURNS_MAX] = {0.0};
    f->options.noise_m[0] = 0.01f;
    f->options.noise_m[1] = 0.05f;
    look_at(f, LUM_PLACE_STREET, lum_place_usual_pose(LUM_PLACE_STREET));
    for (int i = 0; i < 40; i++) {
        render(f, 1 + i / 10, (uint32_t)(i % 10), LUM_EYE_GREEN);
        for (size_t k = 0; k < f->line.truth_count; k++) {
            const unsigned at = f->line.truth[k].return_number - 1u;
            squares[at] += error_of(f, k) * error_of(f, k);
            counts[at] += 1.0;
        }
    }
    assert_true(counts[1] > 1000.0);
    assert_true(fabs(sqrt(squares[0] / counts[0]) - 0.01) < 0.0005);
    assert_true(fabs(sqrt(squares[1] / counts[1]) - 0.05) < 0.004);
}

static void without_noise_ranges_are_exact(void **state)
{
    struct fixture *f = *state;
    memset(f->options.noise_m, 0, sizeof f->options.noise_m);
    look_at(f, LUM_PLACE_YARD, poses[2]);
    render(f, 1, 20, LUM_EYE_BLUE);
    for (size_t i = 0; i < f->line.truth_count; i++) {
        assert_true(fabs(error_of(f, i)) < 0.51 * TOF_M);
    }
}

/* --- Walls that are not flat --- */

static double rms_of(const lum_face *face)
{
    double squares = 0.0;
    lum_random r;
    lum_random_init(&r, 1, 1);
    for (int i = 0; i < 4000; i++) {
        const float a = lum_random_between(&r, -50.0f, 50.0f);
        const float b = lum_random_between(&r, -50.0f, 50.0f);
        const double height = (double)lum_face_height(face, a, b);
        squares += height * height;
    }
    return sqrt(squares / 4000.0);
}

static void waves_and_bias_are_as_large_as_they_are_told(void **state)
{
    double squares = 0.0;
    (void)state;
    for (unsigned n = 0; n < 400; n++) {
        lum_face face = {.half = {1.0f, 1.0f}};
        lum_face_roughen(&face, 3, n, LUM_WALLS_RMS_M, LUM_WALLS_BIAS_M);
        squares += (double)face.bias_m * (double)face.bias_m;
        for (unsigned i = 0; i < LUM_FACE_WAVES; i++) {
            const double per_m = hypot((double)face.waves[i].along_per_m,
                                       (double)face.waves[i].up_per_m);
            const double length = 2.0 * PI / per_m;
            assert_true(length > 0.799 && length < 4.001);
        }
        if (n % 20 == 0) {
            assert_true(fabs(rms_of(&face) - 0.0014) < 0.0001);
        }
    }
    assert_true(fabs(sqrt(squares / 400.0) - 0.002) < 0.0002);
}

static void measure_walls(struct fixture *f, lum_walls walls, double *height,
                          double *bias)
{
    size_t count = 0;
    *height = 0.0;
    *bias = 0.0;
    memset(f->options.noise_m, 0, sizeof f->options.noise_m);
    f->options.place = (lum_place_options){.kind = LUM_PLACE_ROOM,
                                           .walls = walls,
                                           .has_pose = true,
                                           .pose = poses[0]};
    begin(f);
    for (uint32_t line = 0; line < 64; line++) {
        render(f, 1, line, LUM_EYE_GREEN);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            double at[3];
            to_place(&poses[0], &f->line.truth[i], at);
            const double d = distance_to_blocks(lum_blocks_of_room(), at);
            *height += d * d;
            *bias += error_of(f, i) * error_of(f, i);
        }
        count += f->line.truth_count;
    }
    *height = sqrt(*height / (double)count);
    *bias = sqrt(*bias / (double)count);
}

static void truth_has_the_waves_and_ranges_the_bias_too(void **state)
{
    struct fixture *f = *state;
    double height[3];
    double bias[3];
    for (int walls = LUM_WALLS_FLAT; walls <= LUM_WALLS_ROUGH; walls++) {
        measure_walls(f, (lum_walls)walls, &height[walls], &bias[walls]);
    }
    assert_true(height[LUM_WALLS_FLAT] < EXACT);
    assert_true(bias[LUM_WALLS_FLAT] < TOF_M / 3.0);
    assert_true(height[LUM_WALLS_MILD] > 0.0007 &&
                height[LUM_WALLS_MILD] < 0.0025);
    assert_true(bias[LUM_WALLS_MILD] > 0.0008);
    assert_true(fabs(height[LUM_WALLS_ROUGH] / height[LUM_WALLS_MILD] - 2.0) <
                0.05);
    assert_true(bias[LUM_WALLS_ROUGH] > 1.5 * bias[LUM_WALLS_MILD]);
}

/* The height of a sine of one period over the span of azimuth, in the readings'
 * errors. */
static double height_of_sine(struct fixture *f, lum_walls walls)
{
    double sums[2] = {0.0, 0.0};
    lum_scan_line line;
    lum_random r;
    const uint32_t lines = 64;
    f->options.place =
        (lum_place_options){.kind = LUM_PLACE_ROOM, .walls = walls};
    begin(f);
    lum_random_init(&r, 1, 1);
    for (uint32_t i = 0; i < lines; i++) {
        lum_scan_compute(&f->render.scan, LUM_EYE_BLUE, i, &r, &line);
        for (size_t p = 0; p < LUM_LINE_PIXELS; p++) {
            const double az = (double)line.azimuth[p];
            const double error =
                (double)line.reading[p].azimuth * 30.0 / 32768.0 - az;
            sums[0] += error * sin(az / 60.0 * 2.0 * PI);
            sums[1] += error * cos(az / 60.0 * 2.0 * PI);
        }
    }
    return 2.0 * hypot(sums[0], sums[1]) / (LUM_LINE_PIXELS * (double)lines);
}

static void encoders_are_wrong_by_a_sine(void **state)
{
    struct fixture *f = *state;
    assert_true(height_of_sine(f, LUM_WALLS_FLAT) < 0.0003);
    assert_true(fabs(height_of_sine(f, LUM_WALLS_MILD) - 0.003) < 0.0006);
    assert_true(fabs(height_of_sine(f, LUM_WALLS_ROUGH) - 0.006) < 0.0012);
}

static void walls_are_the_same_from_each_pose_and_differ_by_seed(void **state)
{
    const lum_place_options here = {.kind = LUM_PLACE_ROOM,
                                    .walls = LUM_WALLS_MILD};
    const lum_place_options there = {.kind = LUM_PLACE_ROOM,
                                     .walls = LUM_WALLS_MILD,
                                     .has_pose = true,
                                     .pose = poses[2]};
    lum_place a;
    lum_place b;
    lum_place c;
    (void)state;
    lum_place_init(&a, &here, 7);
    lum_place_init(&b, &there, 7);
    lum_place_init(&c, &here, 8);
    assert_true(a.face_count > 30 && a.face_count == b.face_count);
    assert_memory_equal(a.faces, b.faces, sizeof a.faces);
    assert_memory_not_equal(a.faces, c.faces, sizeof a.faces);
    assert_true(lum_place_noise_seed(&a) != lum_place_noise_seed(&b));
}

/* Whether a line of a sensor on a vehicle is that of one alone, byte for byte,
 * where it stands then. */
static void compare_with_alone(struct fixture *f, lum_stance vehicle,
                               lum_pose on, lum_stance alone)
{
    static lum_sim_line line;
    const size_t n = LUM_LINE_PIXELS / 2;
    look_at(f, LUM_PLACE_ROOM, alone);
    render(f, 1, 30, LUM_EYE_BLUE);
    line = f->line;
    f->options.place = (lum_place_options){.kind = LUM_PLACE_ROOM,
                                           .has_pose = true,
                                           .pose = vehicle,
                                           .is_on_vehicle = true,
                                           .on_vehicle = on};
    begin(f);
    render(f, 1, 30, LUM_EYE_BLUE);
    assert_true(line.word_count > n);
    assert_int_equal(line.word_count, f->line.word_count);
    assert_memory_equal(line.words, f->line.words, n * sizeof line.words[0]);
    assert_memory_equal(line.angles, f->line.angles, sizeof line.angles);
    const lum_pose pose = lum_render_pose(&f->render, 1, 30);
    assert_true(fabs(pose.at[0] - vehicle.at[0]) < 1e-12);
}

static void one_on_a_vehicle_sees_what_one_alone_sees_there(void **state)
{
    const double half = sqrt(0.5);
    const lum_pose left = {{1.0, 0.5, 0.25}, {0.0, 0.0, half, half}};
    const lum_pose down = {{1.0, 0.5, 0.25}, {0.0, half, 0.0, half}};
    const lum_stance vehicle = {.at = {-2.0, 1.0, 1.5}, .yaw_deg = -90.0};
    const lum_stance turned = {.at = {0.0, 0.0, 1.5}, .roll_deg = 90.0};
    compare_with_alone(*state, vehicle, left,
                       (lum_stance){.at = {-1.5, 0.0, 1.75}});
    compare_with_alone(*state, vehicle, down,
                       (lum_stance){.at = {-1.5, 0.0, 1.75},
                                    .pitch_deg = 90.0,
                                    .yaw_deg = -90.0});
    /* Its left is up: to its left is a turn by pitch. */
    compare_with_alone(*state, turned, left,
                       (lum_stance){.at = {1.0, -0.25, 2.0},
                                    .pitch_deg = -90.0,
                                    .yaw_deg = 90.0});
}

/* A vehicle of the street is the same one from both eyes, however far one is in
 * front of the other. */
static void a_mount_ahead_sees_vehicles_where_they_are(void **state)
{
    struct fixture *f = *state;
    double nearest[2] = {100.0, 100.0};
    for (int i = 0; i < 2; i++) {
        lum_render_options_default(&f->options);
        f->options.calibration.eye[LUM_EYE_BLUE].mount_um[0] = i * 800000;
        begin(f);
        for (uint32_t n = 0; n < 64; n++) {
            render(f, 1, n, LUM_EYE_BLUE);
            for (size_t k = 0; k < f->line.truth_count; k++) {
                if (f->line.labels[k].object == 0x28000001u) {
                    nearest[i] = fmin(nearest[i], (double)f->line.truth[k].x);
                }
            }
        }
    }
    assert_true(nearest[0] < 20.0);
    assert_true(fabs(nearest[1] - nearest[0]) < 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(points_lie_on_the_planes_from_each_pose,
                                        set_up, tear_down),
        cmocka_unit_test(walls_floor_and_ceiling_are_where_they_are_told),
        cmocka_unit_test(cells_lose_no_face),
        cmocka_unit_test(a_sensor_stands_in_the_open),
        cmocka_unit_test_setup_teardown(a_street_stands_still_from_a_pose,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            a_kept_line_is_the_line_that_is_looked_at, set_up, tear_down),
        cmocka_unit_test_setup_teardown(each_pose_has_noise_of_its_own, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(ranges_have_the_noise_of_their_return,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(without_noise_ranges_are_exact, set_up,
                                        tear_down),
        cmocka_unit_test(waves_and_bias_are_as_large_as_they_are_told),
        cmocka_unit_test_setup_teardown(
            truth_has_the_waves_and_ranges_the_bias_too, set_up, tear_down),
        cmocka_unit_test_setup_teardown(encoders_are_wrong_by_a_sine, set_up,
                                        tear_down),
        cmocka_unit_test(walls_are_the_same_from_each_pose_and_differ_by_seed),
        cmocka_unit_test_setup_teardown(
            one_on_a_vehicle_sees_what_one_alone_sees_there, set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            a_mount_ahead_sees_vehicles_where_they_are, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
