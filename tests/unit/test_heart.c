#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "heart.h"

#include "lum/wire.h"

#include <string.h>

#define NOW 1000000u

/* Datagrams that were sent, by length. */
static size_t heartbeats, requests, polls, others;
static bool refuses;

static bool count_sent(void *context, const uint8_t *bytes, size_t len)
{
    uint8_t type = 0;
    (void)context;
    assert_int_equal(lum_header_decode(bytes, len, &type), LUM_OK);
    if (refuses) {
        return false;
    }
    if (type == LUM_TYPE_TLV) {
        assert_int_equal(len, LUM_TLV_PACKET_BYTES);
        polls++;
    } else if (len == LUM_HEARTBEAT_BYTES) {
        heartbeats++;
    } else if (len == LUM_TIMESTAMP_BYTES) {
        requests++;
    } else {
        others++;
    }
    return true;
}

/* Each of its words has a value of its own, and the next heartbeat is due. */
static heart ready(void)
{
    heartbeats = requests = polls = others = 0;
    refuses = false;
    return (heart){.send = count_sent,
                   .rounds = 101,
                   .rounds_seen = 101,
                   .ticks = 53,
                   .ticks_seen = 53,
                   .stalls = 30,
                   .lasts_ms = 700,
                   .stall_ms = 700,
                   .alive_ms = NOW - 3u,
                   .next_ms = NOW,
                   .sent = 7,
                   .failed = 13,
                   .until_poll = 4};
}

static void a_beat_counts_a_round_and_says_how_long_it_serves(void **state)
{
    heart h = ready();
    h.rounds_seen = 99;
    (void)state;
    heart_beat(&h, 1234);
    heart_beat(&h, 1235);
    assert_int_equal(h.rounds, 103);
    assert_int_equal(h.rounds_seen, 99);
    assert_int_equal(h.lasts_ms, 1235);
    assert_int_equal(h.stall_ms, 700);
}

static void each_tick_counts(void **state)
{
    heart h = ready();
    (void)state;
    assert_false(heart_has_ticked(&h));
    heart_tick(&h, NOW - 1u);
    heart_tick(&h, NOW - 1u);
    assert_int_equal(h.ticks, 55);
    assert_int_equal(h.ticks_seen, 53);
    assert_true(heart_has_ticked(&h));
    assert_int_equal(h.ticks_seen, 55);
    assert_false(heart_has_ticked(&h));
    assert_int_equal(h.ticks, 55);
}

static void the_first_heartbeat_waits_for_the_sensors_silence(void **state)
{
    heart h;
    (void)state;
    ready();
    memset(&h, 0xa5, sizeof h);
    heart_init(&h, count_sent, NULL, NOW);
    assert_true(h.hung);
    assert_int_equal(heart_stalls(&h), 1);
    for (uint32_t ms = 0; ms < HEART_SILENCE_MS; ms += 500u) {
        heart_beat(&h, 1000);
        heart_tick(&h, NOW + ms);
    }
    heart_tick(&h, NOW + HEART_SILENCE_MS - 1u);
    assert_int_equal(heartbeats, 0);
    heart_tick(&h, NOW + HEART_SILENCE_MS);
    assert_int_equal(heartbeats, 1);
    assert_int_equal(polls, 1);
}

/* The count is odd while it lasts. */
static void a_stall_begins_when_the_round_has_served(void **state)
{
    heart h = ready();
    (void)state;
    h.alive_ms = NOW;
    heart_tick(&h, NOW + 699u);
    assert_int_equal(heart_stalls(&h), 30);
    h.lasts_ms = 1; /* of a round that is under way */
    heart_tick(&h, NOW + 699u);
    assert_int_equal(heart_stalls(&h), 30);
    heart_tick(&h, NOW + 700u);
    assert_int_equal(heart_stalls(&h), 31);
    heart_tick(&h, NOW + 701u);
    assert_int_equal(heart_stalls(&h), 31);
    heart_beat(&h, 5);
    heart_tick(&h, NOW + 702u);
    assert_int_equal(heart_stalls(&h), 32);
    assert_int_equal(h.stall_ms, 5);
    heart_tick(&h, NOW + 706u);
    assert_int_equal(heart_stalls(&h), 32);
    heart_tick(&h, NOW + 707u);
    assert_int_equal(heart_stalls(&h), 33);
}

/* Rounds that serve for no time are no stall as they come. */
static void a_round_ends_a_stall_whatever_it_serves_for(void **state)
{
    heart h = ready();
    (void)state;
    heart_beat(&h, 0);
    heart_tick(&h, NOW - 1u);
    assert_int_equal(heart_stalls(&h), 30);
    heart_tick(&h, NOW - 1u);
    assert_int_equal(heart_stalls(&h), 31);
}

static void without_a_round_for_long_no_heartbeat_leaves(void **state)
{
    heart h = ready();
    (void)state;
    h.stall_ms = UINT32_MAX;
    h.alive_ms = NOW;
    h.next_ms = NOW + HEART_STALL_MS - 1u;
    heart_tick(&h, NOW + HEART_STALL_MS - 1u);
    assert_false(h.hung);
    assert_int_equal(heartbeats, 1);
    assert_int_equal(heart_stalls(&h), 30);
    h.next_ms = NOW + HEART_STALL_MS;
    heart_tick(&h, NOW + HEART_STALL_MS);
    assert_true(h.hung);
    assert_int_equal(heartbeats, 1);
    assert_int_equal(heart_stalls(&h), 31);
    assert_int_equal(h.next_ms, NOW + HEART_STALL_MS);
    heart_beat(&h, 900);
    heart_tick(&h, NOW + HEART_STALL_MS + 1u);
    assert_false(h.hung);
    assert_int_equal(heartbeats, 2);
}

/* A tick that comes late is made up for, but not one late by a period. */
static void assert_next(uint32_t late, uint32_t next)
{
    heart h = ready();
    h.next_ms = NOW - late;
    heart_tick(&h, NOW);
    assert_int_equal(heartbeats, 1);
    assert_int_equal(requests, 1);
    assert_int_equal(others, 0);
    assert_int_equal(h.sent, 8);
    assert_int_equal(h.failed, 13);
    assert_int_equal(h.until_poll, 3);
    assert_int_equal(h.ticks, 54);
    assert_int_equal(h.ticks_seen, 53);
    assert_int_equal(h.lasts_ms, 700);
    assert_int_equal(h.next_ms, next);
}

static void heartbeats_keep_their_beat(void **state)
{
    (void)state;
    assert_next(0, NOW + HEART_PERIOD_MS);
    assert_next(3, NOW + HEART_PERIOD_MS - 3u);
    assert_next(HEART_PERIOD_MS - 1u, NOW + 1u);
    assert_next(HEART_PERIOD_MS, NOW + HEART_PERIOD_MS);
    assert_next(HEART_PERIOD_MS + 1u, NOW + HEART_PERIOD_MS);
    assert_next(0x60000000u, NOW + HEART_PERIOD_MS);
    assert_next(0x7fffffffu, NOW + HEART_PERIOD_MS);
}

static void what_is_not_due_waits(void **state)
{
    heart h = ready();
    (void)state;
    h.next_ms = NOW + 1u;
    heart_tick(&h, NOW);
    h.next_ms = NOW + 0x7fffffffu;
    heart_tick(&h, NOW);
    assert_int_equal(heartbeats, 0);
    assert_int_equal(h.next_ms, NOW + 0x7fffffffu);
}

static void what_cannot_be_sent_stays_due(void **state)
{
    heart h = ready();
    (void)state;
    h.next_ms = NOW - 50u;
    refuses = true;
    heart_tick(&h, NOW);
    assert_int_equal(h.failed, 14);
    assert_int_equal(h.sent, 7);
    assert_int_equal(h.next_ms, NOW);
    refuses = false;
    heart_tick(&h, NOW + 1u);
    assert_int_equal(heartbeats, 1);
    assert_int_equal(h.next_ms, NOW + HEART_PERIOD_MS);
}

static void every_fifth_asks_for_the_status(void **state)
{
    heart h = ready();
    (void)state;
    for (uint32_t i = 0; i < 14; i++) {
        heart_beat(&h, 700);
        heart_tick(&h, NOW + i * HEART_PERIOD_MS);
        assert_int_equal(polls, (i + 2u) / HEART_POLL);
    }
    assert_int_equal(heartbeats, 14);
    assert_int_equal(requests, 14);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_beat_counts_a_round_and_says_how_long_it_serves),
        cmocka_unit_test(each_tick_counts),
        cmocka_unit_test(the_first_heartbeat_waits_for_the_sensors_silence),
        cmocka_unit_test(a_stall_begins_when_the_round_has_served),
        cmocka_unit_test(a_round_ends_a_stall_whatever_it_serves_for),
        cmocka_unit_test(without_a_round_for_long_no_heartbeat_leaves),
        cmocka_unit_test(heartbeats_keep_their_beat),
        cmocka_unit_test(what_is_not_due_waits),
        cmocka_unit_test(what_cannot_be_sent_stays_due),
        cmocka_unit_test(every_fifth_asks_for_the_status),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
