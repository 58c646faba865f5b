#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/calibration.h"
#include "lum/group.h"

#define DEGREE INT64_C(1000000)
#define KM_UM  INT64_C(1000000000)

static lum_calibration defaults(void)
{
    lum_calibration c;
    lum_calibration_default(&c);
    return c;
}

static void assert_fault(const lum_calibration *c, lum_calibration_fault fault,
                         unsigned eye)
{
    lum_calibration_fault found = LUM_CALIBRATION_FINE;
    unsigned where = 77;
    const lum_result r = fault == LUM_CALIBRATION_FINE ? LUM_OK : LUM_E_VALUE;
    assert_int_equal(lum_calibration_check(c, &found, &where), r);
    assert_int_equal(found, fault);
    assert_int_equal(where, eye);
    assert_int_equal(lum_calibration_check(c, NULL, NULL), r);
}

static void the_default_is_the_manuals_typical_values(void **state)
{
    const lum_calibration c = defaults();
    (void)state;
    assert_int_equal(c.speed_of_light, 300000000);
    assert_int_equal(c.tof_lsb_fs, 13000);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const lum_eye_calibration *e = &c.eye[eye];
        assert_true(e->tof_offset_fs == 0);
        assert_int_equal(e->azimuth_center_udeg, 0);
        assert_int_equal(e->azimuth_width_udeg, 60 * DEGREE);
        assert_true(e->elevation_min_udeg == -17 * DEGREE);
        assert_int_equal(e->elevation_max_udeg, 3 * DEGREE);
        assert_true(e->mount_um[0] == 0 && e->mount_um[1] == 0 &&
                    e->mount_um[2] == 0);
        assert_true(e->mount_roll_udeg == 0 && e->mount_pitch_udeg == 0);
    }
    assert_true(c.eye[LUM_EYE_BLUE].mount_yaw_udeg == -30 * DEGREE);
    assert_true(c.eye[LUM_EYE_GREEN].mount_yaw_udeg == 30 * DEGREE);
    assert_fault(&c, LUM_CALIBRATION_FINE, 0);
}

static void set_speed(lum_calibration *c, unsigned eye, int64_t v)
{
    (void)eye;
    c->speed_of_light = (uint32_t)v;
}
static void set_lsb(lum_calibration *c, unsigned eye, int64_t v)
{
    (void)eye;
    c->tof_lsb_fs = (uint32_t)v;
}
static void set_offset(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].tof_offset_fs = v;
}
static void set_center(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].azimuth_center_udeg = (int32_t)v;
}
static void set_width(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].azimuth_width_udeg = (int32_t)v;
}
static void set_min(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].elevation_min_udeg = (int32_t)v;
    c->eye[eye].elevation_max_udeg = (int32_t)(90 * DEGREE);
}
static void set_max(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].elevation_min_udeg = (int32_t)(-90 * DEGREE);
    c->eye[eye].elevation_max_udeg = (int32_t)v;
}
static void set_order(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].elevation_max_udeg =
        (int32_t)(c->eye[eye].elevation_min_udeg + v);
}
static void set_x(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_um[0] = (int32_t)v;
}
static void set_y(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_um[1] = (int32_t)v;
}
static void set_z(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_um[2] = (int32_t)v;
}
static void set_roll(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_roll_udeg = (int32_t)v;
}
static void set_pitch(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_pitch_udeg = (int32_t)v;
}
static void set_yaw(lum_calibration *c, unsigned eye, int64_t v)
{
    c->eye[eye].mount_yaw_udeg = (int32_t)v;
}

static const struct {
    void (*set)(lum_calibration *, unsigned, int64_t);
    lum_calibration_fault fault;
    int64_t min;
    int64_t max;
    unsigned eyes; /* 1 for what the sensor has once */
} limits[] = {
    {set_speed, LUM_CALIBRATION_SPEED_OF_LIGHT, 200000000, 310000000, 1},
    {set_lsb, LUM_CALIBRATION_TOF_LSB, 1, 1000000, 1},
    {set_offset, LUM_CALIBRATION_TOF_OFFSET, INT64_C(-10000000000),
     INT64_C(10000000000), 2},
    {set_center, LUM_CALIBRATION_AZIMUTH_CENTER, -180 * DEGREE, 180 * DEGREE,
     2},
    {set_width, LUM_CALIBRATION_AZIMUTH_WIDTH, 1, 360 * DEGREE, 2},
    {set_min, LUM_CALIBRATION_ELEVATION_MIN, -90 * DEGREE, 90 * DEGREE - 1, 2},
    {set_max, LUM_CALIBRATION_ELEVATION_MAX, -90 * DEGREE + 1, 90 * DEGREE, 2},
    {set_order, LUM_CALIBRATION_ELEVATION_ORDER, 1, 107 * DEGREE, 2},
    {set_x, LUM_CALIBRATION_MOUNT_X, -KM_UM, KM_UM, 2},
    {set_y, LUM_CALIBRATION_MOUNT_Y, -KM_UM, KM_UM, 2},
    {set_z, LUM_CALIBRATION_MOUNT_Z, -KM_UM, KM_UM, 2},
    {set_roll, LUM_CALIBRATION_MOUNT_ROLL, -360 * DEGREE, 360 * DEGREE, 2},
    {set_pitch, LUM_CALIBRATION_MOUNT_PITCH, -360 * DEGREE, 360 * DEGREE, 2},
    {set_yaw, LUM_CALIBRATION_MOUNT_YAW, -360 * DEGREE, 360 * DEGREE, 2},
};

static void each_value_is_taken_at_its_limits(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        for (unsigned eye = 0; eye < limits[i].eyes; eye++) {
            lum_calibration c = defaults();
            limits[i].set(&c, eye, limits[i].min);
            assert_fault(&c, LUM_CALIBRATION_FINE, 0);
            limits[i].set(&c, eye, limits[i].max);
            assert_fault(&c, LUM_CALIBRATION_FINE, 0);
        }
    }
}

/* Past an end of the elevations the other end, or their order, is at fault. */
static void assert_past(size_t i, unsigned eye, int64_t value)
{
    lum_calibration c = defaults();
    lum_calibration_fault found = LUM_CALIBRATION_FINE;
    unsigned where = 77;
    limits[i].set(&c, eye, value);
    assert_int_equal(lum_calibration_check(&c, &found, &where), LUM_E_VALUE);
    assert_int_equal(where, eye);
    if (limits[i].fault < LUM_CALIBRATION_ELEVATION_MIN ||
        limits[i].fault > LUM_CALIBRATION_ELEVATION_ORDER) {
        assert_int_equal(found, limits[i].fault);
    } else {
        assert_in_range(found, LUM_CALIBRATION_ELEVATION_MIN,
                        LUM_CALIBRATION_ELEVATION_ORDER);
    }
}

static void each_value_is_refused_past_its_limits(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        for (unsigned eye = 0; eye < limits[i].eyes; eye++) {
            assert_past(i, eye, limits[i].min - 1);
            assert_past(i, eye, limits[i].max + 1);
        }
    }
}

static void elevations_are_in_order(void **state)
{
    lum_calibration c = defaults();
    (void)state;
    c.eye[1].elevation_max_udeg = c.eye[1].elevation_min_udeg;
    assert_fault(&c, LUM_CALIBRATION_ELEVATION_ORDER, 1);
    c.eye[1].elevation_min_udeg = (int32_t)(-90 * DEGREE - 1);
    assert_fault(&c, LUM_CALIBRATION_ELEVATION_MIN, 1);
    c = defaults();
    c.eye[1].elevation_max_udeg = (int32_t)(90 * DEGREE + 1);
    assert_fault(&c, LUM_CALIBRATION_ELEVATION_MAX, 1);
}

/* The smallest t that fulfils the sentence, by looking. */
static void assert_min_tof(uint32_t lsb, int64_t offset, int32_t expected)
{
    lum_calibration c = defaults();
    c.tof_lsb_fs = lsb;
    c.eye[1].tof_offset_fs = offset;
    const int32_t t = lum_calibration_min_tof(&c, 1);
    assert_int_equal(t, expected);
    if (t <= LUM_TOF_MAX) {
        assert_true(t * (int64_t)lsb + offset > 0);
    }
    if (t > LUM_TOF_MIN) {
        assert_true((t - 1) * (int64_t)lsb + offset <= 0);
    }
    assert_int_equal(lum_calibration_min_tof(&c, 0), 1);
}

static void the_least_tof_gives_a_range_above_zero(void **state)
{
    (void)state;
    assert_min_tof(13000, 0, 1);
    assert_min_tof(13000, 1, 0);
    assert_min_tof(13000, 12999, 0);
    assert_min_tof(13000, 13000, 0);
    assert_min_tof(13000, 13001, -1);
    assert_min_tof(13000, -1, 1);
    assert_min_tof(13000, -12999, 1);
    assert_min_tof(13000, -13000, 2);
    assert_min_tof(13000, -13001, 2);
    assert_min_tof(1, -524286, 524287);
    assert_min_tof(1, -524287, 524288);
    assert_min_tof(1, INT64_C(-10000000000), 524288);
    assert_min_tof(1, 524288, -524287);
    assert_min_tof(1, 524289, -524288);
    assert_min_tof(1, INT64_C(10000000000), -524288);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_is_the_manuals_typical_values),
        cmocka_unit_test(each_value_is_taken_at_its_limits),
        cmocka_unit_test(each_value_is_refused_past_its_limits),
        cmocka_unit_test(elevations_are_in_order),
        cmocka_unit_test(the_least_tof_gives_a_range_above_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
