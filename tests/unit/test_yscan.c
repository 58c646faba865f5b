#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/host/yscan.h"

#include <stdlib.h>
#include <string.h>

static const int16_t elevations[] = {0, 1, -1, 32767, -32768, 258};
static const uint8_t golden[] = {4,    0,    12,   0,    0, 0,    1, 0,
                                 0xff, 0xff, 0xff, 0x7f, 0, 0x80, 2, 1};

static void a_table_is_little_endian_elevations(void **state)
{
    uint8_t out[LUM_TLV_PACKET_BYTES + sizeof golden];
    lum_tlv_writer writer;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 1), LUM_OK);
    assert_int_equal(lum_yscan_add(&writer, 4, elevations, 6), LUM_OK);
    assert_int_equal(writer.len, sizeof out);
    assert_memory_equal(out + LUM_TLV_PACKET_BYTES, golden, sizeof golden);
}

static void a_table_comes_back_whole(void **state)
{
    const lum_tlv tlv = {4, 12, golden + 4};
    int16_t out[6] = {7, 7, 7, 7, 7, 7};
    size_t n = 0;
    (void)state;
    assert_int_equal(lum_yscan_decode(&tlv, out, 6, &n), LUM_OK);
    assert_int_equal(n, 6);
    assert_memory_equal(out, elevations, sizeof elevations);
}

static void every_truncation_is_a_shorter_table_or_odd(void **state)
{
    (void)state;
    for (uint16_t len = 0; len <= 12; len++) {
        uint8_t *exact = exact_copy(golden + 4, len);
        const lum_tlv tlv = {4, len, exact};
        int16_t out[6] = {7, 7, 7, 7, 7, 7};
        size_t n = 77;
        const lum_result r = lum_yscan_decode(&tlv, out, 6, &n);
        assert_int_equal(r, len % 2 ? LUM_E_MALFORMED : LUM_OK);
        assert_int_equal(n, len % 2 ? 77 : len / 2);
        assert_int_equal(out[5], len == 12 ? 258 : 7);
        free(exact);
    }
}

static void a_longer_table_than_there_is_room_for_is_refused(void **state)
{
    const lum_tlv tlv = {4, 12, golden + 4};
    int16_t out[5] = {7, 7, 7, 7, 7};
    size_t n = 77;
    (void)state;
    assert_int_equal(lum_yscan_decode(&tlv, out, 5, &n), LUM_E_SPACE);
    assert_true(n == 77 && out[0] == 7);
}

static void a_table_that_does_not_fit_is_not_written(void **state)
{
    (void)state;
    for (size_t size = LUM_TLV_PACKET_BYTES;
         size < LUM_TLV_PACKET_BYTES + sizeof golden; size++) {
        uint8_t *out = exact_copy((uint8_t[64]){0}, size);
        lum_tlv_writer writer;
        assert_int_equal(lum_tlv_begin(&writer, out, size, 1), LUM_OK);
        assert_int_equal(lum_yscan_add(&writer, 4, elevations, 6), LUM_E_SPACE);
        assert_int_equal(writer.len, LUM_TLV_PACKET_BYTES);
        free(out);
    }
}

static void the_longest_table_fills_a_tlv(void **state)
{
    const size_t most = LUM_YSCAN_LINES_MAX;
    const size_t size = LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES + 2 * most;
    uint8_t *out = malloc(size + 2);
    int16_t *in = calloc(most + 1, sizeof *in);
    int16_t *back = calloc(most, sizeof *back);
    lum_tlv_writer writer;
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t sequence = 0;
    size_t n = 0;
    (void)state;
    assert_true(out != NULL && in != NULL && back != NULL);
    in[most - 1] = -5;
    assert_int_equal(lum_tlv_begin(&writer, out, size + 2, 1), LUM_OK);
    assert_int_equal(lum_yscan_add(&writer, 4, in, most + 1), LUM_E_VALUE);
    assert_int_equal(lum_yscan_add(&writer, 4, in, most), LUM_OK);
    assert_int_equal(lum_tlv_open(out, writer.len, &sequence, &reader), LUM_OK);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_OK);
    assert_int_equal(tlv.length, 65534);
    assert_int_equal(lum_yscan_decode(&tlv, back, most, &n), LUM_OK);
    assert_int_equal(n, most);
    assert_memory_equal(in, back, most * sizeof *in);
    free(back);
    free(in);
    free(out);
}

static void an_empty_table_is_a_table(void **state)
{
    const lum_tlv tlv = {4, 0, golden};
    uint8_t out[LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES];
    lum_tlv_writer writer;
    size_t n = 77;
    (void)state;
    assert_int_equal(lum_tlv_begin(&writer, out, sizeof out, 1), LUM_OK);
    assert_int_equal(lum_yscan_add(&writer, 4, NULL, 0), LUM_OK);
    assert_int_equal(writer.len, sizeof out);
    assert_int_equal(lum_yscan_decode(&tlv, NULL, 0, &n), LUM_OK);
    assert_int_equal(n, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_table_is_little_endian_elevations),
        cmocka_unit_test(a_table_comes_back_whole),
        cmocka_unit_test(every_truncation_is_a_shorter_table_or_odd),
        cmocka_unit_test(a_longer_table_than_there_is_room_for_is_refused),
        cmocka_unit_test(a_table_that_does_not_fit_is_not_written),
        cmocka_unit_test(the_longest_table_fills_a_tlv),
        cmocka_unit_test(an_empty_table_is_a_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
