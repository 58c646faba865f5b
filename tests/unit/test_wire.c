#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC 0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12

static const uint8_t heartbeat[] = {MAGIC, 8, 0, 0, 0};
static const uint8_t set_ip[] = {MAGIC, 5, 0, 0, 0, 10, 42, 0, 99};
static const uint8_t timestamp[] = {MAGIC, 6,    0,    0,    0,    0x07, 0,
                                    0,     0x80, 0x78, 0x56, 0x34, 0x92};
/* a status poll's answer: status 0x0801, then the text "ok" */
static const uint8_t tlvs[] = {MAGIC, 7, 0, 0,    0,    9, 0, 0, 0,   2,  0,
                               2,     0, 1, 0x08, 0x03, 0, 2, 0, 'o', 'k'};

static void the_magic_is_the_manuals(void **state)
{
    const uint64_t magic = UINT64_C(0x1234beefa1f3feed);
    uint8_t out[LUM_HEADER_BYTES];
    (void)state;
    lum_header_encode(out, 0xab);
    for (unsigned i = 0; i < 8; i++) {
        assert_int_equal(out[i], (magic >> (8u * i)) & 0xffu);
    }
    assert_int_equal(out[8], 0xab);
    assert_true(out[9] == 0 && out[10] == 0 && out[11] == 0);
}

static void a_header_tells_any_type(void **state)
{
    uint8_t bytes[LUM_HEADER_BYTES];
    (void)state;
    for (unsigned type = 0; type < 256; type++) {
        uint8_t found = (uint8_t)~type;
        lum_header_encode(bytes, (uint8_t)type);
        assert_int_equal(lum_header_decode(bytes, sizeof bytes, &found),
                         LUM_OK);
        assert_int_equal(found, type);
    }
}

static void every_bit_of_the_magic_counts(void **state)
{
    uint8_t bytes[sizeof heartbeat];
    uint8_t type = 77;
    (void)state;
    for (unsigned bit = 0; bit < 64; bit++) {
        memcpy(bytes, heartbeat, sizeof bytes);
        bytes[bit / 8] ^= (uint8_t)(1u << (bit % 8));
        assert_int_equal(lum_header_decode(bytes, sizeof bytes, &type),
                         LUM_E_FOREIGN);
    }
    assert_int_equal(type, 77);
}

static void a_reserved_byte_that_is_set_is_another_type(void **state)
{
    uint8_t bytes[sizeof heartbeat];
    uint8_t type = 77;
    (void)state;
    for (unsigned at = 9; at < 12; at++) {
        for (unsigned bit = 0; bit < 8; bit++) {
            memcpy(bytes, heartbeat, sizeof bytes);
            bytes[at] = (uint8_t)(1u << bit);
            assert_int_equal(lum_header_decode(bytes, sizeof bytes, &type),
                             LUM_E_TYPE);
        }
    }
    assert_int_equal(type, 77);
}

static void every_truncation_of_a_header_is_foreign(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof heartbeat; n++) {
        uint8_t *exact = exact_copy(heartbeat, n);
        uint8_t type = 77;
        assert_int_equal(lum_header_decode(exact, n, &type), LUM_E_FOREIGN);
        assert_int_equal(type, 77);
        free(exact);
    }
}

static void a_heartbeat_is_a_bare_header(void **state)
{
    uint8_t out[LUM_HEARTBEAT_BYTES];
    (void)state;
    lum_heartbeat_encode(out);
    assert_memory_equal(out, heartbeat, sizeof heartbeat);
}

static void set_ip_bears_the_address_in_network_order(void **state)
{
    lum_layout layout;
    uint8_t out[LUM_SET_IP_BYTES];
    uint32_t address = 0;
    (void)state;
    lum_layout_default(&layout);
    assert_int_equal(lum_set_ip_encode(out, &layout, 0x0a2a0063u), LUM_OK);
    assert_memory_equal(out, set_ip, sizeof set_ip);
    assert_int_equal(lum_set_ip_decode(&layout, out, sizeof out, &address),
                     LUM_OK);
    assert_int_equal(address, 0x0a2a0063u);
}

static void set_ip_bears_it_backwards_where_the_profile_says_so(void **state)
{
    static const uint8_t reversed[] = {99, 0, 42, 10};
    lum_layout layout;
    uint8_t out[LUM_SET_IP_BYTES];
    uint32_t address = 0;
    (void)state;
    lum_layout_default(&layout);
    layout.profile.set_ip_order = LUM_SET_IP_LITTLE;
    assert_int_equal(lum_set_ip_encode(out, &layout, 0x0a2a0063u), LUM_OK);
    assert_memory_equal(out + 12, reversed, sizeof reversed);
    assert_int_equal(lum_set_ip_decode(&layout, out, sizeof out, &address),
                     LUM_OK);
    assert_int_equal(address, 0x0a2a0063u);
}

static void every_bit_of_an_address_has_its_place(void **state)
{
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (unsigned order = LUM_SET_IP_NETWORK; order <= LUM_SET_IP_LITTLE;
         order++) {
        layout.profile.set_ip_order = (uint8_t)order;
        for (unsigned bit = 0; bit < 32; bit++) {
            const unsigned at =
                order == LUM_SET_IP_NETWORK ? 3 - bit / 8u : bit / 8u;
            uint8_t out[LUM_SET_IP_BYTES];
            uint32_t address = 0;
            assert_int_equal(
                lum_set_ip_encode(out, &layout, UINT32_C(1) << bit), LUM_OK);
            for (unsigned i = 0; i < 4; i++) {
                assert_int_equal(out[12 + i], i == at ? 1u << bit % 8u : 0u);
            }
            assert_int_equal(
                lum_set_ip_decode(&layout, out, sizeof out, &address), LUM_OK);
            assert_int_equal(address, UINT32_C(1) << bit);
        }
    }
}

static void addresses_no_sensor_can_have_are_refused(void **state)
{
    static const struct {
        uint32_t address;
        lum_result result;
    } rows[] = {
        {0, LUM_E_VALUE},           {1, LUM_OK},
        {0xdfffffffu, LUM_OK},      {0xe0000000u, LUM_E_VALUE},
        {0xefffffffu, LUM_E_VALUE}, {0xf0000000u, LUM_OK},
        {0xfffffffeu, LUM_OK},      {0xffffffffu, LUM_E_VALUE},
    };
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t out[LUM_SET_IP_BYTES] = {1, 2, 3};
        assert_int_equal(lum_address_is_host(rows[i].address),
                         rows[i].result == LUM_OK);
        assert_int_equal(lum_set_ip_encode(out, &layout, rows[i].address),
                         rows[i].result);
        assert_int_equal(out[0], rows[i].result == LUM_OK ? 0xed : 1);
    }
}

static void every_truncation_of_set_ip_fails_and_writes_nothing(void **state)
{
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (size_t n = 0; n < sizeof set_ip; n++) {
        uint8_t *exact = exact_copy(set_ip, n);
        uint32_t address = 77;
        assert_int_equal(lum_set_ip_decode(&layout, exact, n, &address),
                         n < 12 ? LUM_E_FOREIGN : LUM_E_SHORT);
        assert_int_equal(address, 77);
        free(exact);
    }
}

static void a_timestamp_is_two_little_endian_words(void **state)
{
    const lum_timestamp in = {0x80000007u, 0x92345678u};
    lum_timestamp out = {0, 0};
    uint8_t bytes[LUM_TIMESTAMP_BYTES];
    (void)state;
    lum_timestamp_encode(bytes, &in);
    assert_memory_equal(bytes, timestamp, sizeof timestamp);
    assert_int_equal(lum_timestamp_decode(bytes, sizeof bytes, &out), LUM_OK);
    assert_int_equal(out.sequence, in.sequence);
    assert_int_equal(out.clock_us, in.clock_us);
}

static void a_timestamp_holds_each_word_at_its_limits(void **state)
{
    static const uint32_t limits[] = {0, 1, 0x7fffffffu, 0x80000000u,
                                      0xffffffffu};
    (void)state;
    for (size_t i = 0; i < 25; i++) {
        const lum_timestamp in = {limits[i / 5], limits[i % 5]};
        lum_timestamp out = {7, 7};
        uint8_t bytes[LUM_TIMESTAMP_BYTES];
        lum_timestamp_encode(bytes, &in);
        assert_int_equal(lum_timestamp_decode(bytes, sizeof bytes, &out),
                         LUM_OK);
        assert_int_equal(out.sequence, in.sequence);
        assert_int_equal(out.clock_us, in.clock_us);
    }
}

static void every_truncation_of_a_timestamp_fails(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof timestamp; n++) {
        uint8_t *exact = exact_copy(timestamp, n);
        lum_timestamp out = {7, 7};
        assert_int_equal(lum_timestamp_decode(exact, n, &out),
                         n < 12 ? LUM_E_FOREIGN : LUM_E_SHORT);
        assert_true(out.sequence == 7 && out.clock_us == 7);
        free(exact);
    }
}

static void bytes_behind_a_packet_are_ignored(void **state)
{
    uint8_t bytes[LUM_TIMESTAMP_BYTES + 5] = {0};
    lum_timestamp out = {7, 7};
    (void)state;
    memcpy(bytes, timestamp, sizeof timestamp);
    assert_int_equal(lum_timestamp_decode(bytes, sizeof bytes, &out), LUM_OK);
    assert_int_equal(out.sequence, 0x80000007u);
}

static void each_decoder_refuses_the_others_packets(void **state)
{
    lum_layout layout;
    lum_timestamp stamp = {7, 7};
    lum_tlv_reader reader = {NULL, 7};
    uint32_t value = 7;
    (void)state;
    lum_layout_default(&layout);
    assert_int_equal(
        lum_set_ip_decode(&layout, timestamp, sizeof timestamp, &value),
        LUM_E_TYPE);
    assert_int_equal(lum_timestamp_decode(tlvs, sizeof tlvs, &stamp),
                     LUM_E_TYPE);
    assert_int_equal(lum_tlv_open(timestamp, sizeof timestamp, &value, &reader),
                     LUM_E_TYPE);
    assert_true(value == 7 && stamp.sequence == 7 && reader.left == 7);
}

static void a_tlv_packet_is_read_item_by_item(void **state)
{
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t sequence = 0;
    uint16_t status = 0;
    (void)state;
    assert_int_equal(lum_tlv_open(tlvs, sizeof tlvs, &sequence, &reader),
                     LUM_OK);
    assert_int_equal(sequence, 9);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_OK);
    assert_int_equal(tlv.type, 2);
    assert_int_equal(tlv.length, 2);
    assert_int_equal(lum_tlv_u16(&tlv, &status), LUM_OK);
    assert_int_equal(status, 0x0801);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_OK);
    assert_int_equal(tlv.type, 3);
    assert_memory_equal(tlv.value, "ok", 2);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_END);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_END);
}

static void a_tlv_packet_is_written_item_by_item(void **state)
{
    uint8_t out[sizeof tlvs];
    lum_tlv_writer writer;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 9), LUM_OK);
    assert_int_equal(lum_tlv_add_u16(&writer, 2, 0x0801), LUM_OK);
    assert_int_equal(lum_tlv_add(&writer, 3, "ok", 2), LUM_OK);
    assert_int_equal(writer.len, sizeof tlvs);
    assert_memory_equal(out, tlvs, sizeof tlvs);
}

static void a_packet_without_items_asks_for_the_status(void **state)
{
    static const uint8_t golden[] = {MAGIC, 7, 0, 0, 0, 7, 0, 0, 0};
    uint8_t out[LUM_TLV_PACKET_BYTES];
    lum_tlv_writer writer;
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t sequence = 0;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 7), LUM_OK);
    assert_int_equal(writer.len, sizeof golden);
    assert_memory_equal(out, golden, sizeof golden);
    assert_int_equal(lum_tlv_open(out, writer.len, &sequence, &reader), LUM_OK);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_END);
}

/* A cut on the border between two items is a whole packet of one. */
static void every_truncation_of_a_tlv_packet_is_noticed(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof tlvs; n++) {
        uint8_t *exact = exact_copy(tlvs, n);
        lum_tlv_reader reader = {NULL, 7};
        lum_tlv tlv = {7, 7, NULL};
        uint32_t sequence = 7;
        lum_result r = lum_tlv_open(exact, n, &sequence, &reader);
        assert_int_equal(r, n < 12   ? LUM_E_FOREIGN
                            : n < 16 ? LUM_E_SHORT
                                     : LUM_OK);
        if (r != LUM_OK) {
            assert_true(sequence == 7 && reader.left == 7);
            free(exact);
            continue;
        }
        do {
            r = lum_tlv_next(&reader, &tlv);
        } while (r == LUM_OK);
        assert_int_equal(r, n == 16 || n == 22 ? LUM_END : LUM_E_MALFORMED);
        assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_END);
        free(exact);
    }
}

static void a_cut_item_leaves_the_output_alone(void **state)
{
    lum_tlv_reader reader = {tlvs + 16, 5};
    lum_tlv tlv = {7, 8, tlvs};
    (void)state;
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_E_MALFORMED);
    assert_true(tlv.type == 7 && tlv.length == 8 && tlv.value == tlvs);
    reader = (lum_tlv_reader){tlvs + 16, 3};
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_E_MALFORMED);
    assert_true(tlv.type == 7 && tlv.length == 8 && tlv.value == tlvs);
}

static void an_item_may_have_every_length_of_16_bits(void **state)
{
    static const uint16_t lengths[] = {0, 1, 2, 255, 256, 65534, 65535};
    const size_t size = LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES + 65535u;
    uint8_t *out = malloc(size);
    uint8_t *value = calloc(65535u, 1u);
    (void)state;
    assert_true(out != NULL && value != NULL);
    value[65534] = 0x5a;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        lum_tlv_writer writer;
        lum_tlv_reader reader;
        lum_tlv tlv;
        uint32_t sequence = 0;
        assert_int_equal(lum_tlv_begin(&writer, out, size, 1), LUM_OK);
        assert_int_equal(lum_tlv_add(&writer, 0xffff, value, lengths[i]),
                         LUM_OK);
        assert_int_equal(lum_tlv_open(out, writer.len, &sequence, &reader),
                         LUM_OK);
        assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_OK);
        assert_int_equal(tlv.type, 0xffff);
        assert_int_equal(tlv.length, lengths[i]);
        assert_memory_equal(tlv.value, value, lengths[i]);
        assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_END);
    }
    free(value);
    free(out);
}

static void an_item_of_no_bytes_needs_no_value(void **state)
{
    uint8_t out[LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES];
    lum_tlv_writer writer;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 1), LUM_OK);
    assert_int_equal(lum_tlv_add(&writer, 5, NULL, 0), LUM_OK);
    assert_int_equal(writer.len, sizeof out);
}

static void an_item_of_one_byte_bears_it(void **state)
{
    uint8_t out[LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES + 1] = {0};
    const uint8_t value = 0xab;
    lum_tlv_writer writer;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 1), LUM_OK);
    assert_int_equal(lum_tlv_add(&writer, 3, &value, 1), LUM_OK);
    assert_int_equal(writer.len, sizeof out);
    assert_int_equal(out[sizeof out - 1], 0xab);
}

static void what_does_not_fit_is_not_written(void **state)
{
    (void)state;
    for (size_t size = 0; size < sizeof tlvs; size++) {
        uint8_t *out = exact_copy(tlvs, size);
        lum_tlv_writer writer = {NULL, 0, 77};
        lum_result r = lum_tlv_begin(&writer, out, size, 9);
        if (size < LUM_TLV_PACKET_BYTES) {
            assert_int_equal(r, LUM_E_SPACE);
            assert_int_equal(writer.len, 77);
            free(out);
            continue;
        }
        r = lum_tlv_add_u16(&writer, 2, 0x0801);
        assert_int_equal(r, size < 22 ? LUM_E_SPACE : LUM_OK);
        assert_int_equal(writer.len, size < 22 ? 16 : 22);
        if (r == LUM_OK) {
            assert_int_equal(lum_tlv_add(&writer, 3, "ok", 2), LUM_E_SPACE);
            assert_int_equal(writer.len, 22);
        }
        free(out);
    }
}

static void a_u16_needs_two_bytes(void **state)
{
    static const uint8_t value[] = {0xff, 0xfe, 0x01};
    uint16_t out = 7;
    (void)state;
    for (uint16_t n = 0; n < 2; n++) {
        uint8_t *exact = exact_copy(value, n);
        const lum_tlv tlv = {2, n, exact};
        assert_int_equal(lum_tlv_u16(&tlv, &out), LUM_E_SHORT);
        assert_int_equal(out, 7);
        free(exact);
    }
    const lum_tlv longer = {2, 3, value};
    assert_int_equal(lum_tlv_u16(&longer, &out), LUM_OK);
    assert_int_equal(out, 0xfeff);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_magic_is_the_manuals),
        cmocka_unit_test(a_header_tells_any_type),
        cmocka_unit_test(every_bit_of_the_magic_counts),
        cmocka_unit_test(a_reserved_byte_that_is_set_is_another_type),
        cmocka_unit_test(every_truncation_of_a_header_is_foreign),
        cmocka_unit_test(a_heartbeat_is_a_bare_header),
        cmocka_unit_test(set_ip_bears_the_address_in_network_order),
        cmocka_unit_test(set_ip_bears_it_backwards_where_the_profile_says_so),
        cmocka_unit_test(every_bit_of_an_address_has_its_place),
        cmocka_unit_test(addresses_no_sensor_can_have_are_refused),
        cmocka_unit_test(every_truncation_of_set_ip_fails_and_writes_nothing),
        cmocka_unit_test(a_timestamp_is_two_little_endian_words),
        cmocka_unit_test(a_timestamp_holds_each_word_at_its_limits),
        cmocka_unit_test(every_truncation_of_a_timestamp_fails),
        cmocka_unit_test(bytes_behind_a_packet_are_ignored),
        cmocka_unit_test(each_decoder_refuses_the_others_packets),
        cmocka_unit_test(a_tlv_packet_is_read_item_by_item),
        cmocka_unit_test(a_tlv_packet_is_written_item_by_item),
        cmocka_unit_test(a_packet_without_items_asks_for_the_status),
        cmocka_unit_test(every_truncation_of_a_tlv_packet_is_noticed),
        cmocka_unit_test(a_cut_item_leaves_the_output_alone),
        cmocka_unit_test(an_item_may_have_every_length_of_16_bits),
        cmocka_unit_test(an_item_of_no_bytes_needs_no_value),
        cmocka_unit_test(an_item_of_one_byte_bears_it),
        cmocka_unit_test(what_does_not_fit_is_not_written),
        cmocka_unit_test(a_u16_needs_two_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
