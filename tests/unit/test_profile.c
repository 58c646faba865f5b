#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/profile.h"

#include <string.h>

/* The answer for a profile: its fault and what it stands at. */
static void assert_fault(const lum_profile *p, lum_profile_fault fault,
                         unsigned index)
{
    lum_profile_fault found = LUM_PROFILE_FINE;
    unsigned where = 77;
    lum_layout layout;
    memset(&layout, 0x5a, sizeof layout);
    const lum_layout before = layout;
    const lum_result r = lum_layout_init(&layout, p, &found, &where);
    assert_int_equal(found, fault);
    assert_int_equal(where, index);
    assert_int_equal(r, fault == LUM_PROFILE_FINE ? LUM_OK : LUM_E_VALUE);
    if (r == LUM_OK) {
        assert_memory_equal(&layout.profile.group, &p->group, sizeof p->group);
    } else {
        assert_memory_equal(&layout, &before, sizeof layout);
    }
    assert_int_equal(lum_layout_init(&layout, p, NULL, NULL), r);
}

static lum_profile defaults(void)
{
    lum_profile p;
    lum_profile_default(&p);
    return p;
}

static void the_default_is_the_documents(void **state)
{
    static const lum_field group[] = {
        {.at = 12, .bytes = 1}, {.at = 13, .bytes = 1}, {.at = 14, .bytes = 2},
        {.at = 16, .bytes = 2}, {.at = 18, .bytes = 2}, {.at = 20, .bytes = 4}};
    static const uint16_t tlv[] = {1, 2, 3, 4};
    const lum_profile p = defaults();
    (void)state;
    assert_int_equal(p.data_packet_type, 8);
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        assert_int_equal(p.group[f].at, group[f].at);
        assert_int_equal(p.group[f].bytes, group[f].bytes);
    }
    assert_int_equal(p.samples_at, 24);
    assert_int_equal(p.set_ip_order, LUM_SET_IP_NETWORK);
    assert_int_equal(p.angle_order, LUM_AZIMUTH_ELEVATION);
    assert_true(p.eye_values[LUM_EYE_BLUE] == 0);
    assert_true(p.eye_values[LUM_EYE_GREEN] == 1);
    assert_memory_equal(p.tlv, tlv, sizeof tlv);
    assert_true(p.angle_lsb_pdeg == 0);
    assert_int_equal(p.line_span_us, 2000);
    assert_fault(&p, LUM_PROFILE_FINE, 0);
}

static void the_default_layout_holds_the_default_profile(void **state)
{
    const lum_profile p = defaults();
    lum_layout made;
    lum_layout standard;
    (void)state;
    assert_int_equal(lum_layout_init(&made, &p, NULL, NULL), LUM_OK);
    lum_layout_default(&standard);
    assert_int_equal(made.profile.samples_at, standard.profile.samples_at);
    assert_memory_equal(made.profile.group, standard.profile.group,
                        sizeof made.profile.group);
}

static void the_data_packet_type_is_no_other_packets(void **state)
{
    (void)state;
    for (uint32_t type = 0; type <= 300; type++) {
        lum_profile p = defaults();
        p.data_packet_type = type;
        const int is_fine = type < 256 && (type < 5 || type > 7);
        assert_fault(
            &p, is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_DATA_PACKET_TYPE, 0);
    }
}

static void an_offset_is_8_to_64(void **state)
{
    (void)state;
    for (unsigned at = 0; at < 256; at++) {
        lum_profile p = defaults();
        p.samples_at = 64;
        p.group[LUM_FIELD_TAG].at = (uint8_t)at;
        if (at < 8 || at > 64) {
            assert_fault(&p, LUM_PROFILE_FIELD_OFFSET, LUM_FIELD_TAG);
        } else if (at == 64) {
            assert_fault(&p, LUM_PROFILE_SAMPLES_IN_HEADER, LUM_FIELD_TAG);
        } else if (at > 8 && at < 12) {
            assert_fault(&p, LUM_PROFILE_FIELD_ON_TYPE, LUM_FIELD_TAG);
        } else if (at == 8 || at == 12 || at >= 24) {
            assert_fault(&p, LUM_PROFILE_FINE, 0);
        } else {
            lum_layout layout;
            lum_profile_fault fault = LUM_PROFILE_FINE;
            assert_int_equal(lum_layout_init(&layout, &p, &fault, NULL),
                             LUM_E_VALUE);
            assert_int_equal(fault, LUM_PROFILE_FIELDS_OVERLAP);
        }
    }
}

static void only_the_tag_may_stand_on_the_type(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        for (uint8_t at = 8; at < 12; at++) {
            lum_profile p = defaults();
            p.group[f] = (lum_field){.at = at, .bytes = 1};
            const int is_fine = f == LUM_FIELD_TAG && at == 8;
            assert_fault(&p,
                         is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELD_ON_TYPE,
                         is_fine ? 0 : f);
        }
    }
}

static void a_width_is_1_2_4_or_8(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        for (unsigned bytes = 0; bytes < 256; bytes++) {
            lum_profile p = defaults();
            p.samples_at = 64;
            p.group[f] = (lum_field){.at = 40, .bytes = (uint8_t)bytes};
            const int is_fine =
                bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8 ||
                (bytes == 0 &&
                 (f == LUM_FIELD_TIMESTAMP || f == LUM_FIELD_NUM_SAMPLES));
            assert_fault(&p,
                         is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELD_WIDTH,
                         is_fine ? 0 : f);
        }
    }
}

static void no_two_fields_share_a_byte(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        for (unsigned g = f + 1; g < LUM_GROUP_FIELDS; g++) {
            for (int apart = -6; apart <= 6; apart++) {
                lum_profile p = defaults();
                p.samples_at = 64;
                p.group[f] = (lum_field){.at = 40, .bytes = 4};
                p.group[g] =
                    (lum_field){.at = (uint8_t)(40 + apart), .bytes = 4};
                const int is_fine = apart <= -4 || apart >= 4;
                assert_fault(
                    &p, is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELDS_OVERLAP,
                    is_fine ? 0 : g);
            }
        }
    }
}

static void samples_follow_every_field(void **state)
{
    (void)state;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        for (uint8_t samples = 40; samples < 64; samples++) {
            lum_profile p = defaults();
            p.samples_at = samples;
            p.group[f] = (lum_field){.at = 50, .bytes = 2};
            const int is_fine = samples >= 52;
            assert_fault(
                &p, is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_SAMPLES_IN_HEADER,
                is_fine ? 0 : f);
        }
    }
}

static void samples_stand_at_8_to_64(void **state)
{
    lum_profile p = defaults();
    (void)state;
    p.samples_at = 7;
    assert_fault(&p, LUM_PROFILE_FIELD_OFFSET, LUM_GROUP_FIELDS);
    p.samples_at = 65;
    assert_fault(&p, LUM_PROFILE_FIELD_OFFSET, LUM_GROUP_FIELDS);
    p.samples_at = 64;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.samples_at = 8;
    assert_fault(&p, LUM_PROFILE_SAMPLES_IN_HEADER, LUM_FIELD_TAG);
}

/* "timestamp: none": whatever offset its field is left with. */
static void a_timestamp_that_is_none_stands_in_nobodys_way(void **state)
{
    static const uint8_t offsets[] = {0, 8, 12, 20, 23, 24, 64, 255};
    (void)state;
    for (unsigned i = 0; i < sizeof offsets; i++) {
        lum_profile p = defaults();
        p.group[LUM_FIELD_TIMESTAMP] =
            (lum_field){.at = offsets[i], .bytes = 0};
        p.samples_at = 20;
        assert_fault(&p, LUM_PROFILE_FINE, 0);
    }
}

/* Also in the middle of another field. */
static void a_number_of_samples_that_is_none_stands_in_nobodys_way(void **state)
{
    (void)state;
    for (uint8_t at = 0; at < 70; at++) {
        lum_profile p = defaults();
        p.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.at = at, .bytes = 0};
        assert_fault(&p, LUM_PROFILE_FINE, 0);
    }
}

/* Every pair of ranges of bits in the same byte. */
static void no_two_fields_share_a_bit(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 8u * 8u * 8u * 8u; i++) {
        const unsigned low = i % 8u;
        const unsigned bits = 1u + i / 8u % 8u;
        const unsigned other = i / 64u % 8u;
        const unsigned others = 1u + i / 512u;
        if (low + bits > 8 || other + others > 8) {
            continue;
        }
        lum_profile p = defaults();
        p.group[LUM_FIELD_TAG] = (lum_field){
            .at = 12, .bytes = 1, .low = (uint8_t)low, .bits = (uint8_t)bits};
        p.group[LUM_FIELD_LINE] = (lum_field){.at = 12,
                                              .bytes = 1,
                                              .low = (uint8_t)other,
                                              .bits = (uint8_t)others};
        const int is_fine = low + bits <= other || other + others <= low;
        assert_fault(&p,
                     is_fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELDS_OVERLAP,
                     is_fine ? 0 : LUM_FIELD_LINE);
    }
}

static void eye_values_fit_their_bits(void **state)
{
    (void)state;
    for (unsigned bits = 1; bits <= 32; bits++) {
        lum_profile p = defaults();
        p.samples_at = 64;
        p.group[LUM_FIELD_EYE] =
            (lum_field){.at = 40, .bytes = 8, .bits = (uint8_t)bits};
        p.eye_values[LUM_EYE_GREEN] = 0xffffffffu >> (32u - bits);
        assert_fault(&p, LUM_PROFILE_FINE, 0);
        if (bits < 32) {
            p.eye_values[LUM_EYE_GREEN] = UINT32_C(1) << bits;
            assert_fault(&p, LUM_PROFILE_EYE_VALUE_WIDTH, LUM_EYE_GREEN);
        }
    }
}

static void orders_are_one_of_two(void **state)
{
    lum_profile p = defaults();
    (void)state;
    p.set_ip_order = LUM_SET_IP_LITTLE;
    p.angle_order = LUM_ELEVATION_AZIMUTH;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.set_ip_order = 2;
    assert_fault(&p, LUM_PROFILE_SET_IP_ORDER, 0);
    p = defaults();
    p.angle_order = 2;
    assert_fault(&p, LUM_PROFILE_ANGLE_ORDER, 0);
}

static void eye_values_fit_their_field(void **state)
{
    static const struct {
        uint8_t bytes;
        uint32_t value;
        lum_profile_fault fault;
    } rows[] = {
        {1, 255, LUM_PROFILE_FINE},
        {1, 256, LUM_PROFILE_EYE_VALUE_WIDTH},
        {2, 65535, LUM_PROFILE_FINE},
        {2, 65536, LUM_PROFILE_EYE_VALUE_WIDTH},
        {4, 0xffffffffu, LUM_PROFILE_FINE},
    };
    (void)state;
    for (unsigned i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const unsigned row = i / 2;
        const unsigned eye = i % 2;
        lum_profile p = defaults();
        p.samples_at = 64;
        p.group[LUM_FIELD_EYE] =
            (lum_field){.at = 40, .bytes = rows[row].bytes};
        p.eye_values[eye] = rows[row].value;
        const int is_fine = rows[row].fault == LUM_PROFILE_FINE;
        assert_fault(&p, rows[row].fault, is_fine ? 0 : eye);
    }
}

static void eyes_have_two_values(void **state)
{
    lum_profile p = defaults();
    (void)state;
    p.eye_values[LUM_EYE_BLUE] = 1;
    assert_fault(&p, LUM_PROFILE_EYE_VALUES_EQUAL, LUM_EYE_GREEN);
    p.eye_values[LUM_EYE_GREEN] = 0;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
}

static void tlv_numbers_differ(void **state)
{
    (void)state;
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        for (unsigned j = 0; j < i; j++) {
            lum_profile p = defaults();
            p.tlv[j] = 0xffff;
            assert_fault(&p, LUM_PROFILE_FINE, 0);
            p.tlv[i] = 0xffff;
            assert_fault(&p, LUM_PROFILE_TLV_EQUAL, i);
        }
    }
}

static void an_angle_lsb_is_at_most_a_degree(void **state)
{
    lum_profile p = defaults();
    (void)state;
    p.angle_lsb_pdeg = LUM_ANGLE_LSB_MAX_PDEG;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.angle_lsb_pdeg = LUM_ANGLE_LSB_MAX_PDEG + 1;
    assert_fault(&p, LUM_PROFILE_ANGLE_LSB, 0);
    p.angle_lsb_pdeg = UINT64_MAX;
    assert_fault(&p, LUM_PROFILE_ANGLE_LSB, 0);
}

static void a_line_lasts_at_most_a_thousand_seconds(void **state)
{
    lum_profile p = defaults();
    (void)state;
    p.line_span_us = LUM_LINE_SPAN_MAX_US;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.line_span_us = LUM_LINE_SPAN_MAX_US + 1;
    assert_fault(&p, LUM_PROFILE_LINE_SPAN, 0);
    p.line_span_us = UINT32_MAX;
    assert_fault(&p, LUM_PROFILE_LINE_SPAN, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_is_the_documents),
        cmocka_unit_test(the_default_layout_holds_the_default_profile),
        cmocka_unit_test(the_data_packet_type_is_no_other_packets),
        cmocka_unit_test(an_offset_is_8_to_64),
        cmocka_unit_test(only_the_tag_may_stand_on_the_type),
        cmocka_unit_test(a_width_is_1_2_4_or_8),
        cmocka_unit_test(no_two_fields_share_a_byte),
        cmocka_unit_test(samples_follow_every_field),
        cmocka_unit_test(samples_stand_at_8_to_64),
        cmocka_unit_test(a_timestamp_that_is_none_stands_in_nobodys_way),
        cmocka_unit_test(
            a_number_of_samples_that_is_none_stands_in_nobodys_way),
        cmocka_unit_test(no_two_fields_share_a_bit),
        cmocka_unit_test(eye_values_fit_their_bits),
        cmocka_unit_test(orders_are_one_of_two),
        cmocka_unit_test(eye_values_fit_their_field),
        cmocka_unit_test(eyes_have_two_values),
        cmocka_unit_test(tlv_numbers_differ),
        cmocka_unit_test(an_angle_lsb_is_at_most_a_degree),
        cmocka_unit_test(a_line_lasts_at_most_a_thousand_seconds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
