#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/points_fixed.h"
#include "lum/profile.h"

#include <string.h>

/* What lumtable made of the files in tables/, which
 * tests/tools/test_lumtable.py holds against them: here each target compares it
 * with what it makes itself. If one differs, raise LUM_LAYOUT_VERSION or
 * LUM_FIXED_PROJECTOR_VERSION, and make these again. */
/* NOLINTBEGIN(bugprone-suspicious-include): they need no line in a build */
#include "tables/odd.c"
#include "tables/typical.c"
/* NOLINTEND(bugprone-suspicious-include) */

/* Byte for byte, what lies between fields too. */
static void assert_tables(const lum_profile *profile,
                          const lum_calibration *calibration,
                          const lum_layout *table_layout,
                          const lum_fixed_projector *table_projector)
{
    static lum_layout layout;
    static lum_fixed_projector projector;
    memset(&layout, 0, sizeof layout);
    memset(&projector, 0, sizeof projector);
    assert_int_equal(lum_layout_init(&layout, profile, NULL, NULL), LUM_OK);
    assert_int_equal(lum_fixed_projector_init(&projector, calibration, &layout),
                     LUM_OK);
    assert_memory_equal(&layout, table_layout, sizeof layout);
    assert_memory_equal(&projector, table_projector, sizeof projector);
}

static void typical_values_are_those_of_init(void **state)
{
    static lum_profile profile;
    static lum_calibration calibration;
    (void)state;
    lum_profile_default(&profile);
    lum_calibration_default(&calibration);
    assert_tables(&profile, &calibration, &typical_layout, &typical_projector);
}

/* tables/odd.profile.yaml. Without the members' names, so that the build fails
 * for one more. None is 0, which the tables would have of one that lumtable
 * forgot. */
static const lum_profile odd_profile = {
    200,
    {[LUM_FIELD_TAG] = {60, 1, LUM_ORDER_BIG, 2, 5},
     [LUM_FIELD_EYE] = {.at = 30, .bytes = 4},
     [LUM_FIELD_LINE] = {16, 4, LUM_ORDER_BIG, 1, 30},
     [LUM_FIELD_NUM_SAMPLES] = {.at = 40, .bytes = 1},
     [LUM_FIELD_FIRST_SAMPLE_INDEX] = {.at = 44, .bytes = 4},
     [LUM_FIELD_TIMESTAMP] = {50, 8, LUM_ORDER_BIG, 3, 59}},
    63,
    LUM_SET_IP_LITTLE,
    LUM_ELEVATION_AZIMUTH,
    LUM_ORDER_BIG,
    {[LUM_EYE_BLUE] = UINT32_C(4294967295), [LUM_EYE_GREEN] = 7},
    {[LUM_TLV_COMMAND] = 65535,
     [LUM_TLV_STATUS] = 20,
     [LUM_TLV_DEBUG] = 300,
     [LUM_TLV_YSCAN] = 4000},
    1234567891,
    1000000000,
    999,
};

/* tables/odd.calibration.yaml, likewise. */
static const lum_calibration odd_calibration = {
    299792458,
    12345,
    {{INT64_C(-10000000000),
      -179500000,
      359900000,
      -89500000,
      12250000,
      {-1000000000, 1000000000, -123456},
      33300000,
      -44400000,
      355500000},
     {66700,
      10500000,
      500000,
      1500000,
      2750000,
      {500000, -250000, 999999999},
      -180000000,
      90000000,
      -12345678}},
};

static void odd_values_are_those_of_init(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        assert_true(odd_profile.group[f].bytes > 0);
    }
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        assert_true(odd_profile.tlv[i] > 0);
    }
    assert_tables(&odd_profile, &odd_calibration, &odd_layout, &odd_projector);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(typical_values_are_those_of_init),
        cmocka_unit_test(odd_values_are_those_of_init),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
