#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/set_keys.h"

#include <string.h>

static void add(struct set_keys *keys, const char *text)
{
    lum_error why = {""};
    if (!set_keys_add(keys, text, &why)) {
        fail_msg("%s: %s", text, why.text);
    }
}

static void keys_are_told_apart_by_their_kind(void **state)
{
    (void)state;
    struct set_keys keys = {.count = 0};
    assert_null(set_keys_first(&keys, false));
    add(&keys, "tlv.debug=9");
    assert_null(set_keys_first(&keys, false));
    assert_string_equal(set_keys_first(&keys, true), "tlv.debug=9");
    add(&keys, "tof_lsb_ps=12.5");
    add(&keys, "tof_lsb_ps=12");
    assert_string_equal(set_keys_first(&keys, false), "tof_lsb_ps=12.5");
}

static void the_last_of_a_key_holds_and_the_rest_stays(void **state)
{
    (void)state;
    struct set_keys keys = {.count = 0};
    lum_calibration c;
    lum_calibration before;
    lum_profile p;
    lum_error error = {""};
    lum_calibration_default(&c);
    lum_profile_default(&p);
    c.eye[LUM_EYE_BLUE].mount_um[0] = 7;
    before = c;
    assert_int_equal(set_keys_calibration(&keys, false, &c, &error), 0);
    assert_memory_equal(&c, &before, sizeof c);
    add(&keys, "tof_lsb_ps=12.5");
    add(&keys, "line_span_us=3");
    add(&keys, "tof_lsb_ps=12");
    assert_int_equal(set_keys_calibration(&keys, false, &c, &error), 0);
    before.tof_lsb_fs = 12000;
    assert_memory_equal(&c, &before, sizeof c);
    assert_int_equal(set_keys_profile(&keys, true, &p, &error), 0);
    assert_int_equal(p.line_span_us, 3);
    assert_int_equal(p.data_packet_type, 8);
}

static void values_that_clash_set_nothing(void **state)
{
    (void)state;
    struct set_keys keys = {.count = 0};
    lum_profile p;
    lum_error error = {""};
    add(&keys, "line_span_us=3");
    add(&keys, "tlv.command=4");
    lum_profile_default(&p);
    assert_int_equal(set_keys_profile(&keys, true, &p, &error), -1);
    assert_int_equal(p.line_span_us, 2000);
    assert_string_equal(error.text,
                        "--set tlv.command=4: 4 is the value of tlv.yscan (the "
                        "default); they must differ");
    assert_int_equal(set_keys_profile(&keys, false, &p, &error), -1);
    assert_non_null(strstr(error.text, "tlv.yscan (as it was)"));
}

static void there_is_room_for_every_key(void **state)
{
    (void)state;
    struct set_keys keys = {.count = 0};
    lum_error why = {""};
    for (unsigned i = 0; i < SET_KEYS_MAX; i++) {
        add(&keys, "tof_lsb_ps=12");
    }
    assert_false(set_keys_add(&keys, "tof_lsb_ps=12", &why));
    assert_string_equal(why.text, "more than 64 settings");
    assert_int_equal(keys.count, SET_KEYS_MAX);
}

/* Why is empty where an option's own text says what is right. */
static void what_has_no_form_is_left_to_the_option(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "=", "=1", "tof_lsb_ps"};
    struct set_keys keys = {.count = 0};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        lum_error why = {""};
        assert_false(set_keys_add(&keys, texts[i], &why));
        assert_string_equal(why.text, "");
    }
    assert_int_equal(keys.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_are_told_apart_by_their_kind),
        cmocka_unit_test(the_last_of_a_key_holds_and_the_rest_stays),
        cmocka_unit_test(values_that_clash_set_nothing),
        cmocka_unit_test(there_is_room_for_every_key),
        cmocka_unit_test(what_has_no_form_is_left_to_the_option),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
