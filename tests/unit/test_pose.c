#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/pose.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

static void assert_near(double a, double b, double within)
{
    if (!(fabs(a - b) <= within)) {
        fail_msg("%.17g is not %.17g within %g", a, b, within);
    }
}

static void assert_same(const lum_pose *a, const lum_pose *b, double within)
{
    for (int i = 0; i < 3; i++) {
        assert_near(a->at[i], b->at[i], within);
    }
    assert_near(lum_pose_angle(a, b), 0.0, within);
}

static lum_pose about_z(double angle, double x, double y, double z)
{
    const lum_pose pose = {{x, y, z},
                           {0.0, 0.0, sin(angle / 2.0), cos(angle / 2.0)}};
    return pose;
}

static const lum_pose tilted = {{1.0, -2.0, 3.0}, {0.1, -0.7, 0.1, 0.7}};

static void a_turn_left_takes_forward_to_left(void **state)
{
    (void)state;
    const lum_pose pose = about_z(PI / 2.0, 10.0, 20.0, 30.0);
    double p[3] = {1.0, 2.0, 3.0};
    lum_pose_apply(&pose, p, p);
    assert_near(p[0], 8.0, 1e-14);
    assert_near(p[1], 21.0, 1e-14);
    assert_near(p[2], 33.0, 1e-14);
}

static void a_matrix_does_what_the_pose_does(void **state)
{
    (void)state;
    const double p[3] = {4.0, 5.0, -6.0};
    double m[12];
    double expected[3];
    lum_pose_matrix(&tilted, m);
    lum_pose_apply(&tilted, p, expected);
    for (int r = 0; r < 3; r++) {
        const double *row = m + 4 * r;
        assert_near(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3],
                    expected[r], 1e-13);
    }
}

static void a_pose_and_its_inverse_are_none(void **state)
{
    (void)state;
    const lum_pose identity = lum_pose_identity();
    const lum_pose back = lum_pose_inverse(&tilted);
    const lum_pose there = lum_pose_compose(&tilted, &back);
    const lum_pose here = lum_pose_compose(&back, &tilted);
    assert_same(&there, &identity, 1e-14);
    assert_same(&here, &identity, 1e-14);
}

static void composition_is_one_after_the_other(void **state)
{
    (void)state;
    const lum_pose inner = about_z(0.3, 5.0, 6.0, 7.0);
    const lum_pose both = lum_pose_compose(&tilted, &inner);
    const double p[3] = {-1.0, 0.5, 2.0};
    double a[3];
    double b[3];
    lum_pose_apply(&inner, p, a);
    lum_pose_apply(&tilted, a, a);
    lum_pose_apply(&both, p, b);
    for (int i = 0; i < 3; i++) {
        assert_near(a[i], b[i], 1e-13);
    }
}

/* A car on a circle of radius r that also climbs: its pose at each angle is
 * known. */
static lum_pose on_helix(double angle)
{
    const double r = 8.0;
    const lum_pose local =
        about_z(angle, r * sin(angle), r - r * cos(angle), 0.5 * angle);
    return lum_pose_compose(&tilted, &local);
}

static void between_two_poses_of_a_helix_is_the_helix(void **state)
{
    (void)state;
    static const double turns[] = {1e-12, 1e-10, 1e-8, 1e-3, 1.0, 3.0, 3.14};
    static const double shares[] = {-0.5, 0.0, 0.25, 0.5, 0.9, 1.0, 1.5};
    for (size_t t = 0; t < sizeof turns / sizeof *turns; t++) {
        const lum_pose a = on_helix(0.7);
        const lum_pose b = on_helix(0.7 + turns[t]);
        for (size_t s = 0; s < sizeof shares / sizeof *shares; s++) {
            const lum_pose exact = on_helix(0.7 + shares[s] * turns[t]);
            const lum_pose got = lum_pose_between(&a, &b, shares[s]);
            assert_same(&got, &exact, 1e-13);
        }
    }
}

static void between_goes_the_shorter_way_round(void **state)
{
    (void)state;
    const lum_pose a = about_z(0.0, 0.0, 0.0, 0.0);
    lum_pose b = about_z(0.2, 0.0, 0.0, 0.0);
    for (int i = 0; i < 4; i++) {
        b.turn[i] = -b.turn[i];
    }
    const lum_pose got = lum_pose_between(&a, &b, 0.5);
    assert_near(lum_pose_angle(&a, &got), 0.1, 1e-15);
    assert_near(lum_pose_angle(&a, &b), 0.2, 1e-15);
}

static void normalizing_takes_any_length(void **state)
{
    (void)state;
    static const double lengths[] = {1e-300, 0.5, 1.0, 2.0, 1e300};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        lum_pose p = about_z(1.0, 1.0, 2.0, 3.0);
        const lum_pose unit = p;
        for (int k = 0; k < 4; k++) {
            p.turn[k] *= lengths[i];
        }
        assert_true(lum_pose_normalize(&p));
        for (int k = 0; k < 4; k++) {
            assert_near(p.turn[k], unit.turn[k], 1e-15);
        }
    }
}

static void what_is_no_pose_is_left_as_it_is(void **state)
{
    (void)state;
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        for (int k = 0; k < 7; k++) {
            lum_pose p = tilted;
            *(k < 3 ? &p.at[k] : &p.turn[k - 3]) = bad[i];
            const lum_pose before = p;
            assert_false(lum_pose_normalize(&p));
            assert_memory_equal(&p, &before, sizeof p);
        }
    }
    lum_pose zero = {{1.0, 2.0, 3.0}, {0.0, 0.0, 0.0, 0.0}};
    assert_false(lum_pose_normalize(&zero));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_turn_left_takes_forward_to_left),
        cmocka_unit_test(a_matrix_does_what_the_pose_does),
        cmocka_unit_test(a_pose_and_its_inverse_are_none),
        cmocka_unit_test(composition_is_one_after_the_other),
        cmocka_unit_test(between_two_poses_of_a_helix_is_the_helix),
        cmocka_unit_test(between_goes_the_shorter_way_round),
        cmocka_unit_test(normalizing_takes_any_length),
        cmocka_unit_test(what_is_no_pose_is_left_as_it_is),
    };
    return cmocka_run_group_tests_name("pose", tests, NULL, NULL);
}
