#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "fake_net.h"
#include "live/contact.h"
#include "live/laser_rules.h"
#include "lum/laser.h"
#include "lum/live/keeper.h"

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

/* The next news of the keeper; 0: none. */
static lum_news_kind next_news(void)
{
    lum_news news = {.struct_size = sizeof news};
    return lum_keeper_next(whole, &news) ? news.kind : NOTHING;
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
    assert_int_equal(answer(UP, SECOND + MS), LUM_NEWS_LASER_CAME_UP);
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
    cmocka_unit_test(off_without_a_status_is_sent_again_once_it_is_seen_up),
    cmocka_unit_test(nor_while_the_command_on_stands),
    cmocka_unit_test(the_answer_to_an_old_off_decides_nothing),
    cmocka_unit_test(what_its_user_asks_does_not_put_off_an_off),
    cmocka_unit_test(an_on_that_is_not_wanted_any_more_is_not_repeated),
    cmocka_unit_test(answers_without_status_are_told_where_no_on_is_judged),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
