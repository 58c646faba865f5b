#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/profile_difference.h"

static void assert_differences(const lum_profile *one, const lum_profile *other,
                               const char *const (*expected)[3], size_t n)
{
    struct profile_difference all[LUM_KEYS_MAX];
    assert_int_equal(profile_differences(one, other, all), n);
    for (size_t i = 0; i < n; i++) {
        assert_string_equal(all[i].key, expected[i][0]);
        assert_string_equal(all[i].one, expected[i][1]);
        assert_string_equal(all[i].other, expected[i][2]);
    }
}

static void what_is_equal_has_no_difference(void **state)
{
    (void)state;
    lum_profile p;
    lum_profile_default(&p);
    assert_differences(&p, &p, NULL, 0);
}

static void an_offset_is_named_once(void **state)
{
    static const char *const expected[][3] = {
        {"group.line", "14", "30"},
        {"group.line.bytes", "2", "4"},
        {"eye_values.green", "1", "7"},
    };
    (void)state;
    lum_profile one;
    lum_profile_default(&one);
    lum_profile other = one;
    other.group[LUM_FIELD_LINE] = (lum_field){.at = 30, .bytes = 4};
    other.eye_values[LUM_EYE_GREEN] = 7;
    assert_differences(&one, &other, expected, 3);
}

/* No width, order or tick of what is not there. */
static void what_is_none_has_nothing_else(void **state)
{
    static const char *const expected[][3] = {
        {"group.timestamp", "20", "none"}};
    static const char *const back[][3] = {
        {"group.timestamp", "none", "20"},
        {"group.timestamp.bytes", "4", "8"},
        {"group.timestamp.order", "little", "big"},
        {"group.timestamp.unit_ns", "1000", "10"}};
    (void)state;
    lum_profile one;
    lum_profile_default(&one);
    one.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){.at = 20, .bytes = 8, .order = LUM_ORDER_BIG};
    one.clock_unit_ns = 10;
    lum_profile other = one;
    other.group[LUM_FIELD_TIMESTAMP] = (lum_field){.bytes = 0};
    assert_differences(&one, &other, expected, 1);
    assert_differences(&other, &one, back, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_equal_has_no_difference),
        cmocka_unit_test(an_offset_is_named_once),
        cmocka_unit_test(what_is_none_has_nothing_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
