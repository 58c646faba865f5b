#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/bytes.h"
#include "core/layout.h"
#include "lum/receiver.h"
#include "support.h"

#include <string.h>

/* Which layouts are read is chosen when a program is linked: all, or the
 * built-in one alone. */
#ifdef LUM_TEST_LAYOUT_FIXED
static const bool reads_others = false;
#else
static const bool reads_others = true;
#endif

static lum_assembler assembler;
static lum_receiver receiver;
static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(1)];
static uint32_t words[LUM_ASSEMBLER_WORDS(1, 1)];
static lum_reach reach[LUM_ASSEMBLER_REACH(1)];

static lum_result begin_assembler(const lum_layout *layout)
{
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    const lum_assembler_config config = {
        .open_lines = 1, .reorder_lines = 1, .words_per_line = 1};
    return lum_assembler_init(&assembler, &config, layout, &storage);
}

static bool is_all(const void *at, uint8_t byte, size_t n)
{
    const uint8_t *b = at;
    return b[0] == byte && memcmp(b, b + 1, n - 1u) == 0;
}

/* What is refused has written nothing. */
static void assert_read(const lum_layout *layout, bool is_read)
{
    const lum_result expected = is_read ? LUM_OK : LUM_E_VALUE;
    assert_int_equal(lum_layout_is_read(layout), is_read);
    memset(&assembler, 0xa5, sizeof assembler);
    memset(slots, 0xa5, sizeof slots);
    memset(reach, 0xa5, sizeof reach);
    assert_int_equal(begin_assembler(layout), expected);
    assert_int_equal(is_all(&assembler, 0xa5, sizeof assembler), !is_read);
    assert_int_equal(is_all(slots, 0xa5, sizeof slots), !is_read);
    assert_int_equal(is_all(reach, 0xa5, sizeof reach), !is_read);
    memset(&receiver, 0xa5, sizeof receiver);
    assert_int_equal(lum_receiver_init(&receiver, layout, 0, words, 1),
                     expected);
    assert_int_equal(is_all(&receiver, 0xa5, sizeof receiver), !is_read);
}

static void the_built_in_layout_is_read(void **state)
{
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    assert_read(&layout, true);
}

static void each_value_of_a_field_counts(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        for (size_t i = 0; i < sizeof(lum_field); i++) {
            lum_layout layout;
            lum_layout_default(&layout);
            ((uint8_t *)&layout.profile.group[f])[i] ^= 1u;
            assert_read(&layout, reads_others);
        }
    }
}

static void each_value_beside_the_fields_counts(void **state)
{
    lum_layout layouts[6];
    (void)state;
    for (unsigned i = 0; i < 6; i++) {
        lum_layout_default(&layouts[i]);
    }
    layouts[0].profile.samples_at++;
    layouts[1].profile.sample_order = LUM_ORDER_BIG;
    layouts[2].profile.angle_order = LUM_ELEVATION_AZIMUTH;
    layouts[3].profile.eye_values[LUM_EYE_BLUE] = 2;
    layouts[4].profile.eye_values[LUM_EYE_GREEN] = 2;
    layouts[5].profile.clock_unit_ns = 1;
    for (unsigned i = 0; i < 6; i++) {
        assert_read(&layouts[i], reads_others);
    }
}

/* What no data packet is read by. */
static void all_else_may_be_another(void **state)
{
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    layout.profile.data_packet_type = 9;
    layout.profile.set_ip_order = LUM_SET_IP_LITTLE;
    layout.profile.angle_lsb_pdeg = 1;
    layout.profile.line_span_us = 77;
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        layout.profile.tlv[i]++;
    }
    assert_read(&layout, true);
}

/* At any address. */
static void numbers_are_loaded_in_either_order(void **state)
{
    static const uint8_t b[] = {0,    0x81, 0x92, 0xa3, 0xb4,
                                0xc5, 0xd6, 0xe7, 0xf8};
    (void)state;
    assert_int_equal(load_u16(b + 1), 0x9281u);
    assert_int_equal(load_u32(b + 1), 0xb4a39281u);
    assert_true(load_u64(b + 1) == UINT64_C(0xf8e7d6c5b4a39281));
    assert_int_equal(load_big_u16(b + 1), 0x8192u);
    assert_int_equal(load_big_u32(b + 1), 0x8192a3b4u);
    assert_true(load_big_u64(b + 1) == UINT64_C(0x8192a3b4c5d6e7f8));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_built_in_layout_is_read),
        cmocka_unit_test(each_value_of_a_field_counts),
        cmocka_unit_test(each_value_beside_the_fields_counts),
        cmocka_unit_test(all_else_may_be_another),
        cmocka_unit_test(numbers_are_loaded_in_either_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
