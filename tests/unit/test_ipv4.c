#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/fragments.h"

#include <stdlib.h>
#include <string.h>

#define GOLDEN_BYTES 32 /* 20 of IPv4, 8 of UDP, 4 of payload */

static const uint8_t golden[GOLDEN_BYTES] = {
    0x45, 0,  0, 32, 0x12, 0x34, 0x40, 0,    64, 17, 0, 0, 10,  42,  0,   37,
    10,   42, 0, 1,  0x15, 0x8d, 0xc3, 0x50, 0,  12, 0, 0, 'd', 'a', 't', 'a'};

typedef struct fixture {
    uint8_t bytes[256];
    size_t len;
    lum_record record;
    lum_fragment fragment;
} fixture;

static fixture begin(void)
{
    fixture f;
    memset(&f, 0, sizeof f);
    memcpy(f.bytes, golden, sizeof golden);
    f.len = sizeof golden;
    return f;
}

/* From an allocation of the exact size, so that reads past it are found. */
static lum_record_kind kind_of(fixture *f)
{
    uint8_t *exact = malloc(f->len != 0 ? f->len : 1u);
    assert_non_null(exact);
    memcpy(exact, f->bytes, f->len);
    memset(&f->record, 0, sizeof f->record);
    lum_ipv4_read((lum_span){exact, f->len}, &f->record, &f->fragment);
    if (f->record.kind == LUM_RECORD_DATAGRAM) {
        assert_true(f->record.payload >= exact);
        assert_true(f->record.payload + f->record.len <= exact + f->len);
        f->record.payload = f->bytes + (f->record.payload - exact);
    }
    free(exact);
    return f->record.kind;
}

static void set_total(fixture *f, unsigned total)
{
    f->bytes[2] = (uint8_t)(total >> 8);
    f->bytes[3] = (uint8_t)total;
}

static void set_udp_len(fixture *f, unsigned len)
{
    f->bytes[24] = (uint8_t)(len >> 8);
    f->bytes[25] = (uint8_t)len;
}

/* The offset in bytes. */
static void set_fragment(fixture *f, unsigned offset, bool more)
{
    f->bytes[6] = (uint8_t)((more ? 0x20u : 0u) | (offset / 8u) >> 8);
    f->bytes[7] = (uint8_t)(offset / 8u);
}

static void a_datagram_has_addresses_ports_and_payload(void **state)
{
    fixture f = begin();
    (void)state;
    assert_int_equal(kind_of(&f), LUM_RECORD_DATAGRAM);
    assert_int_equal(f.record.source, 0x0a2a0025);
    assert_int_equal(f.record.destination, 0x0a2a0001);
    assert_int_equal(f.record.source_port, 5517);
    assert_int_equal(f.record.destination_port, 50000);
    assert_int_equal(f.record.len, 4);
    assert_memory_equal(f.record.payload, "data", 4);
}

static void options_are_skipped(void **state)
{
    (void)state;
    for (unsigned words = 6; words <= 15; words++) {
        fixture f = begin();
        const unsigned options = (words - 5u) * 4u;
        memset(f.bytes + 20, 1, options);
        memcpy(f.bytes + 20 + options, golden + 20, 12);
        f.bytes[0] = (uint8_t)(0x40u | words);
        f.len += options;
        set_total(&f, (unsigned)f.len);
        assert_int_equal(kind_of(&f), LUM_RECORD_DATAGRAM);
        assert_int_equal(f.record.source_port, 5517);
        assert_memory_equal(f.record.payload, "data", 4);
    }
}

static void every_cut_behind_the_header_is_cut_short(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof golden; n++) {
        fixture f = begin();
        f.len = n;
        assert_int_equal(kind_of(&f),
                         n < 20 ? LUM_RECORD_OTHER : LUM_RECORD_CUT_SHORT);
        assert_int_equal(f.record.source, n < 20 ? 0 : 0x0a2a0025);
        assert_int_equal(f.record.source_port, n < 24 ? 0 : 5517);
        assert_int_equal(f.record.destination_port, n < 24 ? 0 : 50000);
        assert_int_equal(f.record.len, 0);
    }
}

static void cut_options_are_cut_short_without_ports(void **state)
{
    fixture f = begin();
    (void)state;
    f.bytes[0] = 0x4f;
    set_total(&f, 60 + 12);
    assert_int_equal(kind_of(&f), LUM_RECORD_CUT_SHORT);
    assert_int_equal(f.record.source, 0x0a2a0025);
    assert_int_equal(f.record.source_port, 0);
}

static void padding_does_not_count(void **state)
{
    fixture f = begin();
    (void)state;
    f.len = 46;
    assert_int_equal(kind_of(&f), LUM_RECORD_DATAGRAM);
    assert_int_equal(f.record.len, 4);
    set_udp_len(&f, 10);
    assert_int_equal(kind_of(&f), LUM_RECORD_DATAGRAM);
    assert_int_equal(f.record.len, 2);
    set_udp_len(&f, 8);
    assert_int_equal(kind_of(&f), LUM_RECORD_DATAGRAM);
    assert_int_equal(f.record.len, 0);
}

static void udp_lengths_that_cannot_be_are_other(void **state)
{
    static const unsigned lens[] = {0, 7, 13, 65000, 65535};
    (void)state;
    for (size_t i = 0; i < sizeof lens / sizeof lens[0]; i++) {
        fixture f = begin();
        f.len = 46;
        set_udp_len(&f, lens[i]);
        assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
        f.len = 30;
        assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    }
}

static void total_lengths_without_room_for_udp_are_other(void **state)
{
    static const unsigned totals[] = {0, 19, 20, 27};
    (void)state;
    for (size_t i = 0; i < sizeof totals / sizeof totals[0]; i++) {
        fixture f = begin();
        set_total(&f, totals[i]);
        assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    }
}

static void other_headers_are_other(void **state)
{
    static const struct {
        size_t at;
        uint8_t value;
    } changes[] = {{0, 0x65}, {0, 0x55}, {0, 0x44}, {0, 0x40}, {9, 6}, {9, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        fixture f = begin();
        f.bytes[changes[i].at] = changes[i].value;
        assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    }
}

static void a_fragment_tells_its_place(void **state)
{
    fixture f = begin();
    (void)state;
    f.len = 36;
    set_total(&f, 36);
    set_fragment(&f, 1480, true);
    assert_int_equal(kind_of(&f), LUM_RECORD_FRAGMENT);
    assert_int_equal(f.fragment.offset, 1480);
    assert_int_equal(f.fragment.id, 0x1234);
    assert_int_equal(f.fragment.data.len, 16);
    assert_true(f.fragment.more);
    set_fragment(&f, 1480, false);
    assert_int_equal(kind_of(&f), LUM_RECORD_FRAGMENT);
    assert_false(f.fragment.more);
    assert_int_equal(f.record.source, 0x0a2a0025);
}

static void fragments_that_cannot_be_are_other(void **state)
{
    fixture f = begin();
    (void)state;
    set_fragment(&f, 0, true); /* 12 bytes, not a multiple of 8 */
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    set_fragment(&f, 1480, false);
    set_total(&f, 20); /* nothing in it */
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    f = begin();
    set_fragment(&f, 1480, true);
    f.bytes[9] = 6;
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
}

static void a_fragment_ends_within_the_largest_packet(void **state)
{
    fixture f = begin();
    (void)state;
    set_fragment(&f, 65504, false);
    set_total(&f, 31); /* 20 + 65504 + 11 = 65535 */
    assert_int_equal(kind_of(&f), LUM_RECORD_FRAGMENT);
    set_total(&f, 32);
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
    set_fragment(&f, 65528, false);
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
}

static void of_cut_fragments_the_first_stands_for_the_datagram(void **state)
{
    fixture f = begin();
    (void)state;
    set_total(&f, 1500);
    set_udp_len(&f, 3000);
    set_fragment(&f, 0, true);
    assert_int_equal(kind_of(&f), LUM_RECORD_CUT_SHORT);
    assert_int_equal(f.record.source_port, 5517);
    f.len = 20;
    assert_int_equal(kind_of(&f), LUM_RECORD_CUT_SHORT);
    assert_int_equal(f.record.source_port, 0);
    f.len = 32;
    set_fragment(&f, 1480, true);
    assert_int_equal(kind_of(&f), LUM_RECORD_OTHER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_datagram_has_addresses_ports_and_payload),
        cmocka_unit_test(options_are_skipped),
        cmocka_unit_test(every_cut_behind_the_header_is_cut_short),
        cmocka_unit_test(cut_options_are_cut_short_without_ports),
        cmocka_unit_test(padding_does_not_count),
        cmocka_unit_test(udp_lengths_that_cannot_be_are_other),
        cmocka_unit_test(total_lengths_without_room_for_udp_are_other),
        cmocka_unit_test(other_headers_are_other),
        cmocka_unit_test(a_fragment_tells_its_place),
        cmocka_unit_test(fragments_that_cannot_be_are_other),
        cmocka_unit_test(a_fragment_ends_within_the_largest_packet),
        cmocka_unit_test(of_cut_fragments_the_first_stands_for_the_datagram),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
