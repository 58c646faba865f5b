#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "net/exchange.h"

#include <string.h>

#define MS      INT64_C(1000000)
#define TIMEOUT (400 * MS)
#define BEAT    (200 * MS)
#define STATUS  2u

static const lum_exchange_config usual = {.status_tlv = STATUS,
                                          .owns = true,
                                          .first = 100,
                                          .heartbeat_ns = BEAT,
                                          .timeout_ns = TIMEOUT,
                                          .retries = 2};

static lum_exchange x;
static lum_exchange_found found;

static int set_up(void **state)
{
    (void)state;
    lum_exchange_init(&x, &usual);
    memset(&found, 0x5a, sizeof found);
    return 0;
}

/* A step when all that came before now has been seen. */
static lum_exchange_step advance(int64_t now_ns)
{
    return lum_exchange_advance(&x, now_ns, now_ns, &found);
}

static uint32_t sequence_of_packet(void)
{
    const uint8_t *p = x.packet + 12;
    return p[0] | ((uint32_t)p[1] << 8) | ((uint32_t)p[2] << 16) |
           ((uint32_t)p[3] << 24);
}

static lum_exchange_kind take_tlvs(uint32_t sequence, const void *tlvs,
                                   size_t len)
{
    uint8_t packet[128];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                     LUM_OK);
    assert_true(len <= sizeof packet - w.len);
    memcpy(packet + w.len, tlvs, len);
    return lum_exchange_take(&x, packet, w.len + len, &found);
}

static lum_exchange_kind take_status(uint32_t sequence)
{
    return take_tlvs(sequence, "\2\0\2\0\0\2", 6);
}

static lum_exchange_kind take_time(uint32_t sequence, uint32_t clock_us)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp t = {sequence, clock_us};
    lum_timestamp_encode(packet, &t);
    return lum_exchange_take(&x, packet, sizeof packet, &found);
}

static void begin_request_at(int64_t now_ns)
{
    assert_int_equal(lum_exchange_request(&x, now_ns, "\1\0\1\0u", 5), LUM_OK);
}

static void begin_request(void)
{
    begin_request_at(0);
}

static void who_was_held_up_sends_nothing_again(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(advance(LUM_EXCHANGE_STALE_NS - 1), LUM_EXCHANGE_RESEND);
    const int64_t end_ns = 2 * LUM_EXCHANGE_STALE_NS - 1;
    assert_int_equal(advance(end_ns), LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.tries, 2);
    begin_request_at(end_ns);
    assert_int_equal(advance(end_ns), LUM_EXCHANGE_REQUEST);
}

/* However long a try lasts. */
static void being_held_up_begins_with_the_last_look(void **state)
{
    const int64_t look_ns = LUM_EXCHANGE_LOOK_NS;
    (void)state;
    x.config.owns = false;
    x.config.timeout_ns = 10 * LUM_EXCHANGE_STALE_NS;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_true(lum_exchange_next_ns(&x) == look_ns);
    assert_int_equal(advance(look_ns), LUM_EXCHANGE_NOTHING);
    assert_true(lum_exchange_next_ns(&x) == 2 * look_ns);
    assert_int_equal(advance(look_ns + LUM_EXCHANGE_STALE_NS - 1),
                     LUM_EXCHANGE_NOTHING);
    for (int64_t ns = 2 * look_ns; ns < x.due_ns; ns += look_ns) {
        assert_int_equal(advance(ns), LUM_EXCHANGE_NOTHING);
    }
    assert_int_equal(advance(x.due_ns), LUM_EXCHANGE_RESEND);
    const int64_t before_ns = x.due_ns - x.config.timeout_ns;
    for (int64_t ns = before_ns + LUM_EXCHANGE_STALE_NS; ns < x.due_ns;
         ns += look_ns) {
        assert_int_equal(advance(ns), LUM_EXCHANGE_NOTHING);
    }
    assert_int_equal(advance(x.due_ns), LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.tries, 2);
}

static void who_was_held_up_before_the_first_try_sends_nothing(void **state)
{
    (void)state;
    begin_request_at(TIMEOUT);
    assert_int_equal(advance(TIMEOUT + LUM_EXCHANGE_STALE_NS),
                     LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.tries, 0);
    begin_request_at(TIMEOUT);
    assert_int_equal(advance(TIMEOUT + LUM_EXCHANGE_STALE_NS - 1),
                     LUM_EXCHANGE_REQUEST);
}

static void what_waited_for_who_was_held_up_is_still_its_answer(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(
        lum_exchange_advance(&x, TIMEOUT + LUM_EXCHANGE_STALE_NS, 0, &found),
        LUM_EXCHANGE_NOTHING);
    assert_int_equal(take_status(sequence_of_packet()), LUM_EXCHANGE_ANSWER);
}

static void begin_time(void)
{
    assert_int_equal(lum_exchange_request_time(&x, 0), LUM_OK);
}

static void a_request_is_sent_at_once_and_again_on_each_timeout(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(5), LUM_EXCHANGE_REQUEST);
    assert_int_equal(advance(5), LUM_EXCHANGE_NOTHING);
    assert_int_equal(advance(4 + TIMEOUT), LUM_EXCHANGE_NOTHING);
    assert_int_equal(advance(5 + TIMEOUT), LUM_EXCHANGE_RESEND);
    assert_int_equal(advance(4 + 2 * TIMEOUT), LUM_EXCHANGE_NOTHING);
    assert_int_equal(advance(5 + 2 * TIMEOUT), LUM_EXCHANGE_RESEND);
    assert_int_equal(advance(4 + 3 * TIMEOUT), LUM_EXCHANGE_NOTHING);
    assert_int_equal(advance(5 + 3 * TIMEOUT), LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.sequence, 100);
    assert_int_equal(found.tries, 3);
    assert_int_equal(advance(9 + 9 * TIMEOUT), LUM_EXCHANGE_NOTHING);
}

static void without_retries_a_request_is_sent_once(void **state)
{
    (void)state;
    x.config.retries = 0;
    begin_time();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(advance(TIMEOUT), LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.tries, 1);
}

static void a_resend_repeats_the_bytes(void **state)
{
    static const uint8_t packet[] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34,
                                     0x12, 7,    0,    0,    0,    100,  0,
                                     0,    0,    1,    0,    1,    0,    'u'};
    (void)state;
    begin_request();
    for (int64_t t = 0; t < 3; t++) {
        assert_int_not_equal(advance(t * TIMEOUT), LUM_EXCHANGE_NOTHING);
        assert_int_equal(x.packet_len, sizeof packet);
        assert_memory_equal(x.packet, packet, sizeof packet);
    }
}

static void an_answer_ends_the_request(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(7), LUM_EXCHANGE_REQUEST);
    assert_int_equal(advance(7 + TIMEOUT), LUM_EXCHANGE_RESEND);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
    assert_int_equal(found.sequence, 100);
    assert_int_equal(found.tries, 2);
    assert_true(found.sent_ns == 7);
    assert_true(found.has_status);
    assert_int_equal(found.status, 0x200);
    assert_int_equal(found.tlvs.left, 6);
    assert_int_equal(advance(9 * TIMEOUT), LUM_EXCHANGE_NOTHING);
}

static void a_repeated_answer_is_dropped(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
    assert_int_equal(take_status(100), LUM_EXCHANGE_DROPPED);
    begin_time();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_time(101, 1), LUM_EXCHANGE_TIME);
    assert_int_equal(take_time(101, 1), LUM_EXCHANGE_DROPPED);
}

static void an_answer_to_a_request_given_up_is_dropped(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    lum_exchange_give_up(&x);
    assert_int_equal(take_status(100), LUM_EXCHANGE_DROPPED);
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_status(100), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_status(101), LUM_EXCHANGE_ANSWER);
}

static void nothing_answers_what_was_not_sent(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(take_status(100), LUM_EXCHANGE_DROPPED);
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
}

static void a_number_never_issued_is_an_alert(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    static const uint32_t others[] = {0, 1, 99, 101, 0x80000000u, 0xffffffffu};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        assert_int_equal(take_status(others[i]), LUM_EXCHANGE_ALERT);
        assert_int_equal(found.sequence, others[i]);
        assert_int_equal(found.status, 0x200);
        assert_int_equal(found.tries, 0);
    }
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
}

static void a_time_that_nobody_asked_for_is_dropped(void **state)
{
    (void)state;
    begin_time();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_time(99, 1), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_time(101, 1), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_time(100, 1), LUM_EXCHANGE_TIME);
}

static void an_answer_of_the_other_kind_is_none(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_time(100, 1), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
    begin_time();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_status(101), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_time(101, 1), LUM_EXCHANGE_TIME);
}

static void each_try_of_a_time_request_has_its_number_and_time(void **state)
{
    (void)state;
    for (uint32_t answered = 0; answered < 3; answered++) {
        const uint32_t first = 100 + 3 * answered;
        begin_time();
        for (uint32_t try = 0; try < 3; try++) {
            assert_int_not_equal(advance(try * TIMEOUT), LUM_EXCHANGE_NOTHING);
            assert_int_equal(x.packet_len, LUM_TIMESTAMP_BYTES);
            assert_int_equal(sequence_of_packet(), first + try);
        }
        assert_int_equal(take_time(first + answered, 4711), LUM_EXCHANGE_TIME);
        assert_int_equal(found.sequence, first + answered);
        assert_int_equal(found.clock_us, 4711);
        assert_int_equal(found.tries, 3);
        assert_true(found.sent_ns == answered * TIMEOUT);
    }
}

static void the_number_of_the_last_try_is_given_up(void **state)
{
    (void)state;
    begin_time();
    for (int64_t try = 0; try < 3; try++) {
        assert_int_not_equal(advance(try * TIMEOUT), LUM_EXCHANGE_NOTHING);
    }
    assert_int_equal(advance(3 * TIMEOUT), LUM_EXCHANGE_GIVEN_UP);
    assert_int_equal(found.sequence, 102);
    assert_int_equal(found.tries, 3);
    assert_int_equal(take_time(102, 1), LUM_EXCHANGE_DROPPED);
}

static void tries_too_long_ago_are_forgotten(void **state)
{
    const uint32_t tries = LUM_EXCHANGE_TRIES + 3u;
    (void)state;
    x.config.retries = UINT32_MAX;
    begin_time();
    for (uint32_t try = 0; try < tries; try++) {
        assert_int_not_equal(advance(try * TIMEOUT), LUM_EXCHANGE_NOTHING);
    }
    assert_int_equal(take_time(102, 1), LUM_EXCHANGE_DROPPED);
    assert_int_equal(take_time(103, 1), LUM_EXCHANGE_TIME);
    assert_true(found.sent_ns == 3 * TIMEOUT);
}

static void the_first_try_of_tlvs_is_never_forgotten(void **state)
{
    (void)state;
    x.config.retries = UINT32_MAX;
    begin_request();
    for (int64_t try = 0; try < 2 * (int64_t)LUM_EXCHANGE_TRIES; try++) {
        assert_int_not_equal(advance(3 + try * TIMEOUT), LUM_EXCHANGE_NOTHING);
    }
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
    assert_true(found.sent_ns == 3);
}

static void an_answer_that_contradicts_itself_is_none(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(take_tlvs(100, "\2\0\2\0\0", 5), LUM_EXCHANGE_MALFORMED);
    assert_int_equal(take_tlvs(100, "\2\0\2\0\0\2\3", 7),
                     LUM_EXCHANGE_MALFORMED);
    assert_int_equal(advance(TIMEOUT), LUM_EXCHANGE_RESEND);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
}

static void an_alert_that_contradicts_itself_is_malformed(void **state)
{
    (void)state;
    assert_int_equal(take_tlvs(7, "\2\0\377\377\0", 5), LUM_EXCHANGE_MALFORMED);
}

static void a_packet_too_short_for_its_type_is_malformed(void **state)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES] = {0};
    (void)state;
    lum_header_encode(packet, LUM_TYPE_TIMESTAMP);
    assert_int_equal(lum_exchange_take(&x, packet, 19, &found),
                     LUM_EXCHANGE_MALFORMED);
    lum_header_encode(packet, LUM_TYPE_TLV);
    assert_int_equal(lum_exchange_take(&x, packet, 15, &found),
                     LUM_EXCHANGE_MALFORMED);
}

static void data_and_what_is_not_ours_does_not_concern_requests(void **state)
{
    uint8_t packet[64] = {0};
    (void)state;
    assert_int_equal(lum_exchange_take(&x, packet, sizeof packet, &found),
                     LUM_EXCHANGE_OTHER);
    assert_int_equal(lum_exchange_take(&x, packet, 0, &found),
                     LUM_EXCHANGE_OTHER);
    lum_heartbeat_encode(packet);
    assert_int_equal(lum_exchange_take(&x, packet, sizeof packet, &found),
                     LUM_EXCHANGE_OTHER);
    lum_header_encode(packet, LUM_TYPE_TLV);
    packet[9] = 1;
    assert_int_equal(lum_exchange_take(&x, packet, sizeof packet, &found),
                     LUM_EXCHANGE_OTHER);
}

static void the_last_status_counts_and_only_a_whole_one(void **state)
{
    (void)state;
    assert_int_equal(take_tlvs(7, "\2\0\2\0\0\2\2\0\2\0\0\010\2\0\1\0\1", 17),
                     LUM_EXCHANGE_ALERT);
    assert_true(found.has_status);
    assert_int_equal(found.status, 0x800);
    assert_int_equal(take_tlvs(7, "\3\0\2\0ab", 6), LUM_EXCHANGE_ALERT);
    assert_false(found.has_status);
    x.config.status_tlv = 3;
    assert_int_equal(take_tlvs(7, "\3\0\2\0ab", 6), LUM_EXCHANGE_ALERT);
    assert_true(found.has_status);
}

static void one_request_at_a_time(void **state)
{
    (void)state;
    begin_request();
    assert_int_equal(lum_exchange_request(&x, 0, NULL, 0), LUM_E_VALUE);
    assert_int_equal(lum_exchange_request_time(&x, 0), LUM_E_VALUE);
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(x.packet_len, 21);
    assert_int_equal(sequence_of_packet(), 100);
}

static void a_request_too_long_is_refused_and_takes_no_number(void **state)
{
    static const uint8_t tlvs[LUM_SENSOR_REQUEST_BYTES];
    const size_t most = LUM_SENSOR_REQUEST_BYTES - LUM_TLV_PACKET_BYTES;
    (void)state;
    assert_int_equal(lum_exchange_request(&x, 0, tlvs, most + 1), LUM_E_SPACE);
    assert_int_equal(advance(0), LUM_EXCHANGE_NOTHING);
    assert_int_equal(lum_exchange_request(&x, 0, tlvs, most), LUM_OK);
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_int_equal(x.packet_len, LUM_SENSOR_REQUEST_BYTES);
    assert_int_equal(sequence_of_packet(), 100);
}

/* Numbers of polls, each answered. */
static void expect_numbers(uint32_t first, const uint32_t *numbers, size_t n)
{
    lum_exchange_config config = usual;
    config.first = first;
    lum_exchange_init(&x, &config);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(lum_exchange_request(&x, 0, NULL, 0), LUM_OK);
        assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
        assert_int_equal(sequence_of_packet(), numbers[i]);
        assert_int_equal(take_status(numbers[i]), LUM_EXCHANGE_ANSWER);
    }
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(take_status(numbers[i]), LUM_EXCHANGE_DROPPED);
    }
}

static void numbers_go_on_past_their_wrap_without_a_zero(void **state)
{
    (void)state;
    expect_numbers(0xfffffffeu, (uint32_t[]){0xfffffffeu, 0xffffffffu, 1, 2},
                   4);
    assert_int_equal(take_status(0), LUM_EXCHANGE_ALERT);
    assert_int_equal(take_status(3), LUM_EXCHANGE_ALERT);
}

static void a_zero_that_was_asked_for_is_used(void **state)
{
    (void)state;
    expect_numbers(0, (uint32_t[]){0, 1, 2}, 3);
}

static void heartbeats_begin_at_once_and_keep_to_their_grid(void **state)
{
    (void)state;
    assert_true(lum_exchange_next_ns(&x) == INT64_MIN);
    assert_true(lum_exchange_beat(&x, 7));
    assert_false(lum_exchange_beat(&x, 7));
    assert_true(lum_exchange_next_ns(&x) == 7 + BEAT);
    assert_false(lum_exchange_beat(&x, 6 + BEAT));
    assert_true(lum_exchange_beat(&x, 30 * MS + BEAT));
    assert_true(lum_exchange_next_ns(&x) == 7 + 2 * BEAT);
    assert_true(lum_exchange_beat(&x, 7 + 2 * BEAT));
    assert_true(lum_exchange_next_ns(&x) == 7 + 3 * BEAT);
}

static void after_a_stall_one_heartbeat_makes_up_for_all(void **state)
{
    (void)state;
    assert_true(lum_exchange_beat(&x, 0));
    assert_true(lum_exchange_beat(&x, 10 * BEAT + 5));
    assert_false(lum_exchange_beat(&x, 10 * BEAT + 5));
    assert_true(lum_exchange_next_ns(&x) == 11 * BEAT);
}

static void who_does_not_own_sends_no_heartbeats(void **state)
{
    (void)state;
    x.config.owns = false;
    assert_false(lum_exchange_beat(&x, 0));
    assert_true(lum_exchange_next_ns(&x) == INT64_MAX);
}

static void the_next_step_is_the_earliest(void **state)
{
    (void)state;
    assert_true(lum_exchange_beat(&x, 0));
    begin_request();
    assert_true(lum_exchange_next_ns(&x) == INT64_MIN);
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    assert_true(lum_exchange_next_ns(&x) == BEAT);
    assert_true(lum_exchange_beat(&x, BEAT + 1));
    assert_true(lum_exchange_beat(&x, 2 * BEAT));
    assert_true(lum_exchange_next_ns(&x) == TIMEOUT);
}

static void no_request_ends_while_its_answer_may_wait_unread(void **state)
{
    (void)state;
    x.config.retries = 0;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    const int64_t late = 5 * TIMEOUT;
    assert_int_equal(lum_exchange_advance(&x, late, 3, &found),
                     LUM_EXCHANGE_NOTHING);
    assert_int_equal(take_status(100), LUM_EXCHANGE_ANSWER);
}

static void a_flood_does_not_keep_a_request_from_ending(void **state)
{
    (void)state;
    x.config.retries = 0;
    begin_request();
    assert_int_equal(advance(0), LUM_EXCHANGE_REQUEST);
    const int64_t late = 5 * TIMEOUT;
    assert_int_equal(lum_exchange_advance(&x, late, 3, &found),
                     LUM_EXCHANGE_NOTHING);
    assert_int_equal(
        lum_exchange_advance(&x, late + TIMEOUT - 1, TIMEOUT - 1, &found),
        LUM_EXCHANGE_NOTHING);
    assert_int_equal(
        lum_exchange_advance(&x, late + TIMEOUT, TIMEOUT - 1, &found),
        LUM_EXCHANGE_GIVEN_UP);
    begin_request_at(late + TIMEOUT);
    assert_int_equal(advance(late + TIMEOUT), LUM_EXCHANGE_REQUEST);
    assert_int_equal(lum_exchange_advance(&x, 2 * late, 3, &found),
                     LUM_EXCHANGE_NOTHING);
}

#define FRESH(test) cmocka_unit_test_setup(test, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FRESH(who_was_held_up_sends_nothing_again),
        FRESH(being_held_up_begins_with_the_last_look),
        FRESH(who_was_held_up_before_the_first_try_sends_nothing),
        FRESH(what_waited_for_who_was_held_up_is_still_its_answer),
        FRESH(a_request_is_sent_at_once_and_again_on_each_timeout),
        FRESH(without_retries_a_request_is_sent_once),
        FRESH(a_resend_repeats_the_bytes),
        FRESH(an_answer_ends_the_request),
        FRESH(a_repeated_answer_is_dropped),
        FRESH(an_answer_to_a_request_given_up_is_dropped),
        FRESH(nothing_answers_what_was_not_sent),
        FRESH(a_number_never_issued_is_an_alert),
        FRESH(a_time_that_nobody_asked_for_is_dropped),
        FRESH(an_answer_of_the_other_kind_is_none),
        FRESH(each_try_of_a_time_request_has_its_number_and_time),
        FRESH(the_number_of_the_last_try_is_given_up),
        FRESH(tries_too_long_ago_are_forgotten),
        FRESH(the_first_try_of_tlvs_is_never_forgotten),
        FRESH(an_answer_that_contradicts_itself_is_none),
        FRESH(an_alert_that_contradicts_itself_is_malformed),
        FRESH(a_packet_too_short_for_its_type_is_malformed),
        FRESH(data_and_what_is_not_ours_does_not_concern_requests),
        FRESH(the_last_status_counts_and_only_a_whole_one),
        FRESH(one_request_at_a_time),
        FRESH(a_request_too_long_is_refused_and_takes_no_number),
        FRESH(numbers_go_on_past_their_wrap_without_a_zero),
        FRESH(a_zero_that_was_asked_for_is_used),
        FRESH(heartbeats_begin_at_once_and_keep_to_their_grid),
        FRESH(after_a_stall_one_heartbeat_makes_up_for_all),
        FRESH(who_does_not_own_sends_no_heartbeats),
        FRESH(the_next_step_is_the_earliest),
        FRESH(no_request_ends_while_its_answer_may_wait_unread),
        FRESH(a_flood_does_not_keep_a_request_from_ending),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
