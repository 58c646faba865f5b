#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../tools/common/laser_keeper.h"
#include "fake_net.h"
#include "lum/laser.h"

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define UP      LUM_LASER_TLV_CMD_ON
#define REFUSED (UP | LUM_LASER_HEARTBEAT_TIMEOUT)
#define HOT     (UP | LUM_LASER_BOARD_OVER_105)
#define OFF     LUM_LASER_TLV_CMD_OFF

static struct laser_keeper keeper;

static void begin(enum laser_fate fate)
{
    laser_keeper_begin(&keeper, fate, 0);
}

static void send_next(enum laser_request expected, int64_t now_ns)
{
    const enum laser_request next = laser_keeper_next(&keeper);
    assert_int_equal(next, expected);
    assert_int_equal(keeper.request, LASER_ASK_LOOK);
    laser_keeper_sent(&keeper, next, now_ns);
}

static enum laser_news take(lum_sensor_event_kind kind, int64_t now_ns)
{
    const lum_sensor_event event = {.kind = kind};
    return laser_keeper_take(&keeper, &event, now_ns);
}

static enum laser_news take_status(lum_sensor_event_kind kind, uint16_t status,
                                   int64_t now_ns)
{
    const lum_sensor_event event = {
        .kind = kind, .has_status = true, .status = status};
    return laser_keeper_take(&keeper, &event, now_ns);
}

static enum laser_news answer(uint16_t status, int64_t now_ns)
{
    return take_status(LUM_SENSOR_ANSWER, status, now_ns);
}

static lum_sensor *sensor;

/* A session of which no datagram is answered. */
static void open_session(void)
{
    lum_sensor_options options;
    lum_error error;
    fake_reset();
    lum_sensor_options_default(&options);
    assert_int_equal(lum_sensor_open(&options, &sensor, &error), LUM_NET_OK);
}

/* What a datagram asks: a command, or a point for a status; 0: nothing. */
static char name_request(const struct fake_sent *sent)
{
    uint32_t sequence = 0;
    lum_tlv_reader tlvs;
    lum_tlv tlv;
    if (lum_tlv_open(sent->bytes, sent->len, &sequence, &tlvs) != LUM_OK) {
        return 0;
    }
    return lum_tlv_next(&tlvs, &tlv) == LUM_OK ? (char)tlv.value[0] : '.';
}

/* Keeper and session go on for a time. Returns what they asked. */
static const char *run_for(int64_t ns)
{
    static char asked[64];
    const int64_t end_ns = fake.now_ns + ns;
    const size_t from = fake.sent_count;
    size_t count = 0;
    while (fake.now_ns < end_ns) {
        lum_sensor_event event;
        lum_sensor_receive(sensor, fake.now_ns + 50 * MS, &event);
        (void)laser_keeper_take(&keeper, &event, fake.now_ns);
        (void)laser_keeper_tick(&keeper, fake.now_ns);
        laser_keeper_ask(&keeper, sensor, fake.now_ns);
    }
    for (size_t i = from; i < fake.sent_count; i++) {
        asked[count] = name_request(&fake.sent[i]);
        count += asked[count] != 0 ? 1u : 0u;
        assert_true(count < sizeof asked - 1u);
    }
    asked[count] = '\0';
    return asked;
}

static void begin_up(void)
{
    begin(LASER_ASKED);
    send_next(LASER_ASK_ON, 0);
    assert_int_equal(answer(UP, MS), LASER_NO_NEWS);
    assert_int_equal(keeper.fate, LASER_UP);
}

static void assert_left(uint16_t fell, int64_t next_ns)
{
    assert_int_equal(keeper.fate, LASER_DOWN);
    assert_int_equal(keeper.fell, fell);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_OFF);
    assert_int_equal(keeper.next_ns, next_ns);
}

static void a_laser_that_nobody_asked_for_is_only_looked_at(void **state)
{
    (void)state;
    begin(LASER_UNTOUCHED);
    for (int64_t now_ns = 0; now_ns < 5 * SECOND; now_ns += SECOND) {
        assert_int_equal(keeper.next_ns, now_ns);
        send_next(LASER_ASK_LOOK, now_ns);
        assert_int_equal(answer(now_ns < 3 * SECOND ? HOT : UP, now_ns + MS),
                         LASER_NO_NEWS);
    }
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 0), LASER_NO_NEWS);
    assert_int_equal(keeper.fate, LASER_UNTOUCHED);
    assert_true(keeper.has_status);
    assert_int_equal(keeper.status, UP);
    assert_int_equal(keeper.attempts, 0);
}

static void it_is_asked_for_while_heartbeats_may_be_on_their_way(void **state)
{
    int64_t now_ns = 0;
    (void)state;
    begin(LASER_ASKED);
    for (unsigned i = 1; i < 20; i++) {
        send_next(LASER_ASK_ON, now_ns);
        assert_int_equal(answer(REFUSED, now_ns), LASER_NO_NEWS);
        now_ns += 200 * MS;
        assert_int_equal(keeper.next_ns, now_ns);
    }
    send_next(LASER_ASK_ON, now_ns);
    assert_int_equal(keeper.attempts, 20);
    assert_int_equal(answer(REFUSED, now_ns), LASER_STAYS_DOWN);
    assert_left(REFUSED, now_ns);
}

static void what_a_hazard_refuses_is_not_asked_for_again(void **state)
{
    (void)state;
    begin(LASER_ASKED);
    send_next(LASER_ASK_ON, 0);
    assert_int_equal(answer(HOT, MS), LASER_STAYS_DOWN);
    assert_left(HOT, MS);
}

static void an_answer_without_status_is_not_trusted(void **state)
{
    (void)state;
    begin(LASER_ASKED);
    send_next(LASER_ASK_ON, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), LASER_UNSEEN);
    assert_left(0, MS);
}

static void without_an_answer_it_is_given_up_after_5_s(void **state)
{
    const int64_t last_ns = 5 * SECOND - 1;
    (void)state;
    begin(LASER_ASKED);
    send_next(LASER_ASK_ON, 0);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, last_ns), LASER_NO_NEWS);
    send_next(LASER_ASK_ON, last_ns);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, last_ns + 1), LASER_UNANSWERED);
    assert_left(0, last_ns + 1);
}

static void a_session_that_stood_still_switches_off(void **state)
{
    (void)state;
    begin(LASER_ASKED);
    assert_int_equal(laser_keeper_tick(&keeper, 2 * SECOND - 1), LASER_NO_NEWS);
    send_next(LASER_ASK_ON, 2 * SECOND - 1);
    assert_int_equal(laser_keeper_tick(&keeper, 4 * SECOND - 1), LASER_HELD_UP);
    assert_left(0, 4 * SECOND - 1);
    /* what the "on" that was under way brings does not count */
    assert_int_equal(answer(UP, 4 * SECOND), LASER_NO_NEWS);
    assert_left(0, 4 * SECOND - 1);
}

static void what_comes_late_of_an_on_changes_nothing(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin(LASER_ASKED);
        send_next(LASER_ASK_ON, 0);
        assert_int_equal(laser_keeper_tick(&keeper, 2 * SECOND), LASER_HELD_UP);
        assert_int_equal(
            take(i == 0 ? LUM_SENSOR_ANSWER : LUM_SENSOR_NO_ANSWER, 9 * SECOND),
            LASER_NO_NEWS);
        assert_left(0, 2 * SECOND);
    }
}

static void time_before_the_session_does_not_count(void **state)
{
    (void)state;
    laser_keeper_begin(&keeper, LASER_ASKED, 9 * SECOND);
    assert_int_equal(keeper.next_ns, 9 * SECOND);
    assert_int_equal(laser_keeper_tick(&keeper, 9 * SECOND), LASER_NO_NEWS);
    send_next(LASER_ASK_ON, 9 * SECOND);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, 13 * SECOND), LASER_NO_NEWS);
    assert_int_equal(keeper.fate, LASER_ASKED);
}

static void only_a_laser_that_is_asked_for_may_not_stand_still(void **state)
{
    static const enum laser_fate fates[] = {LASER_UNTOUCHED, LASER_UP};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin(fates[i]);
        assert_int_equal(laser_keeper_tick(&keeper, 9 * SECOND), LASER_NO_NEWS);
        assert_int_equal(keeper.fate, fates[i]);
        assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
    }
}

static void short_pauses_do_not_add_up(void **state)
{
    (void)state;
    begin(LASER_ASKED);
    for (int64_t now_ns = 0; now_ns < 9 * SECOND; now_ns += 1500 * MS) {
        assert_int_equal(laser_keeper_tick(&keeper, now_ns), LASER_NO_NEWS);
    }
}

static void a_session_that_waits_is_not_asked_again(void **state)
{
    (void)state;
    open_session();
    laser_keeper_begin(&keeper, LASER_UNTOUCHED, fake.now_ns);
    assert_string_equal(run_for(300 * MS), ".");
    lum_sensor_close(sensor);
}

static void off_does_not_wait_for_an_on_that_is_not_answered(void **state)
{
    (void)state;
    open_session();
    laser_keeper_begin(&keeper, LASER_ASKED, fake.now_ns);
    assert_string_equal(run_for(200 * MS), "u");
    fake.now_ns += 2100 * MS;
    assert_int_equal(laser_keeper_tick(&keeper, fake.now_ns), LASER_HELD_UP);
    assert_true(keeper.held_up_ns >= 2100 * MS);
    laser_keeper_ask(&keeper, sensor, fake.now_ns);
    assert_string_equal(run_for(100 * MS), "d");
    lum_sensor_close(sensor);
}

static void off_does_not_wait_for_a_status_that_is_not_answered(void **state)
{
    const lum_sensor_event alert = {
        .kind = LUM_SENSOR_ALERT, .has_status = true, .status = HOT};
    (void)state;
    open_session();
    laser_keeper_begin(&keeper, LASER_UP, fake.now_ns);
    assert_string_equal(run_for(100 * MS), ".");
    assert_int_equal(laser_keeper_take(&keeper, &alert, fake.now_ns),
                     LASER_WENT_OFF);
    laser_keeper_ask(&keeper, sensor, fake.now_ns);
    assert_string_equal(run_for(300 * MS), "d");
    /* one that is under way is left to the session, which repeats it */
    assert_string_equal(run_for(1200 * MS), "ddd");
    lum_sensor_close(sensor);
}

static void one_that_goes_down_is_switched_off(void **state)
{
    (void)state;
    begin_up();
    send_next(LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(REFUSED, SECOND + MS), LASER_WENT_OFF);
    assert_left(REFUSED, SECOND + MS);
}

static void one_that_was_switched_off_needs_no_other_off(void **state)
{
    (void)state;
    begin_up();
    send_next(LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(OFF, SECOND + MS), LASER_WENT_OFF);
    assert_int_equal(keeper.fell, OFF);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
    assert_int_equal(keeper.next_ns, 2 * SECOND);
}

static void an_alert_of_a_hazard_counts_at_once(void **state)
{
    (void)state;
    begin_up();
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 2 * SECOND),
                     LASER_WENT_OFF);
    assert_left(HOT, 2 * SECOND);
}

static void an_alert_hastens_no_on(void **state)
{
    (void)state;
    begin(LASER_ASKED);
    send_next(LASER_ASK_ON, 0);
    assert_int_equal(answer(REFUSED, MS), LASER_NO_NEWS);
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 2 * MS), LASER_NO_NEWS);
    assert_int_equal(keeper.fate, LASER_ASKED);
    assert_int_equal(keeper.next_ns, 201 * MS);
}

static void command_bits_of_an_alert_are_not_believed(void **state)
{
    const uint16_t old = OFF | LUM_LASER_BOARD_OVER_105;
    (void)state;
    begin_up();
    assert_int_equal(take_status(LUM_SENSOR_ALERT, old, 2 * SECOND),
                     LASER_WENT_OFF);
    assert_left(old, 2 * SECOND);
}

static void off_is_repeated_while_the_command_on_stands(void **state)
{
    static const uint16_t statuses[] = {UP, HOT, REFUSED, HOT | OFF};
    (void)state;
    begin(LASER_DOWN);
    for (unsigned i = 0; i < 4; i++) {
        send_next(LASER_ASK_OFF, i * SECOND);
        assert_int_equal(answer(statuses[i], i * SECOND), LASER_NO_NEWS);
        assert_left(0, i * SECOND + 200 * MS);
    }
    /* a hazard alone brings nothing up */
    send_next(LASER_ASK_OFF, 5 * SECOND);
    assert_int_equal(answer(LUM_LASER_BOARD_OVER_105 | OFF, 5 * SECOND),
                     LASER_NO_NEWS);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
}

static void an_off_that_no_status_showed_is_not_taken_for_done(void **state)
{
    (void)state;
    begin(LASER_DOWN);
    send_next(LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), LASER_NO_NEWS);
    send_next(LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(UP, SECOND + MS), LASER_NO_NEWS);
    assert_left(0, SECOND + MS);
    send_next(LASER_ASK_OFF, SECOND + MS);
    assert_int_equal(take(LUM_SENSOR_ANSWER, SECOND + MS), LASER_NO_NEWS);
    send_next(LASER_ASK_LOOK, 2 * SECOND);
    assert_int_equal(answer(OFF, 2 * SECOND), LASER_NO_NEWS);
    send_next(LASER_ASK_LOOK, 3 * SECOND);
    assert_int_equal(answer(UP, 3 * SECOND), LASER_CAME_UP);
}

static void an_answer_without_status_tells_nothing_of_an_older_one(void **state)
{
    (void)state;
    begin_up();
    keeper.fate = LASER_DOWN;
    send_next(LASER_ASK_LOOK, SECOND);
    assert_int_equal(take(LUM_SENSOR_ANSWER, SECOND), LASER_NO_NEWS);
    assert_int_equal(keeper.fate, LASER_DOWN);
}

static void another_alert_is_asked_about(void **state)
{
    static const uint16_t statuses[] = {UP, OFF, REFUSED};
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        begin_up();
        assert_int_equal(take_status(LUM_SENSOR_ALERT, statuses[i], 300 * MS),
                         LASER_NO_NEWS);
        assert_int_equal(keeper.fate, LASER_UP);
        assert_int_equal(keeper.next_ns, 300 * MS);
    }
    begin_up();
    assert_int_equal(take(LUM_SENSOR_ALERT, 400 * MS), LASER_NO_NEWS);
    assert_int_equal(keeper.next_ns, 400 * MS);
}

static void off_is_sent_until_a_status_shows_it(void **state)
{
    (void)state;
    begin(LASER_DOWN);
    assert_left(0, 0);
    send_next(LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, SECOND), LASER_NO_NEWS);
    send_next(LASER_ASK_OFF, SECOND);
    assert_int_equal(answer(UP, SECOND), LASER_NO_NEWS);
    assert_left(0, SECOND + 200 * MS);
    send_next(LASER_ASK_OFF, SECOND + 200 * MS);
    assert_int_equal(answer(OFF, 2 * SECOND), LASER_NO_NEWS);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
}

static void an_answer_to_off_without_status_is_believed(void **state)
{
    (void)state;
    begin(LASER_DOWN);
    send_next(LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), LASER_NO_NEWS);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
}

static void begin_left(void)
{
    begin(LASER_DOWN);
    send_next(LASER_ASK_OFF, 0);
    assert_int_equal(answer(OFF, MS), LASER_NO_NEWS);
    send_next(LASER_ASK_LOOK, SECOND);
}

static void another_program_may_switch_it_on_again(void **state)
{
    (void)state;
    begin_left();
    assert_int_equal(answer(UP, SECOND + MS), LASER_CAME_UP);
    assert_int_equal(keeper.fate, LASER_UP);
}

static void what_a_hazard_refuses_to_another_program_does_not_stand(
    void **state)
{
    (void)state;
    begin_left();
    assert_int_equal(answer(HOT, SECOND + MS), LASER_NO_NEWS);
    assert_left(0, SECOND + MS);
    begin_left();
    assert_int_equal(answer(HOT | OFF, SECOND + MS), LASER_NO_NEWS);
    assert_left(0, SECOND + MS);
    begin_left();
    assert_int_equal(answer(LUM_LASER_BOARD_OVER_105 | OFF, SECOND + MS),
                     LASER_NO_NEWS);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
    assert_int_equal(answer(REFUSED, SECOND + MS), LASER_NO_NEWS);
    assert_int_equal(laser_keeper_next(&keeper), LASER_ASK_LOOK);
}

static void other_events_change_nothing(void **state)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_IDLE, LUM_SENSOR_CANCELLED, LUM_SENSOR_DATAGRAMS,
        LUM_SENSOR_TIME, LUM_SENSOR_LINK,      LUM_SENSOR_FAILED};
    (void)state;
    begin_up();
    for (unsigned i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        assert_int_equal(take_status(kinds[i], HOT, 5 * SECOND), LASER_NO_NEWS);
        assert_int_equal(keeper.fate, LASER_UP);
        assert_int_equal(keeper.status, UP);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_laser_that_nobody_asked_for_is_only_looked_at),
    cmocka_unit_test(it_is_asked_for_while_heartbeats_may_be_on_their_way),
    cmocka_unit_test(what_a_hazard_refuses_is_not_asked_for_again),
    cmocka_unit_test(an_answer_without_status_is_not_trusted),
    cmocka_unit_test(without_an_answer_it_is_given_up_after_5_s),
    cmocka_unit_test(a_session_that_stood_still_switches_off),
    cmocka_unit_test(what_comes_late_of_an_on_changes_nothing),
    cmocka_unit_test(time_before_the_session_does_not_count),
    cmocka_unit_test(only_a_laser_that_is_asked_for_may_not_stand_still),
    cmocka_unit_test(short_pauses_do_not_add_up),
    cmocka_unit_test(a_session_that_waits_is_not_asked_again),
    cmocka_unit_test(off_does_not_wait_for_an_on_that_is_not_answered),
    cmocka_unit_test(off_does_not_wait_for_a_status_that_is_not_answered),
    cmocka_unit_test(an_alert_hastens_no_on),
    cmocka_unit_test(command_bits_of_an_alert_are_not_believed),
    cmocka_unit_test(off_is_repeated_while_the_command_on_stands),
    cmocka_unit_test(an_off_that_no_status_showed_is_not_taken_for_done),
    cmocka_unit_test(an_answer_without_status_tells_nothing_of_an_older_one),
    cmocka_unit_test(one_that_goes_down_is_switched_off),
    cmocka_unit_test(one_that_was_switched_off_needs_no_other_off),
    cmocka_unit_test(an_alert_of_a_hazard_counts_at_once),
    cmocka_unit_test(another_alert_is_asked_about),
    cmocka_unit_test(off_is_sent_until_a_status_shows_it),
    cmocka_unit_test(an_answer_to_off_without_status_is_believed),
    cmocka_unit_test(another_program_may_switch_it_on_again),
    cmocka_unit_test(what_a_hazard_refuses_to_another_program_does_not_stand),
    cmocka_unit_test(other_events_change_nothing),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
