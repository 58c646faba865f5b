#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/datagram_packet.h"

#include <stdlib.h>
#include <string.h>

#define GOLDEN_BYTES 36 /* 32 before the data, 4 of data */

static const uint8_t little[GOLDEN_BYTES] = {
    0,  1,  0, 0, 2,    0,    0, 0, 3, 0, 0, 0, 10, 42, 0,   37,  0x8d, 0x15,
    10, 42, 0, 1, 0x50, 0xc3, 4, 0, 0, 0, 4, 0, 0,  0,  'd', 'a', 't',  'a'};
static const uint8_t big[GOLDEN_BYTES] = {
    0,  0,  0, 0, 0,    0,    0, 2, 0, 0, 0, 3, 10, 42, 0,   37,  0x15, 0x8d,
    10, 42, 0, 1, 0xc3, 0x50, 0, 0, 0, 4, 0, 0, 0,  4,  'd', 'a', 't',  'a'};

static void check(const uint8_t *message)
{
    lum_record r;
    uint32_t whole = 0;
    assert_true(lum_mcap_datagram_read(message, GOLDEN_BYTES, &r, &whole));
    assert_int_equal(whole, 4);
    assert_int_equal(r.kind, LUM_RECORD_DATAGRAM);
    assert_int_equal(r.time_ns, 2000000003);
    assert_int_equal(r.len, 4);
    assert_memory_equal(r.payload, "data", 4);
    assert_int_equal(r.source, 0x0a2a0025);
    assert_int_equal(r.source_port, 5517);
    assert_int_equal(r.destination, 0x0a2a0001);
    assert_int_equal(r.destination_port, 50000);
}

static void either_byte_order_is_read(void **state)
{
    (void)state;
    check(little);
    check(big);
}

/* On the heap, so that a read behind the end is seen. */
static void a_message_cut_anywhere_is_refused(void **state)
{
    (void)state;
    for (size_t len = 1; len < GOLDEN_BYTES; len++) {
        lum_record r;
        uint32_t whole = 0;
        uint8_t *const cut = malloc(len);
        assert_non_null(cut);
        memcpy(cut, little, len);
        assert_false(lum_mcap_datagram_read(cut, len, &r, &whole));
        free(cut);
    }
}

static bool is_read_with(size_t at, uint8_t value, lum_record *out)
{
    uint8_t message[GOLDEN_BYTES];
    uint32_t whole = 0;
    memcpy(message, little, sizeof message);
    message[at] = value;
    return lum_mcap_datagram_read(message, sizeof message, out, &whole);
}

static void less_data_than_was_sent_is_cut_short(void **state)
{
    lum_record r;
    (void)state;
    assert_true(is_read_with(24, 9, &r));
    assert_int_equal(r.kind, LUM_RECORD_CUT_SHORT);
}

static void numbers_that_cannot_be_are_refused(void **state)
{
    lum_record r;
    (void)state;
    assert_false(is_read_with(24, 3, &r));    /* more data than was sent */
    assert_false(is_read_with(31, 0xff, &r)); /* more than the message has */
    assert_false(is_read_with(11, 0xff, &r)); /* nanoseconds */
    assert_false(is_read_with(0, 1, &r));     /* not CDR */
    assert_false(is_read_with(1, 2, &r));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(either_byte_order_is_read),
        cmocka_unit_test(a_message_cut_anywhere_is_refused),
        cmocka_unit_test(less_data_than_was_sent_is_cut_short),
        cmocka_unit_test(numbers_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
