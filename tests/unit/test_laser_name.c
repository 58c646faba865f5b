#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "lum/host/laser_name.h"

/* The manual's names. A switch, so that a new bit has to be named here too. */
static const char *name_of(enum lum_laser_bit bit)
{
    switch (bit) {
    case LUM_LASER_GALVO_AMP_BX_BAD:
        return "GALVO_AMP_BX_BAD";
    case LUM_LASER_GALVO_AMP_BY_BAD:
        return "GALVO_AMP_BY_BAD";
    case LUM_LASER_GALVO_AMP_GX_BAD:
        return "GALVO_AMP_GX_BAD";
    case LUM_LASER_GALVO_AMP_GY_BAD:
        return "GALVO_AMP_GY_BAD";
    case LUM_LASER_HEARTBEAT_TIMEOUT:
        return "HEARTBEAT_TIMEOUT";
    case LUM_LASER_BOARD_OVER_105:
        return "BOARD_OVER_105";
    case LUM_LASER_FAN_PWM_BAD:
        return "FAN_PWM_BAD";
    case LUM_LASER_HW_SAFETY_BAD:
        return "HW_SAFETY_BAD";
    case LUM_LASER_SYS_ON_SW_OFF:
        return "SYS_ON_SW_OFF";
    case LUM_LASER_TLV_CMD_OFF:
        return "TLV_CMD_OFF";
    case LUM_LASER_TLV_CMD_ON:
        return "TLV_CMD_ON";
    }
    return NULL;
}

static void bits_bear_the_manuals_names(void **state)
{
    unsigned named = 0;
    (void)state;
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const char *name = name_of((enum lum_laser_bit)(1u << bit));
        if (name != NULL) {
            assert_string_equal(lum_laser_bit_name(bit), name);
            named |= 1u << bit;
        }
    }
    assert_int_equal(named, 0x0bff);
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

static void a_status_that_does_not_tell_is_neither_up_nor_down(void **state)
{
    (void)state;
    assert_string_equal(lum_laser_status_name(LUM_LASER_TLV_CMD_ON), "up");
    assert_string_equal(lum_laser_status_name(0xf800), "up");
    assert_string_equal(lum_laser_status_name(0), "may be up");
    assert_string_equal(lum_laser_status_name(0xf000), "may be up");
    assert_string_equal(lum_laser_status_name(0x0400), "down");
    assert_string_equal(lum_laser_status_name(0xffff), "down");
}

static void bits_are_named_one_after_another(void **state)
{
    char out[LUM_LASER_BITS_TEXT];
    (void)state;
    assert_string_equal(lum_laser_bits_name(0, " ", out, sizeof out), "none");
    assert_string_equal(lum_laser_bits_name(0x0200, ", ", out, sizeof out),
                        "TLV_CMD_OFF");
    assert_string_equal(lum_laser_bits_name(0x0840, ", ", out, sizeof out),
                        "FAN_PWM_BAD, TLV_CMD_ON");
    assert_string_equal(lum_laser_bits_name(0x0840, ", ", out, 14),
                        "FAN_PWM_BAD, ");
    assert_string_equal(lum_laser_bits_name(0x0840, ", ", out, 1), "");
    (void)lum_laser_bits_name(UINT16_MAX, "--", out, sizeof out);
    assert_non_null(strstr(out, "--BIT_15"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_bear_the_manuals_names),
        cmocka_unit_test(bits_without_a_name_are_not_hidden),
        cmocka_unit_test(a_status_that_does_not_tell_is_neither_up_nor_down),
        cmocka_unit_test(bits_are_named_one_after_another),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
