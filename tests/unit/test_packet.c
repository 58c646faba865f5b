#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/packet.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

static lum_layout standard(void)
{
    lum_layout layout;
    lum_layout_default(&layout);
    return layout;
}

/* The kind of a packet of a type and length whose body is one byte repeated;
 * anything but data leaves the output alone. */
static lum_packet_kind kind_of(const lum_layout *layout, unsigned type,
                               size_t len, int body)
{
    uint8_t bytes[256];
    lum_group g = {.line = 4711, .tag = 99};
    memset(bytes, body, sizeof bytes);
    lum_header_encode(bytes, (uint8_t)type);
    uint8_t *exact = exact_copy(bytes, len);
    const lum_packet_kind kind = lum_packet_decode(layout, exact, len, &g);
    assert_true(kind == LUM_PACKET_DATA || (g.line == 4711 && g.tag == 99));
    free(exact);
    return kind;
}

static void each_type_has_a_least_length(void **state)
{
    static const struct {
        unsigned type;
        size_t least;
        lum_packet_kind kind;
    } rows[] = {
        {5, 16, LUM_PACKET_SET_IP},
        {6, 20, LUM_PACKET_TIMESTAMP},
        {7, 16, LUM_PACKET_TLV},
    };
    const lum_layout layout = standard();
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        for (size_t len = 0; len < 40; len++) {
            assert_int_equal(kind_of(&layout, rows[i].type, len, 0xff),
                             len < 12              ? LUM_PACKET_FOREIGN
                             : len < rows[i].least ? LUM_PACKET_MALFORMED
                                                   : rows[i].kind);
        }
    }
}

static void type_8_of_12_bytes_is_a_heartbeat_and_longer_is_data(void **state)
{
    const lum_layout layout = standard();
    (void)state;
    assert_int_equal(kind_of(&layout, 8, 11, 0), LUM_PACKET_FOREIGN);
    assert_int_equal(kind_of(&layout, 8, 12, 0), LUM_PACKET_HEARTBEAT);
    for (size_t len = 13; len < 60; len++) {
        assert_int_equal(kind_of(&layout, 8, len, 0), LUM_PACKET_MALFORMED);
    }
}

static void other_types_are_unknown(void **state)
{
    const lum_layout layout = standard();
    (void)state;
    for (unsigned type = 0; type < 256; type++) {
        if (type >= 5 && type <= 8) {
            continue;
        }
        assert_int_equal(kind_of(&layout, type, 12, 0),
                         LUM_PACKET_UNKNOWN_TYPE);
        assert_int_equal(kind_of(&layout, type, 200, 1),
                         LUM_PACKET_UNKNOWN_TYPE);
    }
}

static void a_reserved_byte_makes_the_type_unknown(void **state)
{
    const lum_layout layout = standard();
    lum_group g;
    (void)state;
    for (unsigned at = 9; at < 12; at++) {
        uint8_t bytes[LUM_HEADER_BYTES];
        lum_heartbeat_encode(bytes);
        bytes[at] = 1;
        assert_int_equal(lum_packet_decode(&layout, bytes, sizeof bytes, &g),
                         LUM_PACKET_UNKNOWN_TYPE);
    }
}

static void what_has_no_magic_is_foreign(void **state)
{
    const lum_layout layout = standard();
    lum_group g;
    uint8_t bytes[64] = {0};
    (void)state;
    assert_int_equal(lum_packet_decode(&layout, bytes, sizeof bytes, &g),
                     LUM_PACKET_FOREIGN);
    assert_int_equal(lum_packet_decode(&layout, bytes, 0, &g),
                     LUM_PACKET_FOREIGN);
}

static uint8_t *data_packet(const lum_layout *layout, uint8_t tag, size_t *len)
{
    static const uint8_t samples[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    const lum_group g = {.line = 3, .num_samples = 2, .eye = 1, .tag = tag};
    return encode_packet(layout, &g, samples, len);
}

static void data_are_read(void **state)
{
    const lum_layout layout = standard();
    (void)state;
    for (uint8_t tag = 2; tag <= 3; tag++) {
        size_t len = 0;
        uint8_t *packet = data_packet(&layout, tag, &len);
        lum_group g;
        assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                         LUM_PACKET_DATA);
        assert_int_equal(g.tag, tag);
        assert_int_equal(g.line, 3);
        assert_ptr_equal(g.samples, packet + 24);
        free(packet);
    }
}

static void every_truncation_of_data_is_named(void **state)
{
    const lum_layout layout = standard();
    size_t len = 0;
    uint8_t *packet = data_packet(&layout, 3, &len);
    (void)state;
    for (size_t n = 0; n < len; n++) {
        uint8_t *exact = exact_copy(packet, n);
        lum_group g = {.line = 4711};
        assert_int_equal(lum_packet_decode(&layout, exact, n, &g),
                         n < 12    ? LUM_PACKET_FOREIGN
                         : n == 12 ? LUM_PACKET_HEARTBEAT
                                   : LUM_PACKET_MALFORMED);
        assert_int_equal(g.line, 4711);
        free(exact);
    }
    free(packet);
}

static void an_unknown_tag_has_its_own_kind(void **state)
{
    const lum_layout layout = standard();
    size_t len = 0;
    uint8_t *packet = data_packet(&layout, 3, &len);
    lum_group g;
    (void)state;
    packet[12] = 4;
    assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                     LUM_PACKET_UNKNOWN_TAG);
    free(packet);
}

static void with_another_data_type_a_longer_type_8_is_unknown(void **state)
{
    lum_layout layout = standard();
    size_t len = 0;
    lum_group g;
    (void)state;
    layout.profile.data_packet_type = 3;
    uint8_t *packet = data_packet(&layout, 3, &len);
    assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                     LUM_PACKET_DATA);
    packet[8] = 8;
    assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                     LUM_PACKET_UNKNOWN_TYPE);
    assert_int_equal(lum_packet_decode(&layout, packet, 12, &g),
                     LUM_PACKET_HEARTBEAT);
    packet[8] = 3;
    assert_int_equal(lum_packet_decode(&layout, packet, 12, &g),
                     LUM_PACKET_MALFORMED);
    free(packet);
}

static void with_the_tag_on_the_type_2_and_3_are_data(void **state)
{
    lum_layout layout = standard();
    (void)state;
    layout.profile.group[LUM_FIELD_TAG].at = 8;
    for (uint8_t tag = 2; tag <= 3; tag++) {
        size_t len = 0;
        lum_group g;
        uint8_t *packet = data_packet(&layout, tag, &len);
        assert_int_equal(packet[8], tag);
        assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                         LUM_PACKET_DATA);
        packet[8] = 8;
        assert_int_equal(lum_packet_decode(&layout, packet, len, &g),
                         LUM_PACKET_UNKNOWN_TYPE);
        free(packet);
    }
    assert_int_equal(kind_of(&layout, 8, 12, 0), LUM_PACKET_HEARTBEAT);
    assert_int_equal(kind_of(&layout, 2, 12, 0), LUM_PACKET_MALFORMED);
    assert_int_equal(kind_of(&layout, 4, 60, 0), LUM_PACKET_UNKNOWN_TYPE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_type_has_a_least_length),
        cmocka_unit_test(type_8_of_12_bytes_is_a_heartbeat_and_longer_is_data),
        cmocka_unit_test(other_types_are_unknown),
        cmocka_unit_test(a_reserved_byte_makes_the_type_unknown),
        cmocka_unit_test(what_has_no_magic_is_foreign),
        cmocka_unit_test(data_are_read),
        cmocka_unit_test(every_truncation_of_data_is_named),
        cmocka_unit_test(an_unknown_tag_has_its_own_kind),
        cmocka_unit_test(with_another_data_type_a_longer_type_8_is_unknown),
        ANY_LAYOUT_TEST(with_the_tag_on_the_type_2_and_3_are_data),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
