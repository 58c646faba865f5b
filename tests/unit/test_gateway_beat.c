#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"

#include "lum/wire.h"

static size_t count_sent(const struct rig *r, uint8_t type)
{
    size_t n = 0;
    for (size_t i = 0; i < r->sent_count; i++) {
        n += r->sent[i].type == type;
    }
    return n;
}

static uint32_t longest_pause(const struct rig *r)
{
    uint32_t longest = 0;
    for (size_t i = 1; i < r->sent_count; i++) {
        const uint32_t pause = r->sent[i].ms - r->sent[i - 1u].ms;
        longest = pause > longest ? pause : longest;
    }
    return longest;
}

static void five_heartbeats_a_second_leave_across_a_wrap(void **state)
{
    static const uint32_t starts[] = {0, UINT32_MAX - 5000u,
                                      UINT32_MAX / 2u - 5000u, UINT32_MAX};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct rig *const r = rig_at(starts[i]);
        run(r, HEART_SILENCE_MS + 10000u, 10);
        assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 1 + 50);
        assert_int_equal(r->gateway.heart.sent, 1 + 50);
        assert_int_equal(longest_pause(r), 200);
        rig_free(r);
    }
}

static void a_beat_keeps_its_pace_where_ticks_do_not_fit_it(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 30);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 1 + 50);
    rig_free(r);
}

static void a_slow_tick_makes_no_burst(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 6000u);
    size_t before;
    (void)state;
    run(r, 4u * 800u, 800);
    assert_int_equal(r->sent_count, 0);
    run(r, 8000, 800);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 10);
    assert_int_equal(longest_pause(r), 800);
    before = count_sent(r, LUM_TYPE_HEARTBEAT);
    run(r, 200, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), before + 1u);
    rig_free(r);
}

static void the_status_is_asked_for_once_a_second(void **state)
{
    struct rig *const r = rig_at(0);
    uint32_t polls = 0;
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_TLV), 1 + 10);
    for (size_t i = 0; i < r->sent_count; i++) {
        if (r->sent[i].type == LUM_TYPE_TLV) {
            assert_int_equal(r->sent[i].sequence, r->sent[i].ms);
            assert_int_equal(r->sent[i].ms, HEART_SILENCE_MS + 1000u * polls);
            polls++;
        }
    }
    rig_free(r);
}

static void the_clock_is_asked_for_with_each_heartbeat(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 8000u);
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_TIMESTAMP), 1 + 50);
    for (size_t i = 0; i < r->sent_count; i++) {
        if (r->sent[i].type == LUM_TYPE_TIMESTAMP) {
            assert_int_equal(r->sent[i].sequence, r->sent[i].ms);
            assert_int_equal(r->sent[i - 1u].type, LUM_TYPE_HEARTBEAT);
        }
    }
    rig_free(r);
}

static void a_heartbeat_that_was_refused_is_tried_again(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    run(r, HEART_SILENCE_MS + 1000u, 10);
    r->refuses = true;
    run(r, 300, 10);
    assert_int_equal(r->gateway.heart.failed, 11);
    r->refuses = false;
    run(r, 10, 10);
    assert_int_equal(r->sent[r->sent_count - 1u].ms, r->now);
    assert_true(longest_pause(r) < 1000);
    rig_free(r);
}

/* By the clock, what was due half its range ago is yet to come. */
static void a_heartbeat_is_tried_again_after_weeks_of_refusals(void **state)
{
    struct rig *const r = rig_at(0);
    size_t sent;
    (void)state;
    run(r, 5000, 10);
    sent = r->sent_count;
    r->refuses = true;
    run(r, UINT32_MAX / 16u * 11u, UINT32_MAX / 16u);
    r->refuses = false;
    run(r, 10, 10);
    assert_true(r->sent_count > sent);
    rig_free(r);
}

static void nothing_is_sent_before_the_first_round(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 3000u);
    (void)state;
    hang(r, 10000);
    assert_int_equal(r->sent_count, 0);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    run(r, 20, 10);
    assert_true(r->sent_count > 0);
    rig_free(r);
}

/* So that a board in a loop of resets keeps no laser on. */
static void nothing_is_sent_until_the_sensor_has_timed_out(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 2000u);
    (void)state;
    assert_true(HEART_SILENCE_MS > 3000u);
    run(r, HEART_SILENCE_MS - 1u, 1);
    assert_int_equal(r->sent_count, 0);
    run(r, 1, 1);
    assert_true(r->sent_count > 0);
    rig_free(r);
}

static void heartbeats_end_when_the_main_loop_hangs(void **state)
{
    struct rig *const r = rig_going(UINT32_MAX - 5000u);
    const uint32_t hung = r->now;
    size_t sent;
    (void)state;
    hang(r, HEART_STALL_MS + 10u);
    sent = r->sent_count;
    assert_true(r->sent[sent - 1u].ms - hung <= HEART_STALL_MS);
    assert_true(r->sent[sent - 1u].ms - hung > HEART_STALL_MS - 300u);
    hang(r, 60000);
    assert_int_equal(r->sent_count, sent);
    rig_free(r);
}

/* The newest line that is out is older by those that are open. A round was seen
 * by the tick that follows it. */
static void a_hang_stops_when_what_was_seen_is_old(void **state)
{
    static const struct {
        uint32_t silence, hold, wait;
    } rows[] = {
        {SILENCE, 6000, SILENCE - 2u * STEP},
        {2000, 6000, 2000 - 2u * STEP},
        {2040, 6000, 1990},
        {60000, 6000, 2000},
        {60000, 3000, 2000},
        {60000, 2000, 2000 - (FRAME + STEP)}, /* the newest whole look */
    };
    (void)state;
    for (unsigned i = 0; i < 6; i++) {
        struct rig *const r = rig_new();
        r->config.silence_ms = rows[i].silence;
        r->config.hold_ms = rows[i].hold;
        assert_int_equal(rig_init(r), LUM_OK);
        tell_clock(r, 0, sensor_clock(r));
        pass(r, 8000, BOTH);
        next_frame(r);
        pass(r, 2u * STEP, BOTH);
        hang(r, rows[i].wait);
        assert_int_equal(reasons(r), 0);
        hang(r, 10);
        assert_int_equal(reasons(r), GATEWAY_STALLED);
        rig_free(r);
    }
}

/* No tick watches the main loop then, however long it goes well. */
static void a_stall_lasts_while_there_are_no_ticks(void **state)
{
    struct rig *const r = rig_informed(0);
    (void)state;
    for (uint32_t t = 0; t < 4u * HOLD; t += STEP) {
        r->now += STEP;
        show(r, BOTH, FAR_TOF, 1);
        assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    }
    pass(r, STEP, BOTH);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    pass(r, 2u * HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

/* The tick comes between a decision and the end of its round. */
static void a_stall_that_no_decision_saw_is_held(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    hang(r, SILENCE + 10u);
    heart_beat(&r->gateway.heart, SILENCE);
    hang(r, 10);
    assert_int_equal(heart_stalls(&r->gateway.heart) % 2u, 0);
    assert_int_equal(reasons(r), GATEWAY_STALLED);
    pass(r, HOLD, BOTH);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    assert_int_equal(reasons(r) & GATEWAY_OBJECT, 0);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r) & GATEWAY_STALLED, 0);
    pass(r, 2u * HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void the_watchdog_is_kicked_only_while_the_timer_goes_on(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 5; i++) {
        (void)gateway_receive(&r->gateway, r->now);
        assert_false(gateway_may_kick(&r->gateway));
    }
    for (unsigned i = 0; i < 5; i++) {
        run(r, 10, 10);
        assert_true(gateway_may_kick(&r->gateway));
        assert_false(gateway_may_kick(&r->gateway));
    }
    rig_free(r);
}

static void a_hang_lasts_beyond_a_wrap_of_the_clock(void **state)
{
    struct rig *const r = rig_going(0);
    size_t sent;
    (void)state;
    hang(r, 3000);
    sent = r->sent_count;
    for (unsigned i = 0; i < 40; i++) {
        r->now += UINT32_MAX / 16u;
        gateway_tick(&r->gateway, r->now);
    }
    assert_int_equal(r->sent_count, sent);
    assert_int_equal(reasons(r), GATEWAY_STALLED);
    pass(r, 2u * STEP, 0);
    assert_true(r->sent_count > sent);
    rig_free(r);
}

static void a_main_loop_that_comes_back_sends_again_and_is_held(void **state)
{
    struct rig *const r = rig_going(0);
    size_t sent;
    (void)state;
    hang(r, 5000);
    sent = count_sent(r, LUM_TYPE_HEARTBEAT);
    pass(r, STEP, BOTH);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    pass(r, STEP, BOTH);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), sent + 1u);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    pass(r, 2u * FRAME + HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

/* So that neither side takes a count for one that it has seen. */
static void each_count_goes_up_by_one(void **state)
{
    struct rig *const r = rig_at(0);
    const heart *const h = &r->gateway.heart;
    (void)state;
    gateway_tick(&r->gateway, r->now);
    for (uint32_t i = 1; i < 6; i++) {
        gateway_tick(&r->gateway, r->now);
        assert_int_equal(h->ticks, i + 1u);
        (void)gateway_receive(&r->gateway, r->now);
        assert_int_equal(h->rounds, i);
        assert_int_equal(heart_stalls(h), i == 1 ? 1 : 2);
    }
    hang(r, SILENCE + 20u);
    assert_int_equal(heart_stalls(h), 3);
    run(r, 20, 10);
    assert_int_equal(heart_stalls(h), 4);
    rig_free(r);
}

/* What is blind anyway has nothing that could grow old in a slow round. */
static void a_slow_round_is_no_stall_while_nothing_is_seen(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        hang(r, SILENCE - 50u);
        (void)gateway_receive(&r->gateway, r->now);
    }
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    hang(r, SILENCE + 10u);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    rig_free(r);
}

/* The eye whose view ends first is not the one checked last. */
static void a_hang_stops_when_either_eye_is_old(void **state)
{
    static const unsigned alone[] = {BLUE, GREEN};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct rig *const r = rig_going(0);
        pass(r, 200, alone[i]);
        hang(r, SILENCE - 2u * STEP - 200u);
        assert_int_equal(reasons(r), 0);
        hang(r, 10);
        assert_int_equal(reasons(r), GATEWAY_STALLED);
        rig_free(r);
    }
}

/* What the eyes that have to be heard have shown, the shorter of both. */
static uint32_t served(struct rig *r, unsigned eyes, int64_t blue_ms,
                       int64_t green_ms, int64_t whole_ms)
{
    r->gateway.config.eyes = (uint8_t)eyes;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        look *const l = &r->gateway.looks[eye];
        l->point_ms = r->now - (eye == LUM_EYE_BLUE ? blue_ms : green_ms);
        l->whole_ms = r->now - whole_ms;
    }
    (void)gateway_receive(&r->gateway, r->now);
    return r->gateway.heart.lasts_ms;
}

static void a_round_serves_as_long_as_the_eye_that_ends_first(void **state)
{
    struct rig *const r = rig_informed(5000);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(served(r, BOTH, 100, 200, 0), SILENCE - 200u);
    assert_int_equal(served(r, BOTH, 300, 200, 0), SILENCE - 300u);
    assert_int_equal(served(r, BLUE, 100, 200, 0), SILENCE - 100u);
    assert_int_equal(served(r, GREEN, 300, 200, 0), SILENCE - 200u);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD - 100u), 100);
    assert_int_equal(served(r, BOTH, SILENCE - 1u, 0, 0), 1);
    /* and when nothing serves, a sign of life does */
    assert_int_equal(served(r, BOTH, SILENCE, 0, 0), SILENCE);
    assert_int_equal(served(r, BOTH, SILENCE + 1u, 0, 0), SILENCE);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD), SILENCE);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD + 1u), SILENCE);
    rig_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(five_heartbeats_a_second_leave_across_a_wrap),
        cmocka_unit_test(a_beat_keeps_its_pace_where_ticks_do_not_fit_it),
        cmocka_unit_test(a_slow_tick_makes_no_burst),
        cmocka_unit_test(the_status_is_asked_for_once_a_second),
        cmocka_unit_test(the_clock_is_asked_for_with_each_heartbeat),
        cmocka_unit_test(a_heartbeat_that_was_refused_is_tried_again),
        cmocka_unit_test(a_heartbeat_is_tried_again_after_weeks_of_refusals),
        cmocka_unit_test(nothing_is_sent_before_the_first_round),
        cmocka_unit_test(nothing_is_sent_until_the_sensor_has_timed_out),
        cmocka_unit_test(heartbeats_end_when_the_main_loop_hangs),
        cmocka_unit_test(a_hang_stops_when_what_was_seen_is_old),
        cmocka_unit_test(a_stall_lasts_while_there_are_no_ticks),
        cmocka_unit_test(a_stall_that_no_decision_saw_is_held),
        cmocka_unit_test(the_watchdog_is_kicked_only_while_the_timer_goes_on),
        cmocka_unit_test(a_hang_lasts_beyond_a_wrap_of_the_clock),
        cmocka_unit_test(a_main_loop_that_comes_back_sends_again_and_is_held),
        cmocka_unit_test(each_count_goes_up_by_one),
        cmocka_unit_test(a_slow_round_is_no_stall_while_nothing_is_seen),
        cmocka_unit_test(a_hang_stops_when_either_eye_is_old),
        cmocka_unit_test(a_round_serves_as_long_as_the_eye_that_ends_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
