#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/laser_name.h"

static void bits_bear_the_manuals_names(void **state)
{
    static const struct {
        unsigned bit;
        uint16_t mask;
        const char *name;
    } rows[] = {
        {0, LUM_LASER_GALVO_AMP_BX_BAD, "GALVO_AMP_BX_BAD"},
        {1, LUM_LASER_GALVO_AMP_BY_BAD, "GALVO_AMP_BY_BAD"},
        {2, LUM_LASER_GALVO_AMP_GX_BAD, "GALVO_AMP_GX_BAD"},
        {3, LUM_LASER_GALVO_AMP_GY_BAD, "GALVO_AMP_GY_BAD"},
        {4, LUM_LASER_HEARTBEAT_TIMEOUT, "HEARTBEAT_TIMEOUT"},
        {5, LUM_LASER_BOARD_OVER_105, "BOARD_OVER_105"},
        {6, LUM_LASER_FAN_PWM_BAD, "FAN_PWM_BAD"},
        {7, LUM_LASER_HW_SAFETY_BAD, "HW_SAFETY_BAD"},
        {8, LUM_LASER_SYS_ON_SW_OFF, "SYS_ON_SW_OFF"},
        {9, LUM_LASER_TLV_CMD_OFF, "TLV_CMD_OFF"},
        {11, LUM_LASER_TLV_CMD_ON, "TLV_CMD_ON"},
    };
    (void)state;
    for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(rows[i].mask, 1u << rows[i].bit);
        assert_string_equal(lum_laser_bit_name(rows[i].bit), rows[i].name);
    }
}

static void bits_without_a_name_are_not_hidden(void **state)
{
    (void)state;
    assert_string_equal(lum_laser_bit_name(10), "BIT_10");
    assert_string_equal(lum_laser_bit_name(12), "BIT_12");
    assert_string_equal(lum_laser_bit_name(13), "BIT_13");
    assert_string_equal(lum_laser_bit_name(14), "BIT_14");
    assert_string_equal(lum_laser_bit_name(15), "BIT_15");
    assert_null(lum_laser_bit_name(16));
    assert_null(lum_laser_bit_name(0xffffffffu));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_bear_the_manuals_names),
        cmocka_unit_test(bits_without_a_name_are_not_hidden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
