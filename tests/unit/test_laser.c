#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/laser.h"

static void the_laser_is_down_by_bits_0_to_10(void **state)
{
    (void)state;
    for (uint32_t status = 0; status <= 0xffffu; status++) {
        assert_int_equal(lum_laser_is_down((uint16_t)status),
                         (status & 0x07ffu) != 0);
    }
}

static void the_laser_is_on_by_bit_11_alone(void **state)
{
    (void)state;
    for (uint32_t status = 0; status <= 0xffffu; status++) {
        assert_int_equal(lum_laser_is_on((uint16_t)status),
                         (status & 0x07ffu) == 0 && (status & 0x0800u) != 0);
    }
}

static void hazards_are_bits_0_to_8(void **state)
{
    (void)state;
    for (uint32_t status = 0; status <= 0xffffu; status++) {
        assert_int_equal(lum_laser_has_hazard((uint16_t)status),
                         (status & 0x01ffu) != 0);
    }
}

static void the_masks_are_the_manuals(void **state)
{
    (void)state;
    assert_int_equal(LUM_LASER_ALL_DOWN, 0x07ff);
    assert_int_equal(LUM_LASER_ALL_SW_BAD, 0x077f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_laser_is_down_by_bits_0_to_10),
        cmocka_unit_test(the_laser_is_on_by_bit_11_alone),
        cmocka_unit_test(hazards_are_bits_0_to_8),
        cmocka_unit_test(the_masks_are_the_manuals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
