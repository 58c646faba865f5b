#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/frame/move.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define S      INT64_C(1000000000)
#define COUNT  3000u
#define BEGIN  (100 * S)
#define TURN   1.5 /* radians a second */
#define RADIUS 6.0

static lum_pose on_circle(double seconds)
{
    const double a = TURN * seconds;
    const lum_pose pose = {{RADIUS * sin(a), -RADIUS * cos(a), 0.3 * seconds},
                           {0.0, 0.0, sin(a / 2.0), cos(a / 2.0)}};
    return pose;
}

/* From BEGIN on, n poses of a circle at this distance. */
static lum_poses *make_poses(size_t n, int64_t step_ns)
{
    int64_t times[64];
    lum_pose list[64];
    lum_poses *poses = NULL;
    lum_error error = {""};
    assert_true(n <= 64);
    for (size_t i = 0; i < n; i++) {
        times[i] = BEGIN + (int64_t)i * step_ns;
        list[i] = on_circle((double)((int64_t)i * step_ns) * 1e-9);
    }
    assert_int_equal(lum_poses_new(times, list, n, NULL, &poses, &error), 0);
    return poses;
}

/* Points of two eyes, whose lines are of the same times in turn. */
struct scene {
    float x[COUNT], y[COUNT], z[COUNT], time[COUNT];
    float out[3][COUNT];
    lum_move_points points;
    lum_move_options options;
    lum_move_counts counts;
    lum_error error;
};

static struct scene *make_scene(const lum_poses *poses, lum_move_to to)
{
    struct scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    for (unsigned i = 0; i < COUNT; i++) {
        const unsigned pair = i / 1200u; /* of lines, at once */
        const double angle = 0.37 * i;
        const double range = i % 7u == 0 ? 100.0 : (double)(i % 90u) + 1.0;
        s->x[i] = (float)(range * cos(angle));
        s->y[i] = (float)(range * sin(angle) * 0.8);
        s->z[i] = (float)(range * sin(angle) * 0.6);
        s->time[i] = (float)(0.03 * pair + 0.03 * (i % 600u) / 600.0);
    }
    s->points = (lum_move_points){.struct_size = sizeof s->points,
                                  .x = s->x,
                                  .y = s->y,
                                  .z = s->z,
                                  .time = s->time,
                                  .count = COUNT,
                                  .begin_ns = BEGIN,
                                  .start_ns = BEGIN + S / 20};
    s->options = (lum_move_options){
        .struct_size = sizeof s->options, .poses = poses, .to = to};
    return s;
}

static void run(struct scene *s)
{
    assert_int_equal(lum_points_move(&s->points, &s->options, s->out[0],
                                     s->out[1], s->out[2], &s->counts,
                                     &s->error),
                     0);
}

/* The farthest from where the circle itself has them. */
static double error_of(const struct scene *s, const lum_pose *back)
{
    double worst = 0.0;
    for (unsigned i = 0; i < COUNT; i++) {
        const lum_pose pose = on_circle((double)s->time[i]);
        double p[3] = {(double)s->x[i], (double)s->y[i], (double)s->z[i]};
        lum_pose_apply(&pose, p, p);
        lum_pose_apply(back, p, p);
        worst = fmax(worst, hypot(hypot(p[0] - (double)s->out[0][i],
                                        p[1] - (double)s->out[1][i]),
                                  p[2] - (double)s->out[2][i]));
    }
    return worst;
}

/* Few poses, and more of them than lines. */
static const int64_t steps_ns[] = {S / 2, S / 10, S / 50, S / 500};

static void the_bound_holds_into_the_world(void **state)
{
    (void)state;
    const lum_pose none = lum_pose_identity();
    for (size_t i = 0; i < sizeof steps_ns / sizeof *steps_ns; i++) {
        lum_poses *poses = make_poses(i == 3 ? 46 : 10, steps_ns[i]);
        struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
        run(s);
        assert_int_equal(s->counts.points, COUNT);
        assert_int_equal(lum_move_counts_without(&s->counts), 0);
        assert_true(error_of(s, &none) < 1.5e-4);
        free(s);
        lum_poses_free(poses);
    }
}

static void the_bound_holds_to_a_moment(void **state)
{
    (void)state;
    const lum_pose there = on_circle(0.05);
    const lum_pose back = lum_pose_inverse(&there);
    lum_poses *poses = make_poses(10, S / 10);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_START);
    run(s);
    assert_int_equal(lum_move_counts_without(&s->counts), 0);
    assert_true(error_of(s, &back) < 1.5e-4);
    free(s);
    lum_poses_free(poses);
}

static void an_origin_is_taken_off_before_rounding(void **state)
{
    (void)state;
    const int64_t times[] = {BEGIN, BEGIN + S / 2};
    const lum_pose list[] = {{{512000.125, 5400000.25, 100.5}, {0, 0, 0, 1}},
                             {{512000.125, 5400000.25, 100.5}, {0, 0, 0, 1}}};
    lum_poses *poses = NULL;
    lum_error error = {""};
    assert_int_equal(lum_poses_new(times, list, 2, NULL, &poses, &error), 0);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
    s->options.origin[0] = 512000.0;
    s->options.origin[1] = 5400000.0;
    run(s);
    for (unsigned i = 0; i < COUNT; i++) {
        /* Floats, which processors with wider ones round only when kept. */
        const float moved[] = {s->x[i] + 0.125f, s->y[i] + 0.25f,
                               s->z[i] + 100.5f};
        for (unsigned row = 0; row < 3; row++) {
            assert_true(s->out[row][i] == moved[row]);
        }
    }
    free(s);
    lum_poses_free(poses);
}

static void assert_nan_outside(const struct scene *s, double from, double to)
{
    uint64_t missing = 0;
    for (unsigned i = 0; i < COUNT; i++) {
        const double t = (double)s->time[i];
        const bool is_inside = t >= from && t <= to;
        for (int row = 0; row < 3; row++) {
            assert_true(isnan(s->out[row][i]) == !is_inside);
        }
        missing += is_inside ? 0u : 1u;
    }
    assert_int_equal(lum_move_counts_without(&s->counts), missing);
}

static void what_has_no_pose_is_counted(void **state)
{
    (void)state;
    lum_poses *poses = make_poses(3, S / 50);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
    run(s);
    assert_nan_outside(s, 0.0, 0.0400005);
    assert_int_equal(s->counts.after, lum_move_counts_without(&s->counts));
    s->counts = (lum_move_counts){.points = 0};
    s->points.begin_ns = BEGIN - S / 50;
    run(s);
    assert_nan_outside(s, 0.0199995, 0.0600005);
    assert_true(s->counts.before > 0 && s->counts.after > 0);
    s->counts = (lum_move_counts){.points = 0};
    s->options.clamps = true;
    run(s);
    assert_true(s->counts.before > 0 && s->counts.after > 0);
    for (unsigned i = 0; i < COUNT; i++) {
        assert_true(!isnan(s->out[0][i]));
    }
    free(s);
    lum_poses_free(poses);
}

static void gaps_have_none_and_their_ends_have(void **state)
{
    (void)state;
    const int64_t times[] = {BEGIN, BEGIN + S / 100, BEGIN + S / 20,
                             BEGIN + S / 10};
    lum_pose list[4];
    lum_poses *poses = NULL;
    const lum_poses_options options = {.struct_size = sizeof options,
                                       .gap_ns = S / 100};
    lum_error error = {""};
    for (size_t i = 0; i < 4; i++) {
        list[i] = on_circle((double)(times[i] - BEGIN) * 1e-9);
    }
    assert_int_equal(lum_poses_new(times, list, 4, &options, &poses, &error),
                     0);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
    for (unsigned i = 0; i < COUNT; i++) { /* exactly at the second, third */
        s->time[i] = i % 3u == 0 ? 0.01f : i % 3u == 1 ? 0.05f : 0.03f;
    }
    run(s);
    assert_int_equal(s->counts.in_gap, COUNT / 3u);
    for (unsigned i = 0; i < COUNT; i++) {
        assert_true(isnan(s->out[0][i]) == (i % 3u == 2));
    }
    s->options.clamps = true;
    run(s);
    for (unsigned i = 0; i < COUNT; i++) { /* 0.03 is as near to both */
        assert_true(!isnan(s->out[0][i]));
    }
    assert_int_equal(s->counts.in_gap, COUNT / 3u * 2u);
    free(s);
    lum_poses_free(poses);
}

static void without_the_moment_nothing_is_moved(void **state)
{
    (void)state;
    lum_poses *poses = make_poses(10, S / 50);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_MIDDLE);
    s->points.start_ns = BEGIN - S;
    s->points.begin_ns = BEGIN - S / 50;
    run(s);
    assert_true(s->counts.before > 0);
    assert_int_equal(s->counts.no_start + s->counts.before, COUNT);
    assert_true(isnan(s->out[0][COUNT - 1u]));
    free(s);
    lum_poses_free(poses);
}

static void a_time_that_is_none_has_no_pose(void **state)
{
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f};
    lum_poses *poses = make_poses(10, S / 50);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
    s->options.clamps = true;
    for (unsigned i = 0; i < 4; i++) {
        s->time[500u * i] = bad[i];
    }
    run(s);
    assert_int_equal(s->counts.no_time, 4);
    for (unsigned i = 0; i < COUNT; i++) {
        const bool is_bad = i % 500u == 0 && i < 2000u;
        assert_true(isnan(s->out[0][i]) == is_bad);
    }
    free(s);
    lum_poses_free(poses);
}

static void options_must_be_right(void **state)
{
    (void)state;
    lum_poses *poses = make_poses(10, S / 50);
    struct scene *s = make_scene(poses, LUM_MOVE_TO_WORLD);
    s->points.struct_size = 0;
    assert_int_equal(lum_points_move(&s->points, &s->options, s->out[0],
                                     s->out[1], s->out[2], &s->counts,
                                     &s->error),
                     -1);
    assert_int_equal(errno, EINVAL);
    s->points.struct_size = sizeof s->points;
    s->options.struct_size = 0;
    assert_int_equal(lum_points_move(&s->points, &s->options, s->out[0],
                                     s->out[1], s->out[2], &s->counts,
                                     &s->error),
                     -1);
    s->options.struct_size = sizeof s->options;
    s->options.to = (lum_move_to)3;
    assert_int_equal(lum_points_move(&s->points, &s->options, s->out[0],
                                     s->out[1], s->out[2], &s->counts,
                                     &s->error),
                     -1);
    assert_string_equal(
        s->error.text,
        "moving: the option to is 3; use a value of lum_move_to");
    assert_int_equal(s->counts.points, 0);
    free(s);
    lum_poses_free(poses);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bound_holds_into_the_world),
        cmocka_unit_test(the_bound_holds_to_a_moment),
        cmocka_unit_test(an_origin_is_taken_off_before_rounding),
        cmocka_unit_test(what_has_no_pose_is_counted),
        cmocka_unit_test(gaps_have_none_and_their_ends_have),
        cmocka_unit_test(without_the_moment_nothing_is_moved),
        cmocka_unit_test(a_time_that_is_none_has_no_pose),
        cmocka_unit_test(options_must_be_right),
    };
    return cmocka_run_group_tests_name("move", tests, NULL, NULL);
}
