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

static void set(lum_keys *keys, const char *key, const char *value)
{
    lum_key_refusal why;
    if (lum_keys_set(keys, key, value, 1, &why) != LUM_OK) {
        fail_msg("%s=%s: %s", key, value, why.text);
    }
}

static void assert_refused(const lum_keys *keys, const char *key,
                           const char *value, lum_result result,
                           const char *blamed, const char *says)
{
    lum_keys copy = *keys;
    lum_key_refusal why;
    memset(&why, 0, sizeof why);
    assert_int_equal(lum_keys_set(&copy, key, value, 7, &why), result);
    assert_memory_equal(&copy, keys, sizeof copy);
    assert_string_equal(why.key, blamed);
    assert_string_equal(why.text, says);
    assert_int_equal(why.place, 7);
    assert_int_equal(lum_keys_set(&copy, key, value, 7, NULL), result);
}

static void a_value_reaches_its_field(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration c;
    lum_profile p;
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, "eyes.green.mount.z_m", "-0.25");
    set(&keys, "tof_lsb_ps", "12.5");
    assert_int_equal(lum_keys_calibration(&keys, &c, NULL), LUM_OK);
    assert_int_equal(c.eye[LUM_EYE_GREEN].mount_um[2], -250000);
    assert_int_equal(c.tof_lsb_fs, 12500);
    lum_keys_of_profile(&keys, NULL);
    set(&keys, "group.samples", "28");
    set(&keys, "group.line.at", "24");
    set(&keys, "group.eye", "14");
    set(&keys, "angle_order", "elevation_azimuth");
    assert_int_equal(lum_keys_profile(&keys, &p, NULL), LUM_OK);
    assert_int_equal(p.samples_at, 28);
    assert_int_equal(p.group[LUM_FIELD_LINE].at, 24);
    assert_int_equal(p.group[LUM_FIELD_LINE].bytes, 2);
    assert_int_equal(p.group[LUM_FIELD_EYE].at, 14);
    assert_int_equal(p.angle_order, LUM_ELEVATION_AZIMUTH);
}

static void what_is_not_set_stays_as_it_began(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration start;
    lum_calibration c;
    lum_profile profile;
    lum_profile p;
    lum_calibration_default(&start);
    start.eye[LUM_EYE_BLUE].tof_offset_fs = -1557460;
    start.eye[LUM_EYE_GREEN].mount_yaw_udeg = 31000001;
    lum_keys_of_calibration(&keys, &start);
    assert_int_equal(lum_keys_calibration(&keys, &c, NULL), LUM_OK);
    assert_memory_equal(&c, &start, sizeof c);
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 0, .bytes = 0};
    profile.angle_lsb_pdeg = 1;
    lum_keys_of_profile(&keys, &profile);
    assert_int_equal(lum_keys_profile(&keys, &p, NULL), LUM_OK);
    assert_memory_equal(p.group, profile.group, sizeof p.group);
    assert_true(p.angle_lsb_pdeg == 1);
}

/* A field that is nowhere has no width to keep. */
static void an_offset_brings_back_a_field_that_was_none(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile profile;
    lum_profile p;
    char text[LUM_KEY_VALUE_BYTES];
    lum_profile_default(&profile);
    const lum_field usual = profile.group[LUM_FIELD_TIMESTAMP];
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 0, .bytes = 0};
    lum_keys_of_profile(&keys, &profile);
    assert_int_equal(lum_keys_get(&keys, "group.timestamp.bytes", text),
                     LUM_OK);
    set(&keys, "group.timestamp.bytes", text);
    set(&keys, "group.timestamp.at", "20");
    assert_int_equal(lum_keys_profile(&keys, &p, NULL), LUM_OK);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].at, 20);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].bytes, usual.bytes);
}

/* Sets each key to its limits, and just beyond. */
static void check_limits(const lum_keys *keys)
{
    lum_key key;
    size_t i = 0;
    for (; lum_keys_describe(keys, i, &key) == LUM_OK; i++) {
        lum_keys copy = *keys;
        char text[LUM_KEY_VALUE_BYTES];
        assert_true(strlen(key.name) < LUM_KEY_BYTES);
        assert_true(strlen(key.allowed) + 1 < sizeof key.allowed);
        assert_int_equal(lum_keys_get(keys, key.name, text), LUM_OK);
        assert_string_equal(text, key.usual);
        set(&copy, key.name, key.usual);
        assert_int_equal(key.min[0] == '\0', key.kind == LUM_KEY_WORD);
        assert_int_equal(key.words[0] != NULL, key.kind >= LUM_KEY_WORD);
        for (size_t w = 0; key.words[w] != NULL; w++) {
            set(&copy, key.name, key.words[w]);
            assert_int_equal(lum_keys_get(&copy, key.name, text), LUM_OK);
            assert_string_equal(text, key.words[w]);
        }
        if (key.min[0] != '\0') {
            set(&copy, key.name, key.min);
            set(&copy, key.name, key.max);
            assert_int_equal(lum_keys_get(&copy, key.name, text), LUM_OK);
            assert_string_equal(text, key.max);
        }
        assert_int_equal(lum_keys_set(&copy, key.name, "-99999999999", 1, NULL),
                         LUM_E_VALUE);
        assert_int_equal(lum_keys_set(&copy, key.name, "99999999999", 1, NULL),
                         LUM_E_VALUE);
    }
    assert_true(i > 20);
}

static void every_key_takes_its_limits_and_no_more(void **state)
{
    (void)state;
    lum_keys keys;
    lum_keys_of_calibration(&keys, NULL);
    check_limits(&keys);
    lum_keys_of_profile(&keys, NULL);
    check_limits(&keys);
}

static void a_key_is_described(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key key;
    bool found = false;
    lum_keys_of_calibration(&keys, NULL);
    for (size_t i = 0; lum_keys_describe(&keys, i, &key) == LUM_OK; i++) {
        if (strcmp(key.name, "eyes.blue.mount.yaw_deg") == 0) {
            found = true;
            assert_int_equal(key.kind, LUM_KEY_DECIMAL);
            assert_string_equal(key.unit, "deg");
            assert_string_equal(key.min, "-360");
            assert_string_equal(key.max, "360");
            assert_string_equal(key.allowed, "-360 to 360 deg");
            assert_string_equal(key.usual, "-30");
        }
    }
    assert_true(found);
}

static void what_is_wrong_is_said(void **state)
{
    (void)state;
    static const struct {
        const char *key;
        const char *value;
        lum_result result;
        const char *blamed;
        const char *says;
    } rows[] = {
        {"group.lin.at", "14", LUM_E_TYPE, "group",
         "unknown key 'lin'; did you mean 'line'? allowed here: tag, eye, "
         "line, num_samples, first_sample_index, timestamp, samples"},
        {"group.line.to", "14", LUM_E_TYPE, "group.line",
         "unknown key 'to'; allowed here: at, bytes, order, bits"},
        {"group.line.", "14", LUM_E_TYPE, "group.line",
         "unknown key ''; allowed here: at, bytes, order, bits"},
        {"eye_values", "1", LUM_E_TYPE, "eye_values",
         "a single value does not belong here; allowed: a mapping of blue, "
         "green"},
        {"line_span_us.x", "1", LUM_E_TYPE, "line_span_us",
         "a mapping does not belong here; allowed: 0 to 1000000000 us"},
        {"group.line.at", "7", LUM_E_VALUE, "group.line.at",
         "'7' is out of range; allowed: an offset from 8 to 64"},
        {"group.line.at", "014", LUM_E_VALUE, "group.line.at",
         "'014' begins with 0, which some read as octal; leave the 0 out; "
         "allowed: an offset from 8 to 64"},
        {"group.timestamp", "never", LUM_E_VALUE, "group.timestamp",
         "'never' is not a decimal number; allowed: none, or an offset from 8 "
         "to 64, or a mapping of at, bytes, order, "
         "bits, unit_ns"},
        {"set_ip_order", "big", LUM_E_VALUE, "set_ip_order",
         "'big' is not known; allowed: network or little"},
        {"tlv.yscan", "4\n\xff", LUM_E_VALUE, "tlv.yscan",
         "'4\\x0a\\xff' is not a decimal number; allowed: 0 to 65535"},
        {"angle_lsb_deg", "", LUM_E_VALUE, "angle_lsb_deg",
         "'' is not a decimal number; allowed: span, or above 0, at most 1 "
         "deg"},
    };
    lum_keys keys;
    lum_keys_of_profile(&keys, NULL);
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_refused(&keys, rows[i].key, rows[i].value, rows[i].result,
                       rows[i].blamed, rows[i].says);
    }
}

static void a_long_key_or_value_is_cut_and_refused(void **state)
{
    (void)state;
    char long_text[4096];
    lum_keys keys;
    lum_key_refusal why;
    memset(long_text, 'x', sizeof long_text);
    long_text[sizeof long_text - 1] = '\0';
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_set(&keys, long_text, "1", 1, &why), LUM_E_TYPE);
    assert_non_null(strstr(why.text, "...'; allowed here: version, "));
    assert_non_null(strstr(why.text, ", line_span_us"));
    assert_int_equal(lum_keys_set(&keys, "tlv.debug", long_text, 1, &why),
                     LUM_E_VALUE);
    assert_non_null(strstr(why.text, "...' is not a decimal number"));
    assert_int_equal(lum_keys_get(&keys, long_text, long_text), LUM_E_TYPE);
}

static void a_value_comes_from_a_place(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key_refusal why;
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_set(&keys, "tlv.debug", "9", 0, &why),
                     LUM_E_VALUE);
    assert_string_equal(why.key, "tlv.debug");
    assert_string_equal(why.text,
                        "a value that is set comes from a place above 0");
    assert_int_equal(lum_keys_set(&keys, "tlv.debug", "9", 0, NULL),
                     LUM_E_VALUE);
}

static void of_values_that_clash_the_one_that_was_set_is_blamed(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile p;
    lum_calibration c;
    lum_key_refusal why;
    lum_profile_default(&p);
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_set(&keys, "group.tag.at", "14", 3, NULL),
                     LUM_OK);
    assert_int_equal(lum_keys_profile(&keys, &p, &why), LUM_E_VALUE);
    assert_string_equal(why.key, "group.tag");
    assert_int_equal(why.place, 3);
    assert_string_equal(why.text,
                        "bytes 14 to 14 overlap group.line, 14 to 15 (the "
                        "default); fields must not share bytes, unless "
                        "both name bits");
    assert_int_equal(p.group[LUM_FIELD_TAG].at, 12);
    lum_keys_of_profile(&keys, &p);
    set(&keys, "tlv.command", "4");
    assert_int_equal(lum_keys_profile(&keys, &p, &why), LUM_E_VALUE);
    assert_string_equal(why.key, "tlv.command");
    assert_string_equal(why.text,
                        "4 is the value of tlv.yscan (as it was); they must "
                        "differ");
    lum_keys_of_calibration(&keys, NULL);
    set(&keys, "eyes.green.elevation.max_deg", "-17");
    assert_int_equal(lum_keys_calibration(&keys, &c, &why), LUM_E_VALUE);
    assert_string_equal(why.key, "eyes.green.elevation.max_deg");
    assert_string_equal(why.text, "min_deg must be below max_deg; they are "
                                  "-17 (the default) and -17");
}

static void keys_of_one_kind_give_no_other(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile p;
    lum_calibration c;
    lum_key_refusal why;
    lum_keys_of_calibration(&keys, NULL);
    assert_int_equal(lum_keys_profile(&keys, &p, &why), LUM_E_TYPE);
    assert_string_equal(why.text, "these are keys of a calibration");
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_calibration(&keys, &c, &why), LUM_E_TYPE);
    assert_string_equal(why.text, "these are keys of a profile");
}

static void a_start_that_is_out_of_range_is_refused(void **state)
{
    (void)state;
    lum_keys keys;
    lum_calibration c;
    lum_profile p;
    lum_key_refusal why;
    lum_calibration_default(&c);
    c.tof_lsb_fs = 0;
    lum_keys_of_calibration(&keys, &c);
    assert_int_equal(lum_keys_calibration(&keys, &c, &why), LUM_E_VALUE);
    assert_string_equal(why.text, "refused: value 2 is out of range");
    lum_profile_default(&p);
    p.line_span_us = UINT32_MAX;
    lum_keys_of_profile(&keys, &p);
    assert_int_equal(lum_keys_profile(&keys, &p, &why), LUM_E_VALUE);
    assert_string_equal(why.text, "refused: fault 13 of the profile");
}

static void values_are_written_as_yaml(void **state)
{
    (void)state;
    static const char begin[] = "version: 1\n"
                                "data_packet_type: 8\n"
                                "set_ip_order: network\n"
                                "group:\n"
                                "  tag:\n"
                                "    at: 12\n"
                                "    bytes: 1\n"
                                "  eye:\n";
    static const char end[] = "    bytes: 2\n"
                              "  timestamp: none\n"
                              "  samples: 24\n"
                              "eye_values:\n"
                              "  blue: 0\n"
                              "  green: 1\n"
                              "angle_order: azimuth_elevation\n"
                              "angle_lsb_deg: 0.0005\n"
                              "tlv:\n"
                              "  command: 1\n"
                              "  status: 2\n"
                              "  debug: 3\n"
                              "  yscan: 4\n"
                              "line_span_us: 2000\n";
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    lum_keys_of_profile(&keys, NULL);
    set(&keys, "group.timestamp", "none");
    set(&keys, "angle_lsb_deg", "5e-4");
    const size_t len = lum_keys_write(&keys, text, sizeof text);
    assert_int_equal(len, strlen(text));
    assert_memory_equal(text, begin, sizeof begin - 1);
    assert_string_equal(text + len - (sizeof end - 1), end);
}

static void a_rare_value_is_written_where_it_is_not_the_usual_one(void **state)
{
    (void)state;
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    lum_keys_of_profile(&keys, NULL);
    set(&keys, "group.line.order", "big");
    set(&keys, "group.timestamp.unit_ns", "999");
    (void)lum_keys_write(&keys, text, sizeof text);
    assert_non_null(strstr(text, "  line:\n"
                                 "    at: 14\n"
                                 "    bytes: 2\n"
                                 "    order: big\n"
                                 "  num_samples:\n"));
    assert_non_null(strstr(text, "    unit_ns: 999\n"));
    assert_null(strstr(text, "sample_order"));
    assert_null(strstr(text, "bits"));
    set(&keys, "group.timestamp.unit_ns", "1000");
    (void)lum_keys_write(&keys, text, sizeof text);
    assert_non_null(strstr(text, "  timestamp:\n"
                                 "    at: 20\n"
                                 "    bytes: 4\n"
                                 "  samples: 24\n"));
}

static void what_does_not_fit_is_cut_and_its_length_told(void **state)
{
    (void)state;
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    lum_keys_of_calibration(&keys, NULL);
    const size_t len = lum_keys_write(&keys, NULL, 0);
    assert_int_equal(lum_keys_write(&keys, text, sizeof text), len);
    assert_true(len < sizeof text);
    for (size_t size = 1; size < 40; size++) {
        char small[40];
        memset(small, 'x', sizeof small);
        assert_int_equal(lum_keys_write(&keys, small, size), len);
        assert_int_equal(strlen(small), size - 1);
        assert_memory_equal(small, text, size - 1);
        assert_true(size == sizeof small - 1 || small[size] == 'x');
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_value_reaches_its_field),
        cmocka_unit_test(what_is_not_set_stays_as_it_began),
        cmocka_unit_test(an_offset_brings_back_a_field_that_was_none),
        cmocka_unit_test(every_key_takes_its_limits_and_no_more),
        cmocka_unit_test(a_key_is_described),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(a_long_key_or_value_is_cut_and_refused),
        cmocka_unit_test(a_value_comes_from_a_place),
        cmocka_unit_test(of_values_that_clash_the_one_that_was_set_is_blamed),
        cmocka_unit_test(keys_of_one_kind_give_no_other),
        cmocka_unit_test(a_start_that_is_out_of_range_is_refused),
        cmocka_unit_test(values_are_written_as_yaml),
        cmocka_unit_test(a_rare_value_is_written_where_it_is_not_the_usual_one),
        cmocka_unit_test(what_does_not_fit_is_cut_and_its_length_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
