#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/pose.h"
#include "sim/path.h"
#include "sim/place.h"
#include "sim/render.h"
#include "sim/shape.h"
#include "sim/town.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EXACT_M 0.001

struct fixture {
    lum_render_options options;
    lum_render render;
    lum_sim_line line;
    lum_sim_line other;
};

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return -1;
    }
    lum_render_options_default(&f->options);
    f->options.seed = 3;
    f->options.calibration.eye[LUM_EYE_BLUE].mount_um[0] = 60000;
    f->options.calibration.eye[LUM_EYE_GREEN].mount_um[1] = -90000;
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

static void begin(struct fixture *f, lum_place_kind kind, lum_path_kind path,
                  double velocity)
{
    lum_render_free(&f->render);
    f->options.place.kind = kind;
    f->options.place.path.kind = path;
    f->options.place.path.velocity_m_s = velocity;
    assert_int_equal(lum_render_init(&f->render, &f->options), LUM_OK);
}

static void render(struct fixture *f, int64_t frame, uint32_t line,
                   unsigned eye)
{
    assert_int_equal(lum_render_line(&f->render, frame, line, eye, &f->line),
                     LUM_OK);
}

/* A point of the line in the frame that is on the path. */
static void to_vehicle(const struct fixture *f, const lum_sample *s,
                       double out[3])
{
    const lum_place_options *place = &f->options.place;
    const lum_pose pose =
        place->is_on_vehicle ? place->on_vehicle : lum_pose_identity();
    const double in[3] = {(double)s->x, (double)s->y, (double)s->z};
    lum_pose_apply(&pose, in, out);
}

/* The same by the poses that are written: of this line and of the next one. */
static void to_place(const struct fixture *f, const lum_sample *s,
                     double out[3])
{
    const lum_sim_line *l = &f->line;
    const bool is_last = l->number + 1 == f->options.lines;
    const lum_pose now = lum_render_pose(&f->render, l->frame, l->number);
    const lum_pose next =
        lum_render_pose(&f->render, is_last ? l->frame + 1 : l->frame,
                        is_last ? 0 : l->number + 1);
    const lum_pose pose =
        lum_pose_between(&now, &next, (double)s->pixel / LUM_LINE_PIXELS);
    double in[3];
    to_vehicle(f, s, in);
    lum_pose_apply(&pose, in, out);
}

/* --- Paths --- */

static void test_a_circuit_closes(void **state)
{
    (void)state;
    lum_path path = {.kind = LUM_PATH_CIRCLE,
                     .velocity_m_s = 1.0,
                     .course = lum_town_circuit()};
    const double length = lum_course_length(&path.course);
    const lum_pose first = lum_path_at(&path, 0.0);
    const lum_pose last = lum_path_at(&path, length - 1e-9);
    const lum_pose again = lum_path_at(&path, length);
    double farthest = 0.0;
    assert_true(length > 500.0);
    assert_memory_equal(&first, &again, sizeof first);
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(last.at[i] - first.at[i]) < 1e-8);
    }
    assert_true(lum_pose_angle(&first, &last) < 1e-8);
    for (double s = 0.5; s < length; s += 0.5) {
        const lum_pose before = lum_path_at(&path, s - 0.5);
        const lum_pose now = lum_path_at(&path, s);
        const double dx = now.at[0] - before.at[0];
        const double dy = now.at[1] - before.at[1];
        assert_true(hypot(dx, dy) > 0.499 && hypot(dx, dy) < 0.5001);
        assert_true(lum_pose_angle(&before, &now) < 0.5 / 8.0 + 1e-9);
        assert_true(lum_town_is_open(now.at, 0.5));
        farthest = fmax(farthest, hypot(now.at[0], now.at[1]));
    }
    assert_true(farthest > 150.0);
}

static void test_it_stops_and_goes(void **state)
{
    (void)state;
    const lum_path path = {.kind = LUM_PATH_STOP_AND_GO, .velocity_m_s = 8.0};
    double fastest = 0.0;
    double stood_s = 0.0;
    for (int i = 0; i < 2400; i++) {
        const double v = (lum_path_at(&path, (i + 1) * 0.01).at[0] -
                          lum_path_at(&path, i * 0.01).at[0]) /
                         0.01;
        assert_true(v > -1e-9 && v < 8.0 + 1e-6);
        fastest = fmax(fastest, v);
        stood_s += v < 1e-9 ? 0.01 : 0.0;
    }
    assert_true(fastest > 8.0 - 1e-6);
    assert_true(stood_s > 5.9 && stood_s < 6.1);
}

static void test_given_poses_are_gone_through(void **state)
{
    (void)state;
    const lum_pose poses[3] = {{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0, 1.0}},
                               {{4.0, 0.0, 1.0}, {0.0, 0.0, 0.0, 1.0}},
                               {{4.0, 1.0, 1.0}, {0.0, 0.0, 0.0, 1.0}}};
    const double times_s[3] = {0.0, 2.0, 2.5};
    const lum_path path = {
        .kind = LUM_PATH_POSES, .poses = poses, .times_s = times_s, .count = 3};
    assert_true(fabs(lum_path_at(&path, 0.5).at[0] - 1.0) < 1e-12);
    assert_true(fabs(lum_path_at(&path, 2.25).at[1] - 0.5) < 1e-12);
    assert_true(lum_path_at(&path, -1.0).at[0] == 0.0);
    assert_true(lum_path_at(&path, 9.0).at[1] == 1.0);
    assert_true(lum_path_fastest(&path, 0.0) >= 2.0);
}

/* --- What a moving sensor sees --- */

/* How far a point is from the walls and the floor of the yard. */
static double from_yard(const double at[3])
{
    const double x = fabs(fabs(at[0]) - 15.0);
    const double y = fabs(fabs(at[1]) - 10.0);
    return fmin(fmin(x, y), fabs(at[2]));
}

static void see_walls(struct fixture *f)
{
    size_t count = 0;
    size_t bent = 0;
    begin(f, LUM_PLACE_YARD, LUM_PATH_EIGHT, 12.0);
    for (uint32_t n = 0; n < 16; n++) {
        const lum_pose frame = lum_render_pose(&f->render, 3, 0);
        render(f, 3, n, n % LUM_EYES);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            const lum_sample *s = &f->line.truth[i];
            double in[3];
            double at[3];
            const unsigned thing = f->line.labels[i].thing;
            if (thing != LUM_THING_GROUND && thing != LUM_THING_BUILDING) {
                continue;
            }
            to_place(f, s, at);
            assert_true(from_yard(at) < EXACT_M);
            if (thing == LUM_THING_GROUND) {
                continue;
            }
            to_vehicle(f, s, in);
            lum_pose_apply(&frame, in, at);
            bent += from_yard(at) > 10.0 * EXACT_M;
            count++;
        }
    }
    assert_true(count > 1000);
    assert_true(bent > count / 2);
}

static void test_walls_are_flat_by_the_poses_alone(void **state)
{
    see_walls(*state);
}

/* Half of a turn about the sensor's x, and a quarter to the left. */
static const lum_pose aside = {{1.2, -0.4, 1.8}, {0.5, 0.5, 0.5, 0.5}};

static void test_so_they_are_by_the_poses_of_a_vehicle(void **state)
{
    struct fixture *f = *state;
    f->options.place.is_on_vehicle = true;
    f->options.place.on_vehicle = aside;
    f->options.start = (lum_render_start){
        .clock_us = 123456, .late_us = 41000, .slow_ppm = 900.0, .number = 1};
    see_walls(f);
    assert_true(f->line.clock_us == 123456 + 223437);
    assert_true(f->line.first_us == 123456);
    assert_true(lum_render_drive_ns(&f->render, 123456000) == 41000000);
    assert_true(lum_render_drive_ns(&f->render, 1123456000) == 1041900000);
}

/* By the screw between any two poses. */
static void test_a_lever_is_no_faster_than_said(void **state)
{
    (void)state;
    const lum_pose poses[2] = {{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0, 1.0}},
                               {{0.5, 0.2, 1.0}, {0.0, 0.0, 0.6, 0.8}}};
    const double times_s[2] = {0.0, 0.25};
    lum_path path = {
        .kind = LUM_PATH_POSES, .poses = poses, .times_s = times_s, .count = 2};
    for (int i = 0; i < 2; i++) {
        const double most = lum_path_fastest(&path, 1.3);
        double fastest = 0.0;
        for (double t = 0.0; t < 0.249; t += 0.001) {
            const double lever[3] = {0.3, 1.25, 0.0};
            double at[2][3];
            const lum_pose now = lum_path_at(&path, t);
            const lum_pose next = lum_path_at(&path, t + 0.001);
            lum_pose_apply(&now, lever, at[0]);
            lum_pose_apply(&next, lever, at[1]);
            fastest =
                fmax(fastest,
                     hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]) / 0.001);
        }
        assert_true(fastest < most && fastest > most / 3.0);
        path = (lum_path){.kind = LUM_PATH_CIRCLE,
                          .velocity_m_s = 3.0,
                          .course = lum_town_circuit()};
    }
}

/* Two that are at one place at one time. */
static void test_each_sensor_has_its_own_noise(void **state)
{
    struct fixture *f = *state;
    begin(f, LUM_PLACE_YARD, LUM_PATH_EIGHT, 2.0);
    render(f, 1, 5, LUM_EYE_BLUE);
    f->other = f->line;
    f->options.start.number = 1;
    begin(f, LUM_PLACE_YARD, LUM_PATH_EIGHT, 2.0);
    render(f, 1, 5, LUM_EYE_BLUE);
    assert_true(f->line.truth[0].range == f->other.truth[0].range);
    assert_memory_not_equal(f->line.angles, f->other.angles,
                            sizeof f->line.angles);
    assert_memory_not_equal(f->line.words, f->other.words,
                            100 * sizeof f->line.words[0]);
}

static void test_a_line_does_not_depend_on_those_before_it(void **state)
{
    struct fixture *f = *state;
    begin(f, LUM_PLACE_TOWN, LUM_PATH_CIRCLE, 10.0);
    render(f, 2, 40, LUM_EYE_GREEN);
    f->other = f->line;
    begin(f, LUM_PLACE_TOWN, LUM_PATH_CIRCLE, 10.0);
    render(f, 1, 3, LUM_EYE_BLUE);
    render(f, 2, 63, LUM_EYE_BLUE);
    render(f, 2, 40, LUM_EYE_GREEN);
    assert_true(f->line.truth_count > 500);
    assert_int_equal(f->line.word_count, f->other.word_count);
    assert_memory_equal(f->line.words, f->other.words,
                        f->line.word_count * sizeof f->line.words[0]);
    assert_memory_equal(f->line.labels, f->other.labels,
                        f->line.truth_count * sizeof f->line.labels[0]);
}

/* Roads and pavements lie at their heights, also where they are only reached
 * over a kerb, all the way round. */
static void test_the_ground_of_a_town_is_flat(void **state)
{
    struct fixture *f = *state;
    size_t count[2] = {0};
    begin(f, LUM_PLACE_TOWN, LUM_PATH_CIRCLE, 20.0);
    for (int64_t frame = 1; frame < 300; frame += 37) {
        render(f, frame, 50, LUM_EYE_BLUE);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            double at[3];
            if (f->line.labels[i].object != LUM_OBJECT_GROUND) {
                continue;
            }
            to_place(f, &f->line.truth[i], at);
            assert_true(at[2] > -EXACT_M && at[2] < 0.13 + EXACT_M);
            count[0] += at[2] < EXACT_M;
            count[1] += at[2] > 0.13 - EXACT_M;
        }
    }
    assert_true(count[0] > 1000);
    assert_true(count[1] > 100);
}

/* --- Objects that move --- */

struct seen {
    uint32_t object;
    size_t count;
    double low[2];
    double high[2];
};

static void look_for(struct fixture *f, int64_t frame, struct seen *out)
{
    *out = (struct seen){
        .object = out->object, .low = {1e9, 1e9}, .high = {-1e9, -1e9}};
    for (uint32_t n = 4; n < 34; n++) {
        render(f, frame, n, LUM_EYE_GREEN);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            const lum_label *label = &f->line.labels[i];
            double at[3];
            if (label->object != out->object || label->is_mixed) {
                continue;
            }
            to_place(f, &f->line.truth[i], at);
            for (int k = 0; k < 2; k++) {
                out->low[k] = fmin(out->low[k], at[k]);
                out->high[k] = fmax(out->high[k], at[k]);
            }
            out->count++;
        }
    }
}

/* The vehicle with the most points among those that move, if it is near. */
static uint32_t find_mover(const struct fixture *f)
{
    uint32_t best = 0;
    size_t most = 0;
    for (size_t i = 0; i < f->line.truth_count; i++) {
        const lum_label *is = &f->line.labels[i];
        size_t count = 0;
        for (size_t k = 0; k < f->line.truth_count; k++) {
            count += f->line.labels[k].object == is->object;
        }
        if (is->object >= 0x10000000u && count > most && count > 40) {
            most = count;
            best = is->object;
        }
    }
    return best;
}

/* One that comes along the sensor's street, on the other side. */
static void test_a_car_that_moves_is_one_object(void **state)
{
    struct fixture *f = *state;
    struct seen now = {0};
    struct seen later = {0};
    int64_t frame = 0;
    begin(f, LUM_PLACE_TOWN, LUM_PATH_CIRCLE, 5.0);
    while (now.object == 0 && frame < 100) {
        frame += 5;
        for (uint32_t n = 8; n < 20 && now.object == 0; n++) {
            render(f, frame, n, LUM_EYE_GREEN);
            now.object = find_mover(f);
        }
    }
    later.object = now.object;
    look_for(f, frame, &now);
    look_for(f, frame + 2, &later);
    assert_true(now.count > 50 && later.count > 50);
    /* A car or a van; in a frame it drives 0.8 m. */
    assert_true(now.high[0] - now.low[0] < 5.3 + 0.8);
    assert_true(now.high[1] - now.low[1] < 2.1);
    assert_true(fabs(now.low[0] - later.low[0] - 1.6) < 0.4);
    assert_true(fabs(now.low[1] - later.low[1]) < 0.1);
}

/* The first vehicle of its lane, which keeps its distance to it. */
#define LEADER UINT32_C(0x28000001)

/* How far ahead of the vehicle the leader's end is, by one frame. */
static double find_leader(struct fixture *f, unsigned eye)
{
    double nearest = 100.0;
    begin(f, LUM_PLACE_STREET, LUM_PATH_STRAIGHT, 8.0);
    for (uint32_t n = 0; n < f->options.lines; n++) {
        render(f, 2, n, eye);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            double at[3];
            to_vehicle(f, &f->line.truth[i], at);
            if (f->line.labels[i].object == LEADER) {
                nearest = fmin(nearest, at[0]);
            }
        }
    }
    return nearest;
}

static void test_sensors_of_a_vehicle_see_one_street(void **state)
{
    struct fixture *f = *state;
    const double alone = find_leader(f, LUM_EYE_BLUE);
    f->options.place.is_on_vehicle = true;
    f->options.place.on_vehicle = lum_pose_identity();
    f->options.place.on_vehicle.at[0] = -1.5;
    f->options.place.on_vehicle.at[2] = 2.0;
    f->options.start.late_us = 43000;
    const double behind = find_leader(f, LUM_EYE_GREEN);
    assert_true(alone > 5.0 && alone < 20.0);
    assert_true(fabs(alone - behind) < 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_circuit_closes),
        cmocka_unit_test(test_it_stops_and_goes),
        cmocka_unit_test(test_given_poses_are_gone_through),
        cmocka_unit_test(test_a_lever_is_no_faster_than_said),
        cmocka_unit_test_setup_teardown(test_walls_are_flat_by_the_poses_alone,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            test_so_they_are_by_the_poses_of_a_vehicle, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_each_sensor_has_its_own_noise,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            test_sensors_of_a_vehicle_see_one_street, set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            test_a_line_does_not_depend_on_those_before_it, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_the_ground_of_a_town_is_flat,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_a_car_that_moves_is_one_object,
                                        set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
