#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/keys.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The keys below an eye's, in order, with what describes them. */
static const struct {
    const char *name;
    const char *unit;
    const char *min;
    const char *max;
    const char *allowed;
    const char *usual[LUM_EYES];
    int decimals;
} eye_keys[] = {
    {"tof_offset_ps",
     "ps",
     "-10000000",
     "10000000",
     "-10000000 to 10000000 ps",
     {"0", "0"},
     3},
    {"azimuth.center_deg",
     "deg",
     "-180",
     "180",
     "-180 to 180 deg",
     {"0", "0"},
     6},
    {"azimuth.width_deg",
     "deg",
     "0.000001",
     "360",
     "above 0, at most 360 deg",
     {"60", "60"},
     6},
    {"elevation.min_deg",
     "deg",
     "-90",
     "90",
     "-90 to 90 deg",
     {"-17", "-17"},
     6},
    {"elevation.max_deg", "deg", "-90", "90", "-90 to 90 deg", {"3", "3"}, 6},
    {"mount.x_m", "m", "-1000", "1000", "-1000 to 1000 m", {"0", "0"}, 6},
    {"mount.y_m", "m", "-1000", "1000", "-1000 to 1000 m", {"0", "0"}, 6},
    {"mount.z_m", "m", "-1000", "1000", "-1000 to 1000 m", {"0", "0"}, 6},
    {"mount.roll_deg", "deg", "-360", "360", "-360 to 360 deg", {"0", "0"}, 6},
    {"mount.pitch_deg", "deg", "-360", "360", "-360 to 360 deg", {"0", "0"}, 6},
    {"mount.yaw_deg",
     "deg",
     "-360",
     "360",
     "-360 to 360 deg",
     {"-30", "30"},
     6},
};

static const char *const eye_names[LUM_EYES] = {"blue", "green"};

static void name_key(unsigned eye, size_t k, char out[LUM_KEY_BYTES])
{
    (void)snprintf(out, LUM_KEY_BYTES, "eyes.%s.%s", eye_names[eye],
                   eye_keys[k].name);
}

static void set(lum_keys *keys, const char *key, const char *value,
                uint32_t place)
{
    lum_key_refusal why;
    if (lum_keys_set(keys, key, value, place, &why) != LUM_OK) {
        fail_msg("%s=%s: %s", key, value, why.text);
    }
}

static void assert_value(const lum_keys *keys, const char *key,
                         const char *expected)
{
    char text[LUM_KEY_VALUE_BYTES];
    assert_int_equal(lum_keys_get(keys, key, text), LUM_OK);
    assert_string_equal(text, expected);
}

/* The field of an eye that its k-th key is about. */
static int64_t field(const lum_eye_calibration *e, size_t k)
{
    const int64_t fields[COUNT(eye_keys)] = {
        e->tof_offset_fs,      e->azimuth_center_udeg, e->azimuth_width_udeg,
        e->elevation_min_udeg, e->elevation_max_udeg,  e->mount_um[0],
        e->mount_um[1],        e->mount_um[2],         e->mount_roll_udeg,
        e->mount_pitch_udeg,   e->mount_yaw_udeg};
    return fields[k];
}

static void every_key_of_a_calibration_is_described(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key key;
    lum_keys_of_calibration(&keys, NULL);
    for (size_t i = 0; i < LUM_EYES * COUNT(eye_keys); i++) {
        const size_t k = i % COUNT(eye_keys);
        const unsigned eye = (unsigned)(i / COUNT(eye_keys));
        char name[LUM_KEY_BYTES];
        name_key(eye, k, name);
        assert_int_equal(lum_keys_describe(&keys, 3 + i, &key), LUM_OK);
        assert_string_equal(key.name, name);
        assert_int_equal(key.kind, LUM_KEY_DECIMAL);
        assert_null(key.words[0]);
        assert_string_equal(key.unit, eye_keys[k].unit);
        assert_string_equal(key.min, eye_keys[k].min);
        assert_string_equal(key.max, eye_keys[k].max);
        assert_string_equal(key.allowed, eye_keys[k].allowed);
        assert_string_equal(key.usual, eye_keys[k].usual[eye]);
    }
    assert_int_equal(
        lum_keys_describe(&keys, 3 + LUM_EYES * COUNT(eye_keys), &key),
        LUM_E_VALUE);
}

static void assert_described(size_t i, const char *name, lum_key_kind kind,
                             const char *unit, const char *allowed,
                             const char *usual)
{
    lum_keys keys;
    lum_key key;
    lum_keys_of_calibration(&keys, NULL);
    assert_int_equal(lum_keys_describe(&keys, i, &key), LUM_OK);
    assert_string_equal(key.name, name);
    assert_int_equal(key.kind, kind);
    assert_string_equal(key.unit, unit);
    assert_string_equal(key.allowed, allowed);
    assert_string_equal(key.usual, usual);
}

static void what_is_of_no_eye_is_described(void **state)
{
    (void)state;
    assert_described(0, "version", LUM_KEY_WHOLE, "", "1", "1");
    assert_described(1, "speed_of_light", LUM_KEY_DECIMAL, "m/s",
                     "200000000 to 310000000 m/s", "300000000");
    assert_described(2, "tof_lsb_ps", LUM_KEY_DECIMAL, "ps",
                     "above 0, at most 1000 ps", "13");
}

/* One at a time: every other field keeps its value. */
static void assert_reaches(unsigned eye, size_t k)
{
    static const char *const values[] = {"40.000123", "-41.000321"};
    static const int64_t units[] = {40000123, -41000321};
    lum_calibration usual;
    lum_calibration c;
    lum_keys keys;
    char name[LUM_KEY_BYTES];
    const size_t v = strcmp(eye_keys[k].name, "elevation.min_deg") == 0;
    const int64_t ps = strcmp(eye_keys[k].unit, "ps") == 0;
    name_key(eye, k, name);
    lum_calibration_default(&usual);
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, name, values[v], 1);
    assert_value(&keys, name, ps != 0 ? "40" : values[v]);
    assert_int_equal(lum_keys_calibration(&keys, &c, NULL), LUM_OK);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        for (size_t i = 0; i < COUNT(eye_keys); i++) {
            const int64_t expected = e != eye || i != k
                                         ? field(&usual.eye[e], i)
                                         : (ps != 0 ? 40000 : units[v]);
            assert_true(field(&c.eye[e], i) == expected);
        }
    }
    assert_int_equal(c.speed_of_light, usual.speed_of_light);
    assert_int_equal(c.tof_lsb_fs, usual.tof_lsb_fs);
}

static void each_key_of_an_eye_reaches_its_field_alone(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        for (size_t k = 0; k < COUNT(eye_keys); k++) {
            assert_reaches(eye, k);
        }
    }
}

static void what_is_of_no_eye_reaches_its_field(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration c;
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, "speed_of_light", "299792458", 1);
    set(&keys, "tof_lsb_ps", "12.999", 1);
    set(&keys, "version", "1", 1);
    assert_int_equal(lum_keys_calibration(&keys, &c, NULL), LUM_OK);
    assert_int_equal(c.speed_of_light, 299792458);
    assert_int_equal(c.tof_lsb_fs, 12999);
}

static lum_eye_calibration eye_from(int32_t first)
{
    return (lum_eye_calibration){
        .tof_offset_fs = first,
        .azimuth_center_udeg = first + 1,
        .azimuth_width_udeg = first + 2,
        .elevation_min_udeg = first + 3,
        .elevation_max_udeg = first + 4,
        .mount_um = {first + 5, first + 6, first + 7},
        .mount_roll_udeg = first + 8,
        .mount_pitch_udeg = first + 9,
        .mount_yaw_udeg = first + 10,
    };
}

static void a_start_comes_back_field_by_field(void **state)
{
    (void)state;
    const lum_calibration start = {
        .speed_of_light = 299792458,
        .tof_lsb_fs = 13001,
        .eye = {eye_from(1000), eye_from(2000)},
    };
    lum_keys keys;
    lum_calibration c;
    lum_keys_of_calibration(&keys, &start);
    assert_int_equal(lum_keys_calibration(&keys, &c, NULL), LUM_OK);
    assert_memory_equal(&c, &start, sizeof c);
    assert_value(&keys, "version", "1");
    assert_value(&keys, "tof_lsb_ps", "13.001");
    assert_value(&keys, "eyes.blue.tof_offset_ps", "1");
    assert_value(&keys, "eyes.blue.mount.x_m", "0.001005");
    assert_value(&keys, "eyes.green.mount.yaw_deg", "0.00201");
}

/* Refused, with what is said of it. */
static void assert_refused(const lum_keys *keys, const char *key,
                           uint32_t place, const char *says)
{
    lum_key_refusal why;
    lum_calibration c;
    lum_calibration untouched;
    memset(&c, 0x5a, sizeof c);
    untouched = c;
    assert_int_equal(lum_keys_calibration(keys, &c, &why), LUM_E_VALUE);
    assert_string_equal(why.text, says);
    assert_string_equal(why.key, key);
    assert_int_equal(why.place, place);
    assert_memory_equal(&c, &untouched, sizeof c);
    assert_int_equal(lum_keys_calibration(keys, &c, NULL), LUM_E_VALUE);
}

static void elevations_out_of_order_blame_the_one_that_was_set(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration start;
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, "eyes.blue.elevation.max_deg", "-17.5", 6);
    assert_refused(&keys, "eyes.blue.elevation.max_deg", 6,
                   "min_deg must be below max_deg; they are -17 (the default) "
                   "and -17.5");
    set(&keys, "eyes.blue.elevation.min_deg", "-17.5", 9);
    assert_refused(&keys, "eyes.blue.elevation.min_deg", 9,
                   "min_deg must be below max_deg; they are -17.5 and -17.5");
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, "eyes.green.elevation.min_deg", "3.25", 4);
    assert_refused(&keys, "eyes.green.elevation.min_deg", 4,
                   "min_deg must be below max_deg; they are 3.25 and 3 (the "
                   "default)");
    lum_calibration_default(&start);
    start.eye[LUM_EYE_GREEN].elevation_max_udeg = -18000000;
    lum_keys_of_calibration(&keys, &start);
    assert_refused(&keys, "eyes.green.elevation.max_deg", 0,
                   "min_deg must be below max_deg; they are -17 (as it was) "
                   "and -18 (as it was)");
}

static void a_start_that_is_out_of_range_is_of_no_key(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration start;
    lum_calibration_default(&start);
    start.eye[LUM_EYE_BLUE].mount_um[1] = INT32_MAX;
    lum_keys_of_calibration(&keys, &start);
    assert_refused(&keys, "", 0, "refused: value 10 is out of range");
}

static void keys_of_a_profile_give_no_calibration(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration c;
    lum_key_refusal why;
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_calibration(&keys, &c, &why), LUM_E_TYPE);
    assert_string_equal(why.text, "these are keys of a profile");
    assert_string_equal(why.key, "");
    assert_int_equal(why.place, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_of_a_calibration_is_described),
        cmocka_unit_test(what_is_of_no_eye_is_described),
        cmocka_unit_test(each_key_of_an_eye_reaches_its_field_alone),
        cmocka_unit_test(what_is_of_no_eye_reaches_its_field),
        cmocka_unit_test(a_start_comes_back_field_by_field),
        cmocka_unit_test(elevations_out_of_order_blame_the_one_that_was_set),
        cmocka_unit_test(a_start_that_is_out_of_range_is_of_no_key),
        cmocka_unit_test(keys_of_a_profile_give_no_calibration),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
