#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/points.h"

#include <math.h>
#include <string.h>

#define PI     3.14159265358979323846
#define DEGREE 1000000
#define BOUND  1e-6 /* as lum_directions_compute() promises */

struct vector {
    double x, y, z;
};

struct view {
    double az_center, az_width, el_min, el_max;
    double roll, pitch, yaw;
    double lsb_deg; /* 0: full scale is half the span */
};

/* Calibrations narrow and wide, with every mount rotation. */
static const struct view views[] = {
    {0, 60, -17, 3, 0, 0, -30, 0},
    {0, 60, -17, 3, 0, 0, 30, 0},
    {1.5, 58.25, -14.75, 4.5, 1, -2, 31, 0},
    {-100, 89.999, -89, 0.5, 170, -80, 300, 0},
    {0, 90, -45, 45, 0, 0, 0, 0},
    {0, 90.001, -45, 45, 0, 0, 0, 0},
    {180, 360, -90, 90, 0, 0, 0, 0},
    {-180, 360, -90, 90, -360, 360, -360, 0},
    {10, 0.000001, 0, 0.000001, 45, 45, 45, 0},
    {0, 60, 89, 90, 90, 90, 90, 0},
    {0, 60, -90, -89, 0, -90, 0, 0},
    {0, 60, -17, 3, 0, 0, 0, 0.0009155},
    {0, 60, -17, 3, 10, 20, 30, 0.001373291015625},
    {0, 60, -17, 3, 10, 20, 30, 0.0055},
    {0, 60, -17, 3, 10, 20, 30, 1.0},
};

#define VIEWS (sizeof views / sizeof views[0])

static double rad(double degrees)
{
    return degrees * (PI / 180.0);
}

static int32_t udeg(double degrees)
{
    return (int32_t)lround(degrees * 1e6);
}

static void set_eye(lum_eye_calibration *eye, const struct view *v)
{
    eye->azimuth_center_udeg = udeg(v->az_center);
    eye->azimuth_width_udeg = udeg(v->az_width);
    eye->elevation_min_udeg = udeg(v->el_min);
    eye->elevation_max_udeg = udeg(v->el_max);
    eye->mount_roll_udeg = udeg(v->roll);
    eye->mount_pitch_udeg = udeg(v->pitch);
    eye->mount_yaw_udeg = udeg(v->yaw);
}

static void make_projector(lum_projector *out, const struct view *v)
{
    lum_calibration c;
    lum_layout layout;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    layout.profile.angle_lsb_pdeg = (uint64_t)llround(v->lsb_deg * 1e12);
    set_eye(&c.eye[0], v);
    set_eye(&c.eye[1], v);
    assert_int_equal(lum_projector_init(out, &c, &layout), LUM_OK);
}

static struct vector rotate(struct vector p, double a, int axis)
{
    const double c = cos(a), s = sin(a);
    if (axis == 0) {
        return (struct vector){p.x, c * p.y - s * p.z, s * p.y + c * p.z};
    }
    if (axis == 1) {
        return (struct vector){c * p.x + s * p.z, p.y, c * p.z - s * p.x};
    }
    return (struct vector){c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}

/* Section 7 in double: roll, then pitch, then yaw. */
static struct vector expected(const struct view *v, int raw_az, int raw_el)
{
    const double scale_az =
        v->lsb_deg > 0 ? v->lsb_deg : v->az_width / 2 / 32768;
    const double scale_el =
        v->lsb_deg > 0 ? v->lsb_deg : (v->el_max - v->el_min) / 2 / 32768;
    const double az = rad(v->az_center + raw_az * scale_az);
    const double el = rad((v->el_min + v->el_max) / 2 + raw_el * scale_el);
    struct vector p = {cos(el) * cos(az), cos(el) * sin(az), sin(el)};
    p = rotate(p, rad(v->roll), 0);
    p = rotate(p, rad(v->pitch), 1);
    return rotate(p, rad(v->yaw), 2);
}

/* A line of raw angles, as many as fit. */
struct angles {
    lum_angle angles[LUM_LINE_PIXELS];
    lum_line line;
};

static void point_line(struct angles *a, uint8_t eye)
{
    memset(a, 0, sizeof *a);
    a->line.angles = a->angles;
    a->line.eye = eye;
}

static double distance(const lum_direction *d, struct vector e)
{
    return sqrt((d->x - e.x) * (d->x - e.x) + (d->y - e.y) * (d->y - e.y) +
                (d->z - e.z) * (d->z - e.z));
}

/* The largest error over a line; a NaN fails here and now. */
static double worst_of(const lum_projector *p, const struct view *v,
                       const struct angles *a)
{
    static lum_direction out[LUM_LINE_PIXELS];
    double worst = 0;
    memset(out, 0x5a, sizeof out);
    lum_directions_compute(p, &a->line, out);
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        const double error = distance(
            &out[i], expected(v, a->angles[i].azimuth, a->angles[i].elevation));
        assert_true(error <= 10.0);
        assert_true(out[i].pad >= 0.0f && out[i].pad <= 0.0f);
        worst = error > worst ? error : worst;
    }
    return worst;
}

/* Every raw value of one axis, with the other at value. */
static double worst_over_axis(const struct view *v, int elevations, int other)
{
    static struct angles a;
    lum_projector p;
    double worst = 0;
    int raw = -32768;
    make_projector(&p, v);
    point_line(&a, 0);
    while (raw <= 32767) {
        for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
            const int here = raw <= 32767 ? raw : 32767;
            a.angles[i].azimuth = (int16_t)(elevations ? other : here);
            a.angles[i].elevation = (int16_t)(elevations ? here : other);
            raw++;
        }
        const double error = worst_of(&p, v, &a);
        worst = error > worst ? error : worst;
    }
    return worst;
}

static void every_raw_azimuth_is_within_the_bound(void **state)
{
    static const int others[] = {-32768, 0, 12345, 32767};
    (void)state;
    for (size_t i = 0; i < VIEWS; i++) {
        for (unsigned k = 0; k < 4; k++) {
            const double worst = worst_over_axis(&views[i], 0, others[k]);
            if (worst > BOUND) {
                fail_msg("view %u: off by %g", (unsigned)i, worst);
            }
        }
    }
}

static void every_raw_elevation_is_within_the_bound(void **state)
{
    static const int others[] = {-32768, 0, 12345, 32767};
    (void)state;
    for (size_t i = 0; i < VIEWS; i++) {
        for (unsigned k = 0; k < 4; k++) {
            const double worst = worst_over_axis(&views[i], 1, others[k]);
            if (worst > BOUND) {
                fail_msg("view %u: off by %g", (unsigned)i, worst);
            }
        }
    }
}

/* At 45 degrees, where the series of sine and cosine end: no worse than what
 * float rounds. */
static void the_series_have_terms_enough(void **state)
{
    const struct view v = {0, 90, -45, 45, 0, 0, 0, 0};
    (void)state;
    assert_true(worst_over_axis(&v, 0, 0) < 1.5e-7);
    assert_true(worst_over_axis(&v, 1, 0) < 1.5e-7);
}

static void random_pairs_are_within_the_bound(void **state)
{
    static struct angles a;
    uint64_t seed = 5;
    (void)state;
    for (size_t i = 0; i < VIEWS; i++) {
        lum_projector p;
        make_projector(&p, &views[i]);
        point_line(&a, 1);
        for (unsigned round = 0; round < 20; round++) {
            for (unsigned k = 0; k < LUM_LINE_PIXELS; k++) {
                a.angles[k].azimuth =
                    (int16_t)((int)(next_random(&seed) % 65536u) - 32768);
                a.angles[k].elevation =
                    (int16_t)((int)(next_random(&seed) % 65536u) - 32768);
            }
            const double worst = worst_of(&p, &views[i], &a);
            if (worst > BOUND) {
                fail_msg("view %u: off by %g", (unsigned)i, worst);
            }
        }
    }
}

static void calibrations_of_chance_are_within_the_bound(void **state)
{
    static struct angles a;
    uint64_t seed = 11;
    (void)state;
    for (unsigned round = 0; round < 200; round++) {
        lum_projector p;
        const struct view v = {
            .az_center = next_random(&seed) % 361 - 180.0,
            .az_width = 1.0 + next_random(&seed) % 360,
            .el_min = -90.0 + next_random(&seed) % 90,
            .el_max = 1.0 + next_random(&seed) % 90,
            .roll = next_random(&seed) % 721 - 360.0,
            .pitch = next_random(&seed) % 721 - 360.0,
            .yaw = next_random(&seed) % 721 - 360.0,
        };
        make_projector(&p, &v);
        point_line(&a, 0);
        for (unsigned k = 0; k < LUM_LINE_PIXELS; k++) {
            a.angles[k].azimuth =
                (int16_t)((int)(next_random(&seed) % 65536u) - 32768);
            a.angles[k].elevation =
                (int16_t)((int)(next_random(&seed) % 65536u) - 32768);
        }
        if (worst_of(&p, &v, &a) > BOUND) {
            fail_msg("round %u: off by %g", round, worst_of(&p, &v, &a));
        }
    }
}

static lum_direction look(const struct view *v, unsigned eye, int az, int el)
{
    static struct angles a;
    static lum_direction out[LUM_LINE_PIXELS];
    lum_projector p;
    make_projector(&p, v);
    point_line(&a, (uint8_t)eye);
    a.angles[7].azimuth = (int16_t)az;
    a.angles[7].elevation = (int16_t)el;
    lum_directions_compute(&p, &a.line, out);
    return out[7];
}

static void assert_direction(lum_direction d, double x, double y, double z)
{
    const struct vector e = {x, y, z};
    assert_true(distance(&d, e) < 1e-6);
}

static void axes_are_forward_left_up(void **state)
{
    const struct view v = {0, 180, -90, 90, 0, 0, 0, 0};
    (void)state;
    assert_direction(look(&v, 0, 0, 0), 1, 0, 0);
    assert_direction(look(&v, 0, 16384, 0), sqrt(0.5), sqrt(0.5), 0);
    assert_direction(look(&v, 0, -32768, 0), 0, -1, 0);
    assert_direction(look(&v, 0, 0, 16384), sqrt(0.5), 0, sqrt(0.5));
    assert_direction(look(&v, 0, 0, -32768), 0, 0, -1);
}

static void mounts_turn_by_the_right_hand(void **state)
{
    const struct view yaw = {0, 60, -10, 10, 0, 0, 90, 0};
    const struct view pitch = {0, 60, -10, 10, 0, 90, 0, 0};
    const struct view roll = {90, 60, -10, 10, 90, 0, 0, 0};
    (void)state;
    assert_direction(look(&yaw, 0, 0, 0), 0, 1, 0);
    assert_direction(look(&pitch, 0, 0, 0), 0, 0, -1);
    assert_direction(look(&roll, 0, 0, 0), 0, 0, 1);
}

static void mounts_turn_by_roll_then_pitch_then_yaw(void **state)
{
    /* left, rolled up, pitched to the front, yawed to the left again */
    const struct view v = {90, 60, -10, 10, 90, 90, 90, 0};
    (void)state;
    assert_direction(look(&v, 0, 0, 0), 0, 1, 0);
}

static void each_eye_has_its_own_calibration(void **state)
{
    static struct angles a;
    static lum_direction out[LUM_LINE_PIXELS];
    lum_calibration c;
    lum_layout layout;
    lum_projector p;
    (void)state;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    assert_int_equal(lum_projector_init(&p, &c, &layout), LUM_OK);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const double yaw = rad(eye == LUM_EYE_BLUE ? -30 : 30);
        const double el = rad(-7);
        point_line(&a, (uint8_t)eye);
        lum_directions_compute(&p, &a.line, out);
        assert_direction(out[0], cos(el) * cos(yaw), cos(el) * sin(yaw),
                         sin(el));
    }
}

static void directions_are_unit_vectors(void **state)
{
    (void)state;
    for (size_t i = 0; i < VIEWS; i++) {
        const lum_direction d = look(&views[i], 0, -32768, 32767);
        const double length =
            sqrt((double)d.x * d.x + (double)d.y * d.y + (double)d.z * d.z);
        assert_true(fabs(length - 1.0) < 1e-6);
    }
}

static void a_calibration_out_of_range_is_refused(void **state)
{
    lum_calibration c;
    lum_layout layout;
    lum_projector p;
    (void)state;
    memset(&p, 0x5a, sizeof p);
    const lum_projector before = p;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    c.eye[1].azimuth_width_udeg = 0;
    assert_int_equal(lum_projector_init(&p, &c, &layout), LUM_E_VALUE);
    assert_memory_equal(&p, &before, sizeof p);
}

static void assert_same_place(const lum_projector *a, const lum_projector *b)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        for (unsigned i = 0; i < 9; i++) {
            assert_true(fabs(a->eye[e].exact_rotation[i] -
                             b->eye[e].exact_rotation[i]) < 1e-14);
            assert_true(a->eye[e].rotation[i] ==
                        (float)a->eye[e].exact_rotation[i]);
        }
        for (unsigned i = 0; i < 3; i++) {
            assert_true(fabs(a->eye[e].exact_mount[i] -
                             b->eye[e].exact_mount[i]) < 1e-13);
            assert_true(a->eye[e].mount[i] == (float)a->eye[e].exact_mount[i]);
        }
    }
}

/* What a pose does to a projector without mounts, the mounts do themselves; and
 * poses add up. */
static void a_pose_does_what_a_mount_does(void **state)
{
    static const double at[3] = {1.25, -0.5, 2.0};
    const lum_pose pose = lum_pose_of_angles(at, 10.0, -20.0, 130.0);
    lum_calibration c;
    lum_layout layout;
    lum_projector placed;
    lum_projector mounted;
    (void)state;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        c.eye[e].azimuth_center_udeg = 7 * DEGREE;
        c.eye[e].mount_yaw_udeg = 0;
    }
    assert_int_equal(lum_projector_init(&placed, &c, &layout), LUM_OK);
    lum_projector_place(&placed, &pose);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        c.eye[e].mount_um[0] = 1250000;
        c.eye[e].mount_um[1] = -500000;
        c.eye[e].mount_um[2] = 2000000;
        c.eye[e].mount_roll_udeg = 10 * DEGREE;
        c.eye[e].mount_pitch_udeg = -20 * DEGREE;
        c.eye[e].mount_yaw_udeg = 130 * DEGREE;
    }
    assert_int_equal(lum_projector_init(&mounted, &c, &layout), LUM_OK);
    assert_same_place(&placed, &mounted);
    const lum_pose twice = lum_pose_compose(&pose, &pose);
    const lum_pose back = lum_pose_inverse(&pose);
    lum_projector_place(&placed, &pose);
    lum_projector_place(&mounted, &back);
    lum_projector_place(&mounted, &twice);
    assert_same_place(&placed, &mounted);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(every_raw_azimuth_is_within_the_bound),
    cmocka_unit_test(every_raw_elevation_is_within_the_bound),
    cmocka_unit_test(the_series_have_terms_enough),
    cmocka_unit_test(random_pairs_are_within_the_bound),
    cmocka_unit_test(calibrations_of_chance_are_within_the_bound),
    cmocka_unit_test(axes_are_forward_left_up),
    cmocka_unit_test(mounts_turn_by_the_right_hand),
    cmocka_unit_test(mounts_turn_by_roll_then_pitch_then_yaw),
    cmocka_unit_test(each_eye_has_its_own_calibration),
    cmocka_unit_test(directions_are_unit_vectors),
    cmocka_unit_test(a_calibration_out_of_range_is_refused),
    cmocka_unit_test(a_pose_does_what_a_mount_does),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
