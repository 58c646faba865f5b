#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fake_net.h"
#include "live/contact.h"
#include "live/laser_rules.h"
#include "lum/group.h"
#include "lum/laser.h"
#include "lum/live/keeper.h"

#include <stdio.h>
#include <string.h>

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define UP      LUM_LASER_TLV_CMD_ON
#define REFUSED (UP | LUM_LASER_HEARTBEAT_TIMEOUT)
#define HOT     (UP | LUM_LASER_BOARD_OVER_105)
#define OFF     LUM_LASER_TLV_CMD_OFF
#define NOTHING ((lum_news_kind)0)

static lum_laser_rules keeper;

static void begin(lum_laser_state state)
{
    keeper = (lum_laser_rules){
        .is_owned = true, .attempts_max = 20, .give_up_ns = 5 * SECOND};
    lum_laser_rules_want(&keeper, state, state == LUM_LASER_LEFT, 0);
}

static void send_next(lum_laser_request expected, int64_t now_ns)
{
    const lum_laser_request next = lum_laser_rules_next(&keeper);
    assert_int_equal(next, expected);
    assert_int_equal(keeper.request, LUM_LASER_ASK_LOOK);
    lum_laser_rules_sent(&keeper, next, now_ns);
}

static lum_news_kind take(lum_sensor_event_kind kind, int64_t now_ns)
{
    const lum_sensor_event event = {.kind = kind};
    return lum_laser_rules_take(&keeper, &event, now_ns);
}

static lum_news_kind take_status(lum_sensor_event_kind kind, uint16_t status,
                                 int64_t now_ns)
{
    const lum_sensor_event event = {
        .kind = kind, .has_status = true, .status = status};
    return lum_laser_rules_take(&keeper, &event, now_ns);
}

static lum_news_kind answer(uint16_t status, int64_t now_ns)
{
    return take_status(LUM_SENSOR_ANSWER, status, now_ns);
}

static lum_sensor *sensor;
static lum_keeper *whole; /* of that session */

/* A session of which no datagram is answered. */
static void open_session(lum_laser_want want)
{
    lum_sensor_options options;
    lum_keeper_options kept;
    lum_error error;
    fake_reset();
    lum_sensor_options_default(&options);
    assert_int_equal(lum_sensor_open(&options, &sensor, &error), LUM_NET_OK);
    lum_keeper_options_default(&kept, &options);
    kept.laser = want;
    kept.owns = true;
    assert_int_equal(lum_keeper_new(&kept, fake.now_ns, &whole, &error), 0);
}

static void close_session(void)
{
    lum_keeper_free(whole);
    lum_sensor_close(sensor);
}

/* What its kind has no use for is 0. */
static void check_unused(const lum_news *news)
{
    if (news->kind == LUM_NEWS_LASER_LEFT || news->kind == LUM_NEWS_HAZARD ||
        news->kind == LUM_NEWS_LASER_IS_OFF || news->kind == LUM_NEWS_TEXT ||
        news->kind == LUM_NEWS_OFF_UNANSWERED || news->kind == LUM_NEWS_MOVED ||
        news->kind == LUM_NEWS_RESTARTED ||
        (news->kind >= LUM_NEWS_ANSWERS && news->kind <= LUM_NEWS_LINK_UP &&
         news->kind != LUM_NEWS_LATE_ANSWERS)) {
        assert_true(news->ns == 0);
    }
}

/* The next news of the keeper; 0: none. */
static lum_news_kind next_news(void)
{
    lum_news news = {.struct_size = sizeof news};
    if (!lum_keeper_next(whole, &news)) {
        return NOTHING;
    }
    check_unused(&news);
    return news.kind;
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
        lum_keeper_take(whole, &event, fake.now_ns);
        lum_keeper_serve(whole, sensor, fake.now_ns);
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
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(answer(UP, MS), LUM_NEWS_LASER_UP);
    assert_int_equal(keeper.state, LUM_LASER_UP);
}

static void assert_left(uint16_t fell, int64_t next_ns)
{
    assert_int_equal(keeper.state, LUM_LASER_LEFT);
    assert_int_equal(keeper.fell, fell);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_OFF);
    assert_int_equal(keeper.next_ns, next_ns);
}

static void a_laser_that_nobody_asked_for_is_only_looked_at(void **state)
{
    (void)state;
    begin(LUM_LASER_UNTOUCHED);
    for (int64_t now_ns = 0; now_ns < 5 * SECOND; now_ns += SECOND) {
        assert_int_equal(keeper.next_ns, now_ns);
        send_next(LUM_LASER_ASK_LOOK, now_ns);
        assert_int_equal(answer(now_ns < 3 * SECOND ? HOT : UP, now_ns + MS),
                         NOTHING);
    }
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 0), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_UNTOUCHED);
    assert_true(keeper.has_status);
    assert_int_equal(keeper.status, UP);
    assert_int_equal(keeper.attempts, 0);
}

static void it_is_asked_for_while_heartbeats_may_be_on_their_way(void **state)
{
    int64_t now_ns = 0;
    (void)state;
    begin(LUM_LASER_ASKED);
    for (unsigned i = 1; i < 20; i++) {
        send_next(LUM_LASER_ASK_ON, now_ns);
        assert_int_equal(answer(REFUSED, now_ns), NOTHING);
        now_ns += 200 * MS;
        assert_int_equal(keeper.next_ns, now_ns);
    }
    send_next(LUM_LASER_ASK_ON, now_ns);
    assert_int_equal(keeper.attempts, 20);
    assert_int_equal(answer(REFUSED, now_ns), LUM_NEWS_LASER_REFUSED);
    assert_left(REFUSED, now_ns);
}

static void what_a_hazard_refuses_is_not_asked_for_again(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(answer(HOT, MS), LUM_NEWS_LASER_REFUSED);
    assert_left(HOT, MS);
}

static void an_answer_without_status_is_not_trusted(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), LUM_NEWS_LASER_UNSEEN);
    assert_left(0, MS);
}

static void without_an_answer_it_is_given_up_after_5_s(void **state)
{
    const int64_t last_ns = 5 * SECOND - 1;
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, last_ns), NOTHING);
    send_next(LUM_LASER_ASK_ON, last_ns);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, last_ns + 1),
                     LUM_NEWS_LASER_UNANSWERED);
    assert_left(0, last_ns + 1);
}

static void a_session_that_stood_still_switches_off(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    assert_int_equal(lum_laser_rules_tick(&keeper, 2 * SECOND - 1), NOTHING);
    send_next(LUM_LASER_ASK_ON, 2 * SECOND - 1);
    assert_int_equal(lum_laser_rules_tick(&keeper, 4 * SECOND - 1),
                     LUM_NEWS_LASER_HELD_UP);
    assert_left(0, 4 * SECOND - 1);
    /* what the "on" that was under way brings does not count */
    assert_int_equal(answer(UP, 4 * SECOND), NOTHING);
    assert_left(0, 4 * SECOND - 1);
}

static void what_comes_late_of_an_on_changes_nothing(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin(LUM_LASER_ASKED);
        send_next(LUM_LASER_ASK_ON, 0);
        assert_int_equal(lum_laser_rules_tick(&keeper, 2 * SECOND),
                         LUM_NEWS_LASER_HELD_UP);
        assert_int_equal(
            take(i == 0 ? LUM_SENSOR_ANSWER : LUM_SENSOR_NO_ANSWER, 9 * SECOND),
            NOTHING);
        assert_left(0, 2 * SECOND);
    }
}

static void time_before_the_session_does_not_count(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    lum_laser_rules_want(&keeper, LUM_LASER_ASKED, false, 9 * SECOND);
    assert_int_equal(keeper.next_ns, 9 * SECOND);
    assert_int_equal(lum_laser_rules_tick(&keeper, 9 * SECOND), NOTHING);
    send_next(LUM_LASER_ASK_ON, 9 * SECOND);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, 13 * SECOND), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_ASKED);
}

static void only_a_laser_that_is_asked_for_may_not_stand_still(void **state)
{
    static const lum_laser_state states[] = {LUM_LASER_UNTOUCHED, LUM_LASER_UP};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin(states[i]);
        assert_int_equal(lum_laser_rules_tick(&keeper, 9 * SECOND), NOTHING);
        assert_int_equal(keeper.state, states[i]);
        assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
    }
}

static void short_pauses_do_not_add_up(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    for (int64_t now_ns = 0; now_ns < 9 * SECOND; now_ns += 1500 * MS) {
        assert_int_equal(lum_laser_rules_tick(&keeper, now_ns), NOTHING);
    }
}

static void a_session_that_waits_is_not_asked_again(void **state)
{
    (void)state;
    open_session(LUM_WANT_LOOK);
    assert_string_equal(run_for(300 * MS), ".");
    close_session();
}

static void off_does_not_wait_for_an_on_that_is_not_answered(void **state)
{
    (void)state;
    open_session(LUM_WANT_ON);
    assert_string_equal(run_for(200 * MS), "u");
    fake.now_ns += 2100 * MS;
    lum_keeper_serve(whole, sensor, fake.now_ns);
    assert_int_equal(next_news(), LUM_NEWS_LASER_HELD_UP);
    assert_string_equal(run_for(100 * MS), "d");
    close_session();
}

static void off_does_not_wait_for_a_status_that_is_not_answered(void **state)
{
    const lum_sensor_event up = {
        .kind = LUM_SENSOR_ANSWER, .has_status = true, .status = UP};
    const lum_sensor_event alert = {
        .kind = LUM_SENSOR_ALERT, .has_status = true, .status = HOT};
    (void)state;
    open_session(LUM_WANT_ON);
    assert_string_equal(run_for(100 * MS), "u");
    lum_sensor_give_up(sensor);
    lum_keeper_take(whole, &up, fake.now_ns);
    assert_int_equal(next_news(), LUM_NEWS_LASER_UP);
    assert_string_equal(run_for(1100 * MS), ".");
    lum_keeper_take(whole, &alert, fake.now_ns);
    assert_int_equal(next_news(), LUM_NEWS_LASER_FELL);
    lum_keeper_serve(whole, sensor, fake.now_ns);
    assert_string_equal(run_for(300 * MS), "d");
    /* one that is under way is left to the session, which repeats it */
    assert_string_equal(run_for(1200 * MS), "ddd");
    close_session();
}

static void one_that_goes_down_is_switched_off(void **state)
{
    (void)state;
    begin_up();
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(REFUSED, SECOND + MS), LUM_NEWS_LASER_FELL);
    assert_left(REFUSED, SECOND + MS);
}

static void one_that_stays_up_is_looked_at(void **state)
{
    (void)state;
    begin_up();
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(UP, SECOND + MS), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_UP);
    assert_int_equal(keeper.next_ns, 2 * SECOND);
}

/* As after a restart: no bit, neither up nor down. */
static void one_that_is_not_shown_up_any_more_is_switched_off(void **state)
{
    (void)state;
    begin_up();
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(0, SECOND + MS), LUM_NEWS_LASER_FELL);
    assert_left(0, SECOND + MS);
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(answer(0, MS), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_ASKED);
}

static void one_that_was_switched_off_needs_no_other_off(void **state)
{
    (void)state;
    begin_up();
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(OFF, SECOND + MS), LUM_NEWS_LASER_FELL);
    assert_int_equal(keeper.fell, OFF);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
    assert_int_equal(keeper.next_ns, 2 * SECOND);
}

static void an_alert_of_a_hazard_counts_at_once(void **state)
{
    (void)state;
    begin_up();
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 2 * SECOND),
                     LUM_NEWS_LASER_FELL);
    assert_left(HOT, 2 * SECOND);
}

static void an_alert_hastens_no_on(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(answer(REFUSED, MS), NOTHING);
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, 2 * MS), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_ASKED);
    assert_int_equal(keeper.next_ns, 201 * MS);
}

static void a_hazard_before_the_answer_to_on_refuses_it(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, MS), NOTHING);
    assert_int_equal(answer(UP, 2 * MS), LUM_NEWS_LASER_REFUSED);
    assert_left(UP | HOT, 2 * MS);
    lum_laser_rules_want(&keeper, LUM_LASER_ASKED, false, SECOND);
    send_next(LUM_LASER_ASK_ON, SECOND);
    assert_int_equal(answer(UP, SECOND), LUM_NEWS_LASER_UP);
}

static void command_bits_of_an_alert_are_not_believed(void **state)
{
    const uint16_t old = OFF | LUM_LASER_BOARD_OVER_105;
    (void)state;
    begin_up();
    assert_int_equal(take_status(LUM_SENSOR_ALERT, old, 2 * SECOND),
                     LUM_NEWS_LASER_FELL);
    assert_left(old, 2 * SECOND);
}

static void off_is_repeated_while_the_command_on_stands(void **state)
{
    static const uint16_t statuses[] = {UP, HOT, REFUSED, HOT | OFF};
    (void)state;
    begin(LUM_LASER_LEFT);
    for (unsigned i = 0; i < 4; i++) {
        send_next(LUM_LASER_ASK_OFF, i * SECOND);
        assert_int_equal(answer(statuses[i], i * SECOND), NOTHING);
        assert_left(0, i * SECOND + 200 * MS);
    }
    /* a hazard alone brings nothing up */
    send_next(LUM_LASER_ASK_OFF, 5 * SECOND);
    assert_int_equal(answer(LUM_LASER_BOARD_OVER_105 | OFF, 5 * SECOND),
                     NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
}

static void an_off_that_no_status_showed_is_not_taken_for_done(void **state)
{
    (void)state;
    begin(LUM_LASER_LEFT);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(UP, SECOND + MS), NOTHING);
    assert_left(0, SECOND + MS);
    send_next(LUM_LASER_ASK_OFF, SECOND + MS);
    assert_int_equal(take(LUM_SENSOR_ANSWER, SECOND + MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, 2 * SECOND);
    assert_int_equal(answer(OFF, 2 * SECOND), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, 3 * SECOND);
    assert_int_equal(answer(UP, 3 * SECOND), LUM_NEWS_LASER_CAME_UP);
}

static void an_answer_without_status_tells_nothing_of_an_older_one(void **state)
{
    (void)state;
    begin_up();
    keeper.state = LUM_LASER_LEFT;
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(take(LUM_SENSOR_ANSWER, SECOND), NOTHING);
    assert_int_equal(keeper.state, LUM_LASER_LEFT);
}

static void another_alert_is_asked_about(void **state)
{
    static const uint16_t statuses[] = {UP, OFF, REFUSED};
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        begin_up();
        assert_int_equal(take_status(LUM_SENSOR_ALERT, statuses[i], 300 * MS),
                         NOTHING);
        assert_int_equal(keeper.state, LUM_LASER_UP);
        assert_int_equal(keeper.next_ns, 300 * MS);
    }
    begin_up();
    assert_int_equal(take(LUM_SENSOR_ALERT, 400 * MS), NOTHING);
    assert_int_equal(keeper.next_ns, 400 * MS);
}

static void off_is_sent_until_a_status_shows_it(void **state)
{
    (void)state;
    begin(LUM_LASER_LEFT);
    assert_left(0, 0);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, SECOND), NOTHING);
    send_next(LUM_LASER_ASK_OFF, SECOND);
    assert_int_equal(answer(UP, SECOND), NOTHING);
    assert_left(0, SECOND + 200 * MS);
    send_next(LUM_LASER_ASK_OFF, SECOND + 200 * MS);
    assert_int_equal(answer(OFF, 2 * SECOND), NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
}

static void an_answer_to_off_without_status_is_believed(void **state)
{
    (void)state;
    begin(LUM_LASER_LEFT);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
}

static void begin_left(void)
{
    begin(LUM_LASER_LEFT);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(answer(OFF, MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, SECOND);
}

static void another_program_may_switch_it_on_again(void **state)
{
    (void)state;
    begin_left();
    assert_int_equal(answer(0, SECOND + MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, 2 * SECOND);
    assert_int_equal(answer(UP, 2 * SECOND + MS), LUM_NEWS_LASER_CAME_UP);
    assert_int_equal(keeper.state, LUM_LASER_UP);
}

static void what_a_hazard_refuses_to_another_program_does_not_stand(
    void **state)
{
    (void)state;
    begin_left();
    assert_int_equal(answer(HOT, SECOND + MS), NOTHING);
    assert_left(0, SECOND + MS);
    begin_left();
    assert_int_equal(answer(HOT | OFF, SECOND + MS), NOTHING);
    assert_left(0, SECOND + MS);
    begin_left();
    assert_int_equal(answer(LUM_LASER_BOARD_OVER_105 | OFF, SECOND + MS),
                     NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
    assert_int_equal(answer(REFUSED, SECOND + MS), NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
}

static lum_news_kind answer_whole(uint16_t status)
{
    const lum_sensor_event event = {
        .kind = LUM_SENSOR_ANSWER, .has_status = true, .status = status};
    lum_sensor_give_up(sensor);
    lum_keeper_take(whole, &event, fake.now_ns);
    return next_news();
}

/* The cause of a fall after pauses, before and after the laser came up. */
static void a_fall_after_a_pause_of_the_program_says_so(void **state)
{
    static const struct {
        int64_t before_ns;
        int64_t pause_ns;
        int64_t after_ns;
        uint16_t status;
        int64_t expected_ns;
    } cases[] = {{0, 4 * SECOND, 500 * MS, OFF, 4 * SECOND},
                 {0, 2 * SECOND, 0, OFF, 2 * SECOND},
                 {0, 2 * SECOND - 1, 0, OFF, 0},
                 {0, 3 * SECOND, 0, HOT, 0},
                 {9 * SECOND, 0, 0, OFF, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[LUM_ERROR_BYTES];
        lum_news news = {.struct_size = sizeof news};
        open_session(LUM_WANT_LOOK);
        fake.now_ns += cases[i].before_ns;
        lum_keeper_want(whole, LUM_WANT_ON, fake.now_ns);
        lum_keeper_serve(whole, sensor, fake.now_ns);
        assert_int_equal(answer_whole(UP), LUM_NEWS_LASER_UP);
        fake.now_ns += cases[i].pause_ns;
        lum_keeper_serve(whole, sensor, fake.now_ns);
        fake.now_ns += cases[i].after_ns;
        const lum_sensor_event down = {.kind = LUM_SENSOR_ANSWER,
                                       .has_status = true,
                                       .status = cases[i].status};
        lum_keeper_take(whole, &down, fake.now_ns);
        do {
            assert_true(lum_keeper_next(whole, &news));
        } while (news.kind != LUM_NEWS_LASER_FELL);
        assert_true(news.ns == cases[i].expected_ns);
        assert_int_equal(strstr(lum_news_tell(&news, text, sizeof text),
                                "sent no heartbeats for") != NULL,
                         news.ns != 0);
        close_session();
    }
}

static void what_the_program_did_not_hear_is_no_silence(void **state)
{
    lum_contact c;
    (void)state;
    lum_contact_begin(&c, 0);
    (void)lum_contact_note_data(&c, 0);
    for (int64_t now_ns = 4 * SECOND; now_ns <= 7 * SECOND;
         now_ns += MS * 500) {
        lum_contact_pass(&c, now_ns);
        assert_int_equal(lum_contact_tick(&c, true, 0, now_ns),
                         now_ns < 7 * SECOND ? NOTHING : LUM_NEWS_SILENT);
    }
}

static void other_events_change_nothing(void **state)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_IDLE, LUM_SENSOR_CANCELLED, LUM_SENSOR_DATAGRAMS,
        LUM_SENSOR_TIME, LUM_SENSOR_LINK,      LUM_SENSOR_FAILED};
    (void)state;
    begin_up();
    for (unsigned i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        assert_int_equal(take_status(kinds[i], HOT, 5 * SECOND), NOTHING);
        assert_int_equal(keeper.state, LUM_LASER_UP);
        assert_int_equal(keeper.status, UP);
    }
}

/* A hazard, "off" without a status, and then it is up all the same. */
static void off_without_a_status_is_sent_again_once_it_is_seen_up(void **state)
{
    (void)state;
    begin_up();
    assert_int_equal(take_status(LUM_SENSOR_ALERT, HOT, SECOND),
                     LUM_NEWS_LASER_FELL);
    send_next(LUM_LASER_ASK_OFF, SECOND);
    assert_int_equal(take(LUM_SENSOR_ANSWER, SECOND + MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, 2 * SECOND);
    assert_int_equal(answer(UP, 2 * SECOND + MS), NOTHING);
    assert_left(HOT, 2 * SECOND + MS);
}

static void nor_while_the_command_on_stands(void **state)
{
    (void)state;
    begin(LUM_LASER_LEFT);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(take(LUM_SENSOR_ANSWER, MS), NOTHING);
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(REFUSED, SECOND + MS), NOTHING);
    assert_left(0, SECOND + MS);
}

static void the_answer_to_an_old_off_decides_nothing(void **state)
{
    static const lum_laser_state states[] = {LUM_LASER_UNTOUCHED,
                                             LUM_LASER_ASKED};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        const lum_sensor_event event = {
            .kind = LUM_SENSOR_ANSWER, .has_status = i < 2, .status = UP};
        begin(LUM_LASER_LEFT);
        send_next(LUM_LASER_ASK_OFF, 0);
        lum_laser_rules_want(&keeper, states[i % 2u], false, MS);
        assert_int_equal(lum_laser_rules_take(&keeper, &event, MS), NOTHING);
        assert_int_equal(keeper.state, states[i % 2u]);
        assert_false(keeper.off_due);
        assert_false(keeper.off_unseen);
    }
}

static void what_its_user_asks_does_not_put_off_an_off(void **state)
{
    (void)state;
    begin(LUM_LASER_LEFT);
    lum_laser_rules_sent(&keeper, LUM_LASER_ASK_OTHER, 10 * MS);
    assert_left(0, 0);
    begin(LUM_LASER_UNTOUCHED);
    lum_laser_rules_sent(&keeper, LUM_LASER_ASK_OTHER, 10 * MS);
    assert_int_equal(keeper.next_ns, SECOND + 10 * MS);
}

static void an_on_that_is_not_wanted_any_more_is_not_repeated(void **state)
{
    static const lum_laser_want wants[] = {LUM_WANT_LOOK, LUM_WANT_GUARD};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        open_session(LUM_WANT_ON);
        assert_string_equal(run_for(100 * MS), "u");
        lum_keeper_want(whole, wants[i], fake.now_ns);
        lum_keeper_serve(whole, sensor, fake.now_ns);
        assert_string_equal(run_for(500 * MS), "..");
        close_session();
    }
}

static void answers_without_status_are_told_where_no_on_is_judged(void **state)
{
    const lum_sensor_event blind = {.kind = LUM_SENSOR_ANSWER};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        open_session(LUM_WANT_ON);
        assert_string_equal(run_for(100 * MS), "u");
        if (i == 1) {
            lum_keeper_want(whole, LUM_WANT_GUARD, fake.now_ns);
        }
        lum_keeper_take(whole, &blind, fake.now_ns);
        assert_int_equal(next_news(),
                         i == 1 ? LUM_NEWS_NO_STATUS : LUM_NEWS_LASER_UNSEEN);
        assert_int_equal(next_news(), NOTHING);
        close_session();
    }
}

/* --- The keeper beside a session --- */

static lum_tlv_writer tlvs;
static uint8_t tlv_bytes[700];

static void begin_tlvs(void)
{
    assert_int_equal(lum_tlv_begin(&tlvs, tlv_bytes, sizeof tlv_bytes, 1),
                     LUM_OK);
}

/* What came, with the TLVs that were added. */
static void give(lum_sensor_event event)
{
    uint32_t number = 0;
    if (tlvs.len > 0) {
        assert_int_equal(
            lum_tlv_open(tlv_bytes, tlvs.len, &number, &event.tlvs), LUM_OK);
    }
    tlvs.len = 0;
    lum_keeper_take(whole, &event, fake.now_ns);
}

static void give_status(lum_sensor_event_kind kind, uint16_t status)
{
    give(
        (lum_sensor_event){.kind = kind, .has_status = true, .status = status});
}

/* Time passes, and the program goes on. */
static void wait_for(int64_t ns)
{
    for (const int64_t end_ns = fake.now_ns + ns; fake.now_ns < end_ns;) {
        fake.now_ns += SECOND / 2;
        give((lum_sensor_event){.kind = LUM_SENSOR_IDLE});
    }
}

static void give_link(bool is_up)
{
    lum_sensor_event event = {
        .kind = LUM_SENSOR_LINK, .is_up = is_up, .has_status = true};
    memset(event.error.text, 'e', sizeof event.error.text - 1u);
    give(event);
}

static lum_news take_news(lum_news_kind kind)
{
    lum_news news = {.struct_size = sizeof news};
    assert_true(lum_keeper_next(whole, &news));
    assert_int_equal(news.kind, kind);
    check_unused(&news);
    return news;
}

static lum_keeper_view look(void)
{
    lum_keeper_view view = {.struct_size = sizeof view};
    assert_int_equal(lum_keeper_look(whole, &view), LUM_OK);
    return view;
}

static void assert_standing(lum_news_kind first, lum_news_kind second,
                            lum_news_kind third)
{
    lum_news news[4] = {{.struct_size = sizeof news[0]}};
    const size_t count = lum_keeper_standing(whole, fake.now_ns, news,
                                             sizeof news / sizeof *news);
    const lum_news_kind kinds[] = {first, second, third, NOTHING};
    for (size_t i = 0; i <= count; i++) {
        assert_int_equal(kinds[i], i < count ? news[i].kind : NOTHING);
        check_unused(&news[i]);
    }
}

/* The kind; 0: none. */
static lum_news_kind darkness(void)
{
    lum_news news = {.struct_size = sizeof news};
    if (!lum_keeper_darkness(whole, &news)) {
        return NOTHING;
    }
    assert_int_not_equal(news.kind, NOTHING);
    return news.kind;
}

static void a_keeper_is_made_of_the_session_s_options(void **state)
{
    lum_sensor_options session;
    lum_keeper_options options;
    lum_error error;
    lum_keeper_view small = {.struct_size = 0};
    lum_news news = {.struct_size = 0};
    char name[] = "eth0";
    (void)state;
    lum_sensor_options_default(&session);
    session.owns = true;
    session.interface_name = name;
    session.sensor.address++;
    lum_keeper_options_default(&options, &session);
    assert_int_equal(options.give_up_ms, 5000);
    assert_int_equal(options.attempts, 20);
    assert_int_equal(options.laser, LUM_WANT_LOOK);
    assert_true(options.owns);
    assert_int_equal(lum_keeper_new(&options, SECOND, &whole, &error), 0);
    name[3] = '1';
    fake.now_ns = SECOND;
    give_link(true);
    assert_int_equal(lum_keeper_look(whole, &small), LUM_E_VALUE);
    assert_false(lum_keeper_next(whole, &news)); /* and it is not lost */
    news = take_news(LUM_NEWS_LINK_UP);
    assert_string_equal(news.interface_name, "eth0");
    assert_int_equal(news.sensor.address, session.sensor.address);
    assert_int_equal(news.tlv_status, 2);
    assert_int_equal(news.to.address, 0);
    lum_keeper_free(whole);
    lum_keeper_free(NULL);
    options.interface_name = "";
    assert_int_equal(lum_keeper_new(&options, SECOND, &whole, &error), 0);
    give_link(true);
    assert_string_equal(take_news(LUM_NEWS_LINK_UP).interface_name, "");
    lum_keeper_free(whole);
    options.struct_size = 0;
    assert_int_equal(lum_keeper_new(&options, SECOND, &whole, &error), -1);
    assert_non_null(strstr(error.text, "struct_size"));
}

static void of_a_full_queue_the_oldest_are_lost(void **state)
{
    lum_sensor_event event = {.kind = LUM_SENSOR_LINK};
    char *text = event.error.text;
    (void)state;
    open_session(LUM_WANT_LOOK);
    for (unsigned told = 0; told < 220; told += 20) {
        for (unsigned n = 0; n < told; n++) {
            (void)snprintf(text, sizeof event.error.text, "%u", n);
            give(event);
        }
        unsigned n = told > LUM_KEEPER_NEWS ? told - LUM_KEEPER_NEWS : 0;
        for (; n < told; n++) {
            (void)snprintf(text, sizeof event.error.text, "%u", n);
            assert_string_equal(take_news(LUM_NEWS_LINK_DOWN).text, text);
        }
        assert_int_equal(next_news(), NOTHING);
    }
    give_link(false);
    assert_int_equal(strlen(take_news(LUM_NEWS_LINK_DOWN).text),
                     LUM_NEWS_TEXT_BYTES - 1u);
    give_link(true);
    assert_string_equal(take_news(LUM_NEWS_LINK_UP).text, "");
    close_session();
}

static void texts_of_the_sensor_are_told_up_to_a_limit(void **state)
{
    static const char long_text[300] = {'\n', '~', '\x7f', ' ', '\x1f'};
    (void)state;
    open_session(LUM_WANT_LOOK);
    for (unsigned i = 1; i <= LUM_KEEPER_TEXTS; i++) {
        begin_tlvs();
        assert_int_equal(lum_tlv_add(&tlvs, 1, "no text", 7), LUM_OK);
        assert_int_equal(lum_tlv_add(&tlvs, 3, long_text, i == 1 ? 300 : 5),
                         LUM_OK);
        give((lum_sensor_event){.kind = i % 2u == 0 ? LUM_SENSOR_ALERT
                                                    : LUM_SENSOR_ANSWER,
                                .has_status = true});
        const lum_news news = take_news(LUM_NEWS_TEXT);
        assert_memory_equal(news.text, "?~? ?", 5);
        assert_int_equal(strlen(news.text), i == 1 ? 228 : i < 20 ? 5 : 5 + 27);
        assert_string_equal(news.text + (i < 20 ? strlen(news.text) : 5),
                            i < 20 ? "" : " (more of this is not told)");
    }
    begin_tlvs();
    assert_int_equal(lum_tlv_add(&tlvs, 3, "more", 4), LUM_OK);
    give((lum_sensor_event){.kind = LUM_SENSOR_ALERT});
    assert_int_equal(next_news(), NOTHING);
    close_session();
}

static void texts_leave_room_for_other_news(void **state)
{
    (void)state;
    open_session(LUM_WANT_LOOK);
    for (unsigned i = 0; i < 30; i++) {
        give_link(true);
    }
    begin_tlvs();
    assert_int_equal(lum_tlv_add(&tlvs, 3, "one", 3), LUM_OK);
    assert_int_equal(lum_tlv_add(&tlvs, 3, "two", 3), LUM_OK);
    assert_int_equal(lum_tlv_add(&tlvs, 3, "three", 5), LUM_OK);
    give((lum_sensor_event){.kind = LUM_SENSOR_ALERT});
    for (unsigned i = 0; i < 30; i++) {
        (void)take_news(LUM_NEWS_LINK_UP);
    }
    assert_string_equal(take_news(LUM_NEWS_TEXT).text, "one");
    assert_string_equal(take_news(LUM_NEWS_TEXT).text, "two");
    assert_int_equal(next_news(), NOTHING);
    close_session();
}

static void a_hazard_is_told_when_it_begins(void **state)
{
    const uint16_t cold = LUM_LASER_HEARTBEAT_TIMEOUT;
    (void)state;
    open_session(LUM_WANT_LOOK);
    give_status(LUM_SENSOR_ANSWER, HOT | cold); /* no heartbeat has come yet */
    assert_int_equal(take_news(LUM_NEWS_HAZARD).status,
                     LUM_LASER_BOARD_OVER_105);
    fake.now_ns += SECOND - 1;
    give_status(LUM_SENSOR_ANSWER, HOT | cold);
    give_status(LUM_SENSOR_ALERT, 0x1ff);
    assert_int_equal(next_news(), NOTHING);
    fake.now_ns++;
    give_status(LUM_SENSOR_ANSWER, HOT | cold);
    assert_int_equal(take_news(LUM_NEWS_HAZARD).status, cold);
    fake.now_ns += 2 * SECOND; /* a pause; the sensor begins anew */
    give_status(LUM_SENSOR_ANSWER, HOT | cold);
    fake.now_ns += SECOND;
    give_status(LUM_SENSOR_ANSWER, HOT | cold);
    give_status(LUM_SENSOR_ANSWER, OFF | cold);
    assert_int_equal(next_news(), NOTHING);
    give_status(LUM_SENSOR_ANSWER, HOT);
    assert_int_equal(take_news(LUM_NEWS_HAZARD).status,
                     LUM_LASER_BOARD_OVER_105);
    give_status(LUM_SENSOR_ANSWER, UINT16_MAX);
    assert_int_equal(take_news(LUM_NEWS_HAZARD).status, 0x1df);
    assert_int_equal(next_news(), NOTHING);
    assert_int_equal(lum_laser_rules_hazards(UINT16_MAX), 0x1ef);
    close_session();
}

static void without_an_owner_no_heartbeats_are_no_hazard(void **state)
{
    lum_error error;
    lum_sensor_options session;
    lum_keeper_options options;
    (void)state;
    fake_reset();
    lum_sensor_options_default(&session);
    lum_keeper_options_default(&options, &session);
    for (unsigned i = 0; i < 3; i++) {
        options.owns = i == 2;
        assert_int_equal(lum_keeper_new(&options, SECOND, &whole, &error), 0);
        fake.now_ns = SECOND;
        wait_for(8 * SECOND);
        lum_keeper_note_owner(whole, i == 1);
        give_status(LUM_SENSOR_ANSWER, REFUSED);
        assert_int_equal(next_news(), i == 0 ? NOTHING : LUM_NEWS_HAZARD);
        give_status(LUM_SENSOR_ANSWER, 1);
        assert_standing(LUM_NEWS_NO_DATA_YET, LUM_NEWS_LASER_IS_OFF,
                        LUM_NEWS_HAZARD);
        give_status(LUM_SENSOR_ANSWER, OFF);
        assert_int_equal(darkness(), LUM_NEWS_LASER_IS_OFF);
        lum_keeper_free(whole);
    }
}

static void attempts_and_time_of_an_on_are_the_options_s(void **state)
{
    lum_error error;
    lum_sensor_options session;
    lum_keeper_options options;
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        open_session(LUM_WANT_LOOK);
        lum_keeper_free(whole);
        lum_sensor_options_default(&session);
        lum_keeper_options_default(&options, &session);
        options.owns = true;
        options.laser = LUM_WANT_ON;
        options.attempts = i;
        options.give_up_ms = 1000;
        assert_int_equal(lum_keeper_new(&options, fake.now_ns, &whole, &error),
                         0);
        for (unsigned n = 1; n <= (i == 2 ? 2u : 1u); n++) {
            assert_string_equal(run_for(250 * MS), "u");
            lum_sensor_give_up(sensor);
            give_status(LUM_SENSOR_ANSWER, REFUSED);
            assert_int_equal(next_news(),
                             n < i ? NOTHING : LUM_NEWS_LASER_REFUSED);
        }
        lum_keeper_want(whole, LUM_WANT_ON, fake.now_ns);
        const int64_t begin_ns = fake.now_ns;
        assert_string_equal(run_for(100 * MS), "u");
        fake.now_ns = begin_ns + SECOND - (i == 0);
        give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER, .tries = 3});
        assert_int_equal(next_news(),
                         i == 0 ? NOTHING : LUM_NEWS_LASER_UNANSWERED);
        close_session();
    }
}

static void bit_0_is_a_hazard_like_others(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin(LUM_LASER_ASKED);
        keeper.is_owned = i == 0;
        send_next(LUM_LASER_ASK_ON, 0);
        assert_int_equal(answer(UP | 1, MS), LUM_NEWS_LASER_REFUSED);
    }
    begin_up();
    send_next(LUM_LASER_ASK_LOOK, SECOND);
    assert_int_equal(answer(OFF | 1, SECOND), LUM_NEWS_LASER_FELL);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
    begin(LUM_LASER_LEFT);
    send_next(LUM_LASER_ASK_OFF, 0);
    assert_int_equal(answer(OFF | 1, MS), NOTHING);
    assert_int_equal(lum_laser_rules_next(&keeper), LUM_LASER_ASK_LOOK);
    assert_int_equal(keeper.next_ns, SECOND);
}

static void another_want_begins_anew(void **state)
{
    (void)state;
    begin(LUM_LASER_ASKED);
    send_next(LUM_LASER_ASK_ON, 0);
    keeper.sent = 4;
    keeper.has_status = true;
    keeper.status = UP;
    lum_laser_rules_want(&keeper, LUM_LASER_ASKED, false, MS);
    assert_int_equal(keeper.attempts, 0);
    assert_int_equal(keeper.sent, 0);
    assert_true(keeper.has_status);
    assert_int_equal(keeper.status, UP);
    keeper.off_unseen = true;
    lum_laser_rules_want(&keeper, LUM_LASER_UNTOUCHED, false, MS);
    assert_false(keeper.off_unseen);
}

static void only_a_pause_of_an_owner_explains_a_fall_for_a_while(void **state)
{
    static const struct {
        bool owns;
        int64_t after_ns;
        int64_t expected_ns;
    } cases[] = {{true, 2 * SECOND - 1, 3 * SECOND},
                 {true, 2 * SECOND, 0},
                 {false, SECOND, 0}};
    lum_error error;
    lum_sensor_options session;
    lum_keeper_options options;
    (void)state;
    fake_reset();
    fake.now_ns = 10 * SECOND;
    lum_sensor_options_default(&session);
    lum_keeper_options_default(&options, &session);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lum_news news = {.struct_size = sizeof news};
        options.owns = cases[i].owns;
        assert_int_equal(lum_keeper_new(&options, fake.now_ns, &whole, &error),
                         0);
        wait_for(SECOND);
        lum_keeper_want(whole, LUM_WANT_GUARD, fake.now_ns);
        lum_keeper_lend(whole, fake.now_ns);
        give_status(LUM_SENSOR_ANSWER, UP);
        (void)take_news(LUM_NEWS_LASER_CAME_UP);
        assert_int_equal(lum_keeper_standing(whole, fake.now_ns, &news, 1), 0);
        wait_for(SECOND / 2);
        fake.now_ns += 3 * SECOND;
        give((lum_sensor_event){.kind = LUM_SENSOR_IDLE});
        wait_for(SECOND / 2);
        give_status(LUM_SENSOR_ANSWER, UP);
        fake.now_ns += cases[i].after_ns - SECOND / 2;
        give_status(LUM_SENSOR_ANSWER, OFF);
        assert_true(take_news(LUM_NEWS_LASER_FELL).ns == cases[i].expected_ns);
        lum_keeper_free(whole);
    }
}

/* Refused for want of heartbeats, at one attempt. */
static void without_an_owner_on_is_given_up_at_once(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        begin(LUM_LASER_ASKED);
        keeper.is_owned = i > 0;
        keeper.attempts_max = i == 2 ? 1 : 20;
        send_next(LUM_LASER_ASK_ON, 0);
        assert_int_equal(answer(REFUSED, MS),
                         i == 1 ? NOTHING : LUM_NEWS_LASER_REFUSED);
    }
}

static void a_text_of_commands_is_what_is_wanted(void **state)
{
    static const struct {
        const char *text;
        lum_laser_state laser;
        bool is_off_due;
        lum_news_kind then; /* where a status shows it up */
    } cases[] = {{"50p", LUM_LASER_UNTOUCHED, false, NOTHING},
                 {"d", LUM_LASER_LEFT, true, NOTHING},
                 {"d u", LUM_LASER_ASKED, false, LUM_NEWS_LASER_UP},
                 {"u 50p d", LUM_LASER_LEFT, true, NOTHING},
                 {"u", LUM_LASER_ASKED, false, LUM_NEWS_LASER_UP}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        open_session(LUM_WANT_LOOK);
        assert_int_equal(
            lum_keeper_command(whole, sensor, cases[i].text, fake.now_ns),
            LUM_OK);
        assert_int_equal(look().laser, cases[i].laser);
        assert_int_equal(look().is_off_due, cases[i].is_off_due);
        /* one at a time: what is not sent is not wanted */
        assert_int_equal(lum_keeper_command(whole, sensor,
                                            cases[i].is_off_due ? "u" : "d",
                                            fake.now_ns),
                         LUM_E_VALUE);
        assert_int_equal(look().laser, cases[i].laser);
        give_status(LUM_SENSOR_ANSWER, UP);
        assert_int_equal(next_news(), cases[i].then);
        assert_int_equal(look().is_off_due, cases[i].is_off_due);
        close_session();
    }
}

static void only_an_off_that_has_no_answer_is_told(void **state)
{
    static const char *const texts[] = {"u", "d", "50p"};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        open_session(LUM_WANT_LOOK);
        if (i < 3) {
            assert_int_equal(
                lum_keeper_command(whole, sensor, texts[i], fake.now_ns),
                LUM_OK);
        } else {
            lum_keeper_lend(whole, fake.now_ns);
        }
        give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER});
        assert_int_equal(next_news(),
                         i == 1 ? LUM_NEWS_OFF_UNANSWERED : NOTHING);
        assert_int_equal(next_news(), NOTHING);
        lum_keeper_want(whole, LUM_WANT_OFF, fake.now_ns);
        lum_sensor_give_up(sensor);
        assert_string_equal(run_for(100 * MS), "d");
        close_session();
    }
}

static void nothing_puts_off_an_off(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        open_session(LUM_WANT_OFF);
        assert_string_equal(run_for(100 * MS), "d");
        lum_sensor_give_up(sensor);
        give_status(LUM_SENSOR_ANSWER, UP);
        if (i == 0) {
            assert_int_equal(
                lum_keeper_command(whole, sensor, "50p", fake.now_ns), LUM_OK);
        } else {
            lum_keeper_lend(whole, fake.now_ns);
        }
        lum_sensor_give_up(sensor);
        assert_string_equal(run_for(300 * MS), "d");
        close_session();
    }
}

static void a_request_of_its_user_answers_nothing_of_the_keeper(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        open_session(LUM_WANT_ON);
        assert_string_equal(run_for(100 * MS), "u");
        lum_sensor_give_up(sensor);
        if (i == 1) {
            lum_keeper_want(whole, LUM_WANT_GUARD, fake.now_ns);
        }
        lum_keeper_lend(whole, fake.now_ns);
        give_status(LUM_SENSOR_ANSWER, UP);
        assert_int_equal(next_news(),
                         i == 1 ? LUM_NEWS_LASER_CAME_UP : NOTHING);
        assert_int_equal(look().laser, i == 1 ? LUM_LASER_UP : LUM_LASER_ASKED);
        close_session();
    }
}

static void off_without_an_answer_is_told_once(void **state)
{
    const lum_sensor_event none = {.kind = LUM_SENSOR_NO_ANSWER};
    (void)state;
    open_session(LUM_WANT_OFF);
    assert_string_equal(run_for(5 * SECOND), "ddddddddddddd");
    (void)take_news(LUM_NEWS_OFF_UNANSWERED);
    assert_int_equal(next_news(), LUM_NEWS_NO_ANSWER);
    assert_int_equal(next_news(), LUM_NEWS_NO_ANSWER_YET);
    assert_true(look().is_unheard);
    assert_standing(LUM_NEWS_NO_ANSWER_YET, LUM_NEWS_OFF_UNANSWERED, NOTHING);
    give_status(LUM_SENSOR_ANSWER, UP);
    (void)take_news(LUM_NEWS_ANSWERS);
    assert_string_equal(run_for(300 * MS), "d");
    lum_sensor_give_up(sensor);
    give(none);
    (void)take_news(LUM_NEWS_OFF_UNANSWERED);
    lum_keeper_want(whole, LUM_WANT_OFF, fake.now_ns);
    assert_string_equal(run_for(100 * MS), "d");
    assert_int_equal(next_news(), LUM_NEWS_NO_ANSWER);
    lum_sensor_give_up(sensor);
    give(none);
    (void)take_news(LUM_NEWS_OFF_UNANSWERED);
    lum_keeper_want(whole, LUM_WANT_LOOK, fake.now_ns);
    assert_string_equal(run_for(100 * MS), ".");
    give(none);
    assert_int_equal(next_news(), NOTHING);
    close_session();
}

static size_t data_packet(uint8_t bytes[64], uint64_t clock_us)
{
    lum_layout layout;
    size_t len = 0;
    const lum_group group = {
        .clock_raw = clock_us, .tag = LUM_TAG_RANGES, .num_samples = 1};
    lum_layout_default(&layout);
    memset(bytes, 0, 64);
    assert_int_equal(lum_group_encode(&layout, &group, bytes, 64, &len),
                     LUM_OK);
    return len + LUM_SAMPLE_BYTES;
}

/* Datagrams of a session: kinds is '.' data, 'x' malformed, 't' of a type and
 * 'g' of a tag that are not known, 'a' an answer, 'f' no magic. */
static void give_datagrams(const char *kinds, uint64_t clock_us)
{
    uint8_t bytes[4][64];
    lum_received datagrams[4];
    const size_t count = strlen(kinds);
    lum_received *first = datagrams + 4 - count; /* nothing is behind them */
    for (size_t i = 0; i < count; i++) {
        uint8_t *out = bytes[i];
        size_t len = data_packet(out, clock_us);
        switch (kinds[i]) {
        case 'x':
            len--;
            break;
        case 't':
            out[8] = 99;
            break;
        case 'g':
            out[12] = 99;
            break;
        case 'a':
            lum_header_encode(out, LUM_TYPE_TLV);
            break;
        case 'f':
            out[0]++;
            break;
        default:
            break;
        }
        first[i] =
            (lum_received){.bytes = out, .len = len, .utc_ns = fake.now_ns};
    }
    give((lum_sensor_event){.kind = LUM_SENSOR_DATAGRAMS,
                            .datagrams = first,
                            .datagram_count = count});
}

static void give_data(void)
{
    give_datagrams(".", (uint64_t)fake.now_ns / 1000u);
}

static void data_is_found_among_datagrams(void **state)
{
    static const char *const unknown[] = {"x", "t", "g", "ax", "at"};
    (void)state;
    for (size_t i = 0; i < 5; i++) {
        open_session(LUM_WANT_LOOK);
        give_datagrams("af", 1);
        assert_false(look().has_unknown);
        give_datagrams(unknown[i], 1);
        assert_true(look().has_unknown);
        assert_false(look().has_data);
        close_session();
    }
    open_session(LUM_WANT_LOOK);
    wait_for(3 * SECOND);
    lum_keeper_serve(whole, sensor, fake.now_ns);
    assert_true(take_news(LUM_NEWS_NO_ANSWER_YET).ns == 3 * SECOND);
    assert_standing(LUM_NEWS_NO_ANSWER_YET, NOTHING, NOTHING);
    assert_false(look().has_data);
    const int64_t first_ns = fake.now_ns;
    give_datagrams("a.x", SECOND / 1000);
    assert_true(look().has_data);
    assert_false(look().has_unknown);
    fake.now_ns += SECOND / 2;
    give_datagrams(".", SECOND / 1000);
    assert_true(look().first_data_ns == first_ns);
    assert_true(look().data_ns == fake.now_ns);
    wait_for(4 * SECOND);
    lum_keeper_serve(whole, sensor, fake.now_ns);
    assert_true(take_news(LUM_NEWS_SILENT).ns == 4 * SECOND);
    assert_true(look().data_ns == first_ns + SECOND / 2);
    assert_true(look().is_silent);
    give_datagrams(".", 0);
    assert_true(take_news(LUM_NEWS_BACK).ns == 4 * SECOND);
    assert_false(look().is_silent);
    fake.now_ns += SECOND;
    give_datagrams("..", SECOND / 1000);
    (void)take_news(LUM_NEWS_RESTARTED);
    assert_int_equal(next_news(), NOTHING);
    assert_true(look().data_ns == fake.now_ns);
    assert_true(look().first_data_ns == first_ns);
    close_session();
}

static void what_holds_is_shown_by_its_weight(void **state)
{
    lum_news unset = {.struct_size = 0};
    lum_news one[2] = {{.struct_size = sizeof one[0]},
                       {.struct_size = sizeof one[0], .status = 7}};
    (void)state;
    open_session(LUM_WANT_LOOK);
    assert_standing(NOTHING, NOTHING, NOTHING);
    assert_int_equal(darkness(), NOTHING);
    give_status(LUM_SENSOR_ANSWER, OFF);
    assert_standing(LUM_NEWS_LASER_IS_OFF, NOTHING, NOTHING);
    assert_int_equal(darkness(), LUM_NEWS_LASER_IS_OFF);
    assert_int_equal(lum_keeper_standing(whole, fake.now_ns, one, 1), 1);
    assert_int_equal(one[0].kind, LUM_NEWS_LASER_IS_OFF);
    assert_int_equal(one[0].status, OFF);
    give_status(LUM_SENSOR_ANSWER, HOT);
    assert_false(lum_keeper_darkness(whole, &unset));
    assert_standing(LUM_NEWS_LASER_IS_OFF, LUM_NEWS_HAZARD, NOTHING);
    assert_int_equal(darkness(), LUM_NEWS_HAZARD);
    give_link(false);
    assert_standing(LUM_NEWS_LINK_DOWN, LUM_NEWS_LASER_IS_OFF, LUM_NEWS_HAZARD);
    give((lum_sensor_event){.kind = LUM_SENSOR_IDLE});
    /* no more than there is room for */
    assert_int_equal(lum_keeper_standing(whole, fake.now_ns, one, 1), 1);
    assert_int_equal(one[0].kind, LUM_NEWS_LINK_DOWN);
    assert_int_equal(strlen(one[0].text), LUM_NEWS_TEXT_BYTES - 1u);
    assert_int_equal(one[1].status, 7);
    assert_int_equal(lum_keeper_standing(whole, fake.now_ns, one, 0), 0);
    give_link(true);
    give_status(LUM_SENSOR_ANSWER, UP);
    assert_standing(NOTHING, NOTHING, NOTHING);
    assert_int_equal(darkness(), NOTHING);
    give_status(LUM_SENSOR_ANSWER, HOT);
    /* without data for a while no more than that */
    give_data();
    wait_for(3 * SECOND);
    assert_standing(LUM_NEWS_SILENT, NOTHING, NOTHING);
    give_status(LUM_SENSOR_ANSWER, HOT);
    assert_standing(LUM_NEWS_DATA_STOPPED, NOTHING, NOTHING);
    give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER});
    assert_true(look().is_unheard);
    give_data();
    assert_standing(LUM_NEWS_UNHEARD, NOTHING, NOTHING);
    close_session();
}

static void a_laser_that_was_left_is_shown(void **state)
{
    lum_news news[2] = {{.struct_size = sizeof news[0]}};
    (void)state;
    open_session(LUM_WANT_OFF);
    assert_standing(LUM_NEWS_LASER_LEFT, NOTHING, NOTHING);
    (void)lum_keeper_standing(whole, fake.now_ns, news, 2);
    assert_true(news[0].was_away); /* it is being switched off */
    assert_int_equal(darkness(), NOTHING);
    assert_string_equal(run_for(100 * MS), "d");
    give_status(LUM_SENSOR_ALERT, OFF); /* is no status of the keeper */
    assert_int_equal(darkness(), NOTHING);
    give((lum_sensor_event){.kind = LUM_SENSOR_ANSWER});
    (void)take_news(LUM_NEWS_NO_STATUS);
    assert_true(look().is_off_due);
    give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER});
    assert_standing(LUM_NEWS_OFF_UNANSWERED, NOTHING, NOTHING);
    give((lum_sensor_event){.kind = LUM_SENSOR_ANSWER});
    (void)lum_keeper_standing(whole, fake.now_ns, news, 2);
    assert_true(news[0].was_away);
    give_status(LUM_SENSOR_ANSWER, OFF);
    (void)lum_keeper_standing(whole, fake.now_ns, news, 2);
    assert_false(news[0].was_away);
    assert_int_equal(darkness(), LUM_NEWS_LASER_LEFT);
    /* one that fell says so as long as it is left */
    lum_keeper_want(whole, LUM_WANT_OFF, fake.now_ns);
    give_status(LUM_SENSOR_ANSWER, UP);
    assert_int_equal(darkness(), NOTHING);
    give_status(LUM_SENSOR_ANSWER, OFF);
    lum_keeper_want(whole, LUM_WANT_ON, fake.now_ns);
    assert_standing(NOTHING, NOTHING, NOTHING);
    assert_int_equal(darkness(), NOTHING);
    lum_sensor_give_up(sensor); /* that was answered */
    assert_string_equal(run_for(100 * MS), "u");
    give_status(LUM_SENSOR_ANSWER, UP);
    assert_int_equal(take_news(LUM_NEWS_LASER_UP).status, UP);
    give_data();
    fake.now_ns += SECOND;
    give_status(LUM_SENSOR_ANSWER, OFF);
    assert_true(take_news(LUM_NEWS_LASER_FELL).was_away);
    give_data();
    assert_standing(LUM_NEWS_LASER_FELL, NOTHING, NOTHING);
    (void)lum_keeper_standing(whole, fake.now_ns, news, 2);
    assert_int_equal(news[0].status, OFF);
    assert_true(news[0].was_away);
    assert_int_equal(darkness(), LUM_NEWS_LASER_FELL);
    give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER});
    assert_standing(LUM_NEWS_UNHEARD, NOTHING, NOTHING);
    close_session();
}

static void news_of_the_laser_have_their_numbers(void **state)
{
    (void)state;
    open_session(LUM_WANT_ON);
    assert_string_equal(run_for(6300 * MS), "uuuuuuuuuuuuuuud");
    (void)take_news(LUM_NEWS_NO_ANSWER);
    (void)take_news(LUM_NEWS_NO_ANSWER_YET);
    assert_int_equal(take_news(LUM_NEWS_LASER_UNANSWERED).tries, 15);
    lum_keeper_want(whole, LUM_WANT_ON, fake.now_ns);
    fake.now_ns += 2500 * MS;
    lum_keeper_serve(whole, sensor, fake.now_ns);
    assert_true(take_news(LUM_NEWS_LASER_HELD_UP).ns == 2500 * MS);
    lum_keeper_want(whole, LUM_WANT_LOOK, fake.now_ns);
    lum_keeper_want(whole, LUM_WANT_GUARD, fake.now_ns);
    lum_keeper_lend(whole, fake.now_ns);
    give_status(LUM_SENSOR_ANSWER, UP);
    (void)take_news(LUM_NEWS_LASER_CAME_UP);
    (void)take_news(LUM_NEWS_ANSWERS);
    give_status(LUM_SENSOR_ALERT, HOT);
    assert_int_equal(take_news(LUM_NEWS_LASER_FELL).status, HOT);
    assert_int_equal(look().status, UP);
    close_session();
}

static void a_sensor_that_moved_is_told_with_its_address(void **state)
{
    uint8_t bytes[64];
    const lum_endpoint to = {0x0a2a0063, LUM_PORT};
    const size_t len = data_packet(bytes, 1);
    (void)state;
    open_session(LUM_WANT_LOOK);
    for (unsigned i = 0; i < LUM_SENSOR_MOVED_COUNT; i++) {
        fake_arrive(fake.now_ns, to, bytes, len);
    }
    (void)run_for(100 * MS);
    assert_int_equal(take_news(LUM_NEWS_MOVED).to.address, to.address);
    lum_keeper_end(whole, sensor, 100, 0, NULL);
    assert_int_equal(take_news(LUM_NEWS_ENDED_UNKNOWN).to.address, to.address);
    close_session();
}

/* Late ones are told from none by the session's count of them. */
static void answers_that_are_late_are_told(void **state)
{
    uint8_t bytes[64];
    lum_sensor_event event;
    lum_tlv_writer w;
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        open_session(LUM_WANT_LOOK);
        assert_string_equal(run_for(100 * MS), ".");
        const struct fake_sent sent = fake.sent[fake.sent_count - 1u];
        uint32_t number = 0;
        lum_tlv_reader reader;
        assert_int_equal(lum_tlv_open(sent.bytes, sent.len, &number, &reader),
                         LUM_OK);
        lum_sensor_give_up(sensor);
        give((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER});
        assert_int_equal(lum_tlv_begin(&w, bytes, sizeof bytes, number),
                         LUM_OK);
        assert_int_equal(lum_tlv_add_u16(&w, 2, UP), LUM_OK);
        size_t len = w.len;
        if (i == 0) {
            len = data_packet(bytes, 1);
        }
        fake_arrive(fake.now_ns, sent.to, bytes, len);
        lum_sensor_receive(sensor, fake.now_ns + 300 * MS, &event);
        lum_keeper_serve(whole, sensor, fake.now_ns);
        assert_int_equal(next_news(),
                         i == 0 ? LUM_NEWS_NO_ANSWER : LUM_NEWS_LATE_ANSWERS);
        close_session();
    }
}

/* A send stops the program for so long that a request is not sent again. */
static void stop_at_send(const struct fake_sent *sent)
{
    (void)sent;
    fake.now_ns += 3 * SECOND;
}

static void an_end_goes_on_after_a_standstill(void **state)
{
    (void)state;
    open_session(LUM_WANT_LOOK);
    fake.on_send = stop_at_send;
    assert_int_equal(lum_keeper_end(whole, sensor, 5000, 0, NULL),
                     LUM_LASER_OFF_UNKNOWN);
    fake.on_send = NULL;
    assert_int_equal(fake.sent_count, 2);
    close_session();
}

static uint16_t end_status;
static bool end_has_status;

static void answer_each(const struct fake_sent *sent)
{
    uint8_t bytes[32];
    uint32_t number = 0;
    lum_tlv_reader reader;
    lum_tlv_writer w;
    if (lum_tlv_open(sent->bytes, sent->len, &number, &reader) == LUM_OK) {
        assert_int_equal(lum_tlv_begin(&w, bytes, sizeof bytes, number),
                         LUM_OK);
        assert_int_equal(
            lum_tlv_add_u16(&w, end_has_status ? 2 : 9, end_status), LUM_OK);
        fake_arrive(sent->ns, sent->to, bytes, w.len);
    }
}

static void each_end_is_told(void **state)
{
    static const struct {
        uint16_t status;
        bool has_status;
        lum_laser_off off;
        lum_news_kind last;
        bool goes_on;
    } cases[] = {
        {OFF, true, LUM_LASER_OFF_SEEN, LUM_NEWS_ENDED_OFF, false},
        {1, true, LUM_LASER_OFF_SEEN, LUM_NEWS_ENDED_OFF, false},
        {UP | 1, true, LUM_LASER_OFF_REFUSED, LUM_NEWS_ENDED_IN_EFFECT, true},
        {UP, true, LUM_LASER_OFF_REFUSED, LUM_NEWS_ENDED_ON, true},
        {HOT, true, LUM_LASER_OFF_REFUSED, LUM_NEWS_ENDED_IN_EFFECT, true},
        {0, false, LUM_LASER_OFF_UNSEEN, LUM_NEWS_ENDED_UNSEEN, false}};
    (void)state;
    for (size_t i = 0; i < 12; i++) {
        const bool is_last = i < 6;
        const lum_news_kind kind = !is_last && cases[i % 6u].goes_on
                                       ? LUM_NEWS_OFF_GOES_ON
                                       : cases[i % 6u].last;
        open_session(LUM_WANT_ON);
        assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
        end_status = cases[i % 6u].status;
        end_has_status = cases[i % 6u].has_status;
        fake.on_send = answer_each;
        assert_int_equal(
            lum_keeper_end(whole, sensor, 1000, is_last ? 0 : 7000, NULL),
            cases[i % 6u].off);
        fake.on_send = NULL;
        /* a status that shows it down is looked at once more */
        if (lum_laser_is_down(cases[i % 6u].status)) {
            assert_int_equal(name_request(&fake.sent[0]), 'd');
            assert_int_equal(name_request(&fake.sent[1]), '.');
            assert_true(fake.sent[1].ns - fake.sent[0].ns == 300 * MS);
        }
        const lum_news news = take_news(kind);
        assert_int_equal(news.status, cases[i % 6u].status);
        assert_int_equal(news.tries, cases[i % 6u].goes_on);
        assert_true(news.ns == (is_last ? 0 : 7 * SECOND));
        assert_true(news.is_owner);
        assert_int_equal(look().has_status, cases[i % 6u].has_status);
        assert_int_equal(look().laser, LUM_LASER_LEFT);
        assert_int_equal(look().is_off_due,
                         cases[i % 6u].off != LUM_LASER_OFF_SEEN);
        close_session();
    }
}

/* Only the command itself is answered. */
static void answer_commands(const struct fake_sent *sent)
{
    if (name_request(sent) == 'd') {
        answer_each(sent);
    }
}

static void an_off_that_is_not_seen_twice_begins_again(void **state)
{
    (void)state;
    open_session(LUM_WANT_LOOK);
    end_status = OFF;
    end_has_status = true;
    fake.on_send = answer_commands;
    const int64_t begin_ns = fake.now_ns;
    assert_int_equal(lum_sensor_laser_off(sensor, 2320, NULL, NULL),
                     LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(name_request(&fake.sent[fake.sent_count - 1u]), '.');
    size_t last = fake.sent_count;
    while (name_request(&fake.sent[--last]) != 'd') {
    }
    assert_true(fake.sent[last].ns - begin_ns == 2300 * MS);
    fake.on_send = NULL;
    close_session();
}

static void an_off_that_is_not_answered_ends_in_time(void **state)
{
    (void)state;
    open_session(LUM_WANT_LOOK);
    const int64_t begin_ns = fake.now_ns;
    assert_int_equal(lum_sensor_laser_off(sensor, 320, NULL, NULL),
                     LUM_LASER_OFF_UNKNOWN);
    assert_true(fake.now_ns - begin_ns == 320 * MS);
    close_session();
}

static void an_off_changes_nothing_else_of_the_session(void **state)
{
    lum_sensor_event event;
    lum_error error;
    (void)state;
    open_session(LUM_WANT_LOOK);
    end_status = OFF;
    end_has_status = true;
    fake.send = LUM_NET_FAILED; /* before it, and not told yet */
    assert_int_equal(lum_sensor_set_ip(sensor, 0x0a2a0063, &error),
                     LUM_NET_FAILED);
    fake.send = LUM_NET_OK;
    fake.on_send = answer_each;
    assert_int_equal(lum_sensor_laser_off(sensor, 1000, NULL, NULL),
                     LUM_LASER_OFF_SEEN);
    fake.on_send = NULL;
    lum_sensor_receive(sensor, fake.now_ns, &event);
    assert_int_equal(event.kind, LUM_SENSOR_IDLE);
    close_session();
}

static void without_a_session_nothing_is_known_of_the_end(void **state)
{
    (void)state;
    open_session(LUM_WANT_ON);
    give_status(LUM_SENSOR_ANSWER, UP);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(lum_keeper_end(whole, NULL, 1000, i * 7000u, NULL),
                         LUM_LASER_OFF_UNKNOWN);
        const lum_news news =
            take_news(i == 0 ? LUM_NEWS_ENDED_UNKNOWN : LUM_NEWS_OFF_GOES_ON);
        assert_int_equal(news.tries, 0);
        assert_int_equal(news.to.address, 0);
        assert_true(look().is_off_due);
    }
    assert_string_equal(run_for(100 * MS), "d");
    close_session();
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
    cmocka_unit_test(a_fall_after_a_pause_of_the_program_says_so),
    cmocka_unit_test(what_the_program_did_not_hear_is_no_silence),
    cmocka_unit_test(a_session_that_waits_is_not_asked_again),
    cmocka_unit_test(off_does_not_wait_for_an_on_that_is_not_answered),
    cmocka_unit_test(off_does_not_wait_for_a_status_that_is_not_answered),
    cmocka_unit_test(an_alert_hastens_no_on),
    cmocka_unit_test(a_hazard_before_the_answer_to_on_refuses_it),
    cmocka_unit_test(command_bits_of_an_alert_are_not_believed),
    cmocka_unit_test(off_is_repeated_while_the_command_on_stands),
    cmocka_unit_test(an_off_that_no_status_showed_is_not_taken_for_done),
    cmocka_unit_test(an_answer_without_status_tells_nothing_of_an_older_one),
    cmocka_unit_test(one_that_goes_down_is_switched_off),
    cmocka_unit_test(one_that_stays_up_is_looked_at),
    cmocka_unit_test(one_that_is_not_shown_up_any_more_is_switched_off),
    cmocka_unit_test(one_that_was_switched_off_needs_no_other_off),
    cmocka_unit_test(an_alert_of_a_hazard_counts_at_once),
    cmocka_unit_test(another_alert_is_asked_about),
    cmocka_unit_test(off_is_sent_until_a_status_shows_it),
    cmocka_unit_test(an_answer_to_off_without_status_is_believed),
    cmocka_unit_test(another_program_may_switch_it_on_again),
    cmocka_unit_test(what_a_hazard_refuses_to_another_program_does_not_stand),
    cmocka_unit_test(other_events_change_nothing),
    cmocka_unit_test(off_without_a_status_is_sent_again_once_it_is_seen_up),
    cmocka_unit_test(nor_while_the_command_on_stands),
    cmocka_unit_test(the_answer_to_an_old_off_decides_nothing),
    cmocka_unit_test(what_its_user_asks_does_not_put_off_an_off),
    cmocka_unit_test(an_on_that_is_not_wanted_any_more_is_not_repeated),
    cmocka_unit_test(answers_without_status_are_told_where_no_on_is_judged),
    cmocka_unit_test(a_keeper_is_made_of_the_session_s_options),
    cmocka_unit_test(of_a_full_queue_the_oldest_are_lost),
    cmocka_unit_test(texts_of_the_sensor_are_told_up_to_a_limit),
    cmocka_unit_test(texts_leave_room_for_other_news),
    cmocka_unit_test(a_hazard_is_told_when_it_begins),
    cmocka_unit_test(without_an_owner_no_heartbeats_are_no_hazard),
    cmocka_unit_test(without_an_owner_on_is_given_up_at_once),
    cmocka_unit_test(a_text_of_commands_is_what_is_wanted),
    cmocka_unit_test(a_request_of_its_user_answers_nothing_of_the_keeper),
    cmocka_unit_test(off_without_an_answer_is_told_once),
    cmocka_unit_test(data_is_found_among_datagrams),
    cmocka_unit_test(what_holds_is_shown_by_its_weight),
    cmocka_unit_test(a_laser_that_was_left_is_shown),
    cmocka_unit_test(news_of_the_laser_have_their_numbers),
    cmocka_unit_test(a_sensor_that_moved_is_told_with_its_address),
    cmocka_unit_test(each_end_is_told),
    cmocka_unit_test(an_end_goes_on_after_a_standstill),
    cmocka_unit_test(an_off_changes_nothing_else_of_the_session),
    cmocka_unit_test(without_a_session_nothing_is_known_of_the_end),
    cmocka_unit_test(attempts_and_time_of_an_on_are_the_options_s),
    cmocka_unit_test(bit_0_is_a_hazard_like_others),
    cmocka_unit_test(another_want_begins_anew),
    cmocka_unit_test(only_an_off_that_has_no_answer_is_told),
    cmocka_unit_test(nothing_puts_off_an_off),
    cmocka_unit_test(answers_that_are_late_are_told),
    cmocka_unit_test(an_off_that_is_not_seen_twice_begins_again),
    cmocka_unit_test(an_off_that_is_not_answered_ends_in_time),
    cmocka_unit_test(only_a_pause_of_an_owner_explains_a_fall_for_a_while),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
