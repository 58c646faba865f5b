/* The rules for a laser, told as stories, and what else a laser session does
 * beside a session of a network that is moved by hand. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fake_net.h"
#include "lum/group.h"
#include "lum/laser.h"
#include "lum/live/laser_session.h"
#include "net/session.h"

#include <stdio.h>
#include <string.h>

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define HEAT    LUM_LASER_BOARD_OVER_105
#define COLD    LUM_LASER_HEARTBEAT_TIMEOUT
#define UP      LUM_LASER_TLV_CMD_ON
#define OFF     LUM_LASER_TLV_CMD_OFF
#define REFUSED (UP | COLD)
#define HOT     (UP | HEAT)
#define NOTHING ((lum_news_kind)0)

static lum_sensor *sensor;
static lum_laser_session *laser; /* beside that session */
static lum_laser_session_options options;

/* A session of which no datagram is answered, and its usual options. */
static void open_session(void)
{
    lum_sensor_options session;
    lum_error error;
    lum_laser_session_free(laser);
    laser = NULL;
    lum_sensor_close(sensor);
    fake_reset();
    lum_sensor_options_default(&session);
    assert_int_equal(lum_sensor_open(&session, &sensor, &error), LUM_NET_OK);
    lum_laser_session_options_default(&options, &session);
    options.owns = true;
}

static void begin(void)
{
    lum_error error;
    assert_int_equal(
        lum_laser_session_new(&options, fake.now_ns, &laser, &error), 0);
}

static void begin_with(lum_laser_want want)
{
    open_session();
    options.laser = want;
    begin();
}

static void want(lum_laser_want wanted)
{
    lum_laser_session_want(laser, wanted, fake.now_ns);
}

/* What a datagram asks: a command, or a point for a status; 0: nothing. */
static char name_request(const uint8_t *bytes, size_t len)
{
    uint32_t sequence = 0;
    lum_tlv_reader tlvs;
    lum_tlv tlv;
    if (lum_tlv_open(bytes, len, &sequence, &tlvs) != LUM_OK) {
        return 0;
    }
    return lum_tlv_next(&tlvs, &tlv) == LUM_OK ? (char)tlv.value[0] : '.';
}

/* What is asked when the laser session is served; 0: nothing. */
static char serve(void)
{
    const lum_exchange *x = &sensor->exchange;
    const uint64_t issued = x->issued;
    lum_laser_session_serve(laser, sensor, fake.now_ns);
    return x->issued == issued ? 0 : name_request(x->packet, x->packet_len);
}

/* What a session's event, or its user, does. */
typedef enum what {
    END, /* of a story */
    IDLE,
    ANSWER,
    BLIND, /* an answer without a status */
    ALERT,
    BLIND_ALERT,
    NO_ANSWER,
    LINK_DOWN,
    LINK_UP,
    DATA,
    PAUSE, /* 3 s without any */
    SERVED,
    WANT, /* another lum_laser_want, in the place of a status */
    LEND, /* a request of the program itself */
    ALONE /* without heartbeats, from now on */
} what;

static void give(lum_sensor_event event)
{
    lum_laser_session_take(laser, &event, fake.now_ns);
}

/* The session's event; a request that is under way ends with its answer. */
static void hear(what heard, uint16_t status)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_IDLE,      LUM_SENSOR_IDLE,  LUM_SENSOR_ANSWER,
        LUM_SENSOR_ANSWER,    LUM_SENSOR_ALERT, LUM_SENSOR_ALERT,
        LUM_SENSOR_NO_ANSWER, LUM_SENSOR_LINK,  LUM_SENSOR_LINK};
    lum_sensor_event event = {.kind = kinds[heard],
                              .has_status =
                                  heard != BLIND && heard != BLIND_ALERT,
                              .status = status,
                              .tries = 4,
                              .is_up = heard == LINK_UP};
    memset(event.error.text, 'e',
           heard == LINK_DOWN ? LUM_ERROR_BYTES - 1u : 0);
    if (heard == ANSWER || heard == BLIND || heard == NO_ANSWER) {
        lum_sensor_give_up(sensor);
    }
    give(event);
}

/* Datagrams of a session: kinds is '.' data, 'x' malformed, 't' of a type and
 * 'g' of a tag that are not known, 'a' an answer, 'f' no magic. */
static void give_datagrams(const char *kinds, uint64_t clock_us)
{
    uint8_t bytes[4][64] = {{0}};
    lum_received datagrams[4];
    lum_layout layout;
    const lum_group group = {
        .clock_raw = clock_us, .tag = LUM_TAG_RANGES, .num_samples = 1};
    const size_t count = strlen(kinds);
    lum_received *first = datagrams + 4 - count; /* nothing is behind them */
    lum_layout_default(&layout);
    for (size_t i = 0; i < count; i++) {
        uint8_t *out = bytes[i];
        const char kind = kinds[i];
        size_t len = 0;
        assert_int_equal(lum_group_encode(&layout, &group, out, 64, &len),
                         LUM_OK);
        len += LUM_SAMPLE_BYTES - (kind == 'x');
        out[8] = kind == 't' ? 99 : out[8];
        out[12] = kind == 'g' ? 99 : out[12];
        out[0] = (uint8_t)(out[0] + (kind == 'f'));
        if (kind == 'a') {
            lum_header_encode(out, LUM_TYPE_TLV);
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

/* Time passes, and the program goes on. */
static void wait_for(int64_t ns)
{
    for (const int64_t end_ns = fake.now_ns + ns; fake.now_ns < end_ns;) {
        fake.now_ns += SECOND / 2;
        hear(IDLE, 0);
    }
}

static void happen(what happened, uint16_t status)
{
    if (happened == DATA) {
        give_data();
    } else if (happened == PAUSE) {
        wait_for(3 * SECOND);
    } else if (happened == SERVED) {
        (void)serve();
    } else if (happened == WANT) {
        want((lum_laser_want)status);
    } else if (happened == LEND) {
        lum_laser_session_lend(laser, fake.now_ns);
    } else if (happened == ALONE) {
        lum_laser_session_note_owner(laser, false);
    } else {
        hear(happened, status);
    }
}

/* Of the others, what its kind has no use for is 0. */
static bool has_time(lum_news_kind kind)
{
    return kind <= LUM_NEWS_LASER_CAME_UP ||
           (kind >= LUM_NEWS_NO_ANSWER_YET && kind <= LUM_NEWS_BACK) ||
           kind == LUM_NEWS_UNHEARD || kind == LUM_NEWS_NO_ANSWER ||
           kind == LUM_NEWS_LATE_ANSWERS || kind >= LUM_NEWS_OFF_GOES_ON;
}

/* The next news; of kind 0: there is none. */
static lum_news next_news(void)
{
    lum_news news = {.struct_size = sizeof news};
    if (!lum_laser_session_next(laser, &news)) {
        news.kind = NOTHING;
    }
    assert_true(has_time(news.kind) || news.ns == 0);
    return news;
}

static lum_news take_news(lum_news_kind kind)
{
    const lum_news news = next_news();
    assert_int_equal(news.kind, kind);
    return news;
}

/* The next of a kind, whatever else is told before it. */
static lum_news find_news(lum_news_kind kind)
{
    lum_news news = next_news();
    while (news.kind != kind) {
        assert_int_not_equal(news.kind, NOTHING);
        news = next_news();
    }
    return news;
}

/* --- Stories of a laser, whose "on" is tried three times --- */

/* What happens, how the laser session takes it, and what it asks when it is
 * served after it. */
typedef struct step {
    int64_t ns;
    what what;
    uint16_t status; /* also that of the news */
    char asked;
    lum_news_kind news;
} step;

typedef struct story {
    const char *fact;
    step steps[16];
} story;

#define STEP(ns, what, status, asked, news)                                    \
    {                                                                          \
        ns, what, status, asked, news                                          \
    }
#define SERVE(ns, asked)              STEP(ns, IDLE, 0, asked, NOTHING)
#define HEAR(ns, what, status, asked) STEP(ns, what, status, asked, NOTHING)
#define TOLD(ns, what, status, asked, news)                                    \
    STEP(ns, what, status, asked, LUM_NEWS_##news)
#define WISH(ns, want) STEP(ns, WANT, LUM_WANT_##want, 0, NOTHING)

/* Beginnings. */
#define ASKS          WISH(0, ON), SERVE(0, 'u')
#define RISES         ASKS, TOLD(MS, ANSWER, UP, 0, LASER_UP)
#define FALLS         RISES, TOLD(MS, ALERT, HOT, 'd', LASER_FELL)
#define SINKS         WISH(0, OFF), SERVE(0, 'd')
#define LIES          SINKS, HEAR(MS, ANSWER, OFF, 0), SERVE(S, '.')
#define BLIND_OFF(ns) TOLD(ns, BLIND, 0, 0, NO_STATUS)

#define S SECOND

static story stories[] = {
    {"a laser that nobody asked for is only looked at",
     {SERVE(0, '.'), HEAR(MS, ANSWER, HOT, 0), SERVE(S - 1, 0), SERVE(S, '.'),
      HEAR(S, ANSWER, UP, 0), HEAR(S, ALERT, HOT, '.')}},
    {"on is asked for again while heartbeats may be on their way",
     {ASKS, HEAR(MS, ANSWER, REFUSED, 0), SERVE(201 * MS - 1, 0),
      SERVE(201 * MS, 'u'), HEAR(300 * MS, ANSWER, REFUSED, 0),
      SERVE(500 * MS, 'u'), TOLD(S, ANSWER, REFUSED, 'd', LASER_REFUSED)}},
    {"another want begins anew",
     {ASKS, HEAR(0, ANSWER, REFUSED, 0), SERVE(S, 'u'),
      HEAR(S, ANSWER, REFUSED, 0), WISH(S, ON), SERVE(S, 'u'),
      HEAR(S, ANSWER, REFUSED, 0), SERVE(2 * S, 'u'),
      HEAR(2 * S, ANSWER, REFUSED, 0), SERVE(3 * S, 'u'),
      TOLD(3 * S, ANSWER, REFUSED, 'd', LASER_REFUSED)}},
    {"without an owner on is given up at once",
     {HEAR(0, ALONE, 0, 0), ASKS, HEAR(0, ANSWER, 0, 0), SERVE(S, 'u'),
      TOLD(S, ANSWER, REFUSED, 'd', LASER_REFUSED), WISH(S, ON),
      TOLD(S, NO_ANSWER, 0, 'u', OFF_UNANSWERED),
      TOLD(S, ANSWER, UP | 1, 'd', LASER_REFUSED)}},
    {"what a hazard refuses is not asked for again",
     {ASKS, TOLD(MS, ANSWER, HOT, 'd', LASER_REFUSED)}},
    {"bit 0 is a hazard like others",
     {ASKS, TOLD(MS, ANSWER, UP | 1, 'd', LASER_REFUSED),
      HEAR(MS, ANSWER, OFF | 1, 0), SERVE(S, 0), SERVE(S + MS, '.')}},
    {"an answer to on without a status is not trusted",
     {ASKS, TOLD(MS, BLIND, 0, 'd', LASER_UNSEEN)}},
    {"on without an answer is given up 5 s after it was wanted",
     {ASKS, HEAR(S, NO_ANSWER, 0, 'u'), WISH(2 * S, ON), SERVE(3 * S, 0),
      SERVE(4 * S, 0), SERVE(5 * S, 0), SERVE(6 * S, 0),
      HEAR(7 * S - 1, NO_ANSWER, 0, 'u'),
      TOLD(7 * S, NO_ANSWER, 0, 'd', LASER_UNANSWERED)}},
    {"an answer that nobody waits for any more is none to on",
     {ASKS, HEAR(MS, ANSWER, REFUSED, 0), HEAR(2 * MS, ANSWER, UP, 0),
      HEAR(201 * MS, NO_ANSWER, 0, 'u'), HEAR(202 * MS, NO_ANSWER, 0, 0),
      HEAR(203 * MS, ANSWER, UP, 0)}},
    {"a program that stood still for 2 s switches off",
     {ASKS, SERVE(2 * S - 1, 0), TOLD(4 * S - 1, IDLE, 0, 'd', LASER_HELD_UP)}},
    {"what an on brings that is not wanted any more does not count",
     {ASKS, WISH(MS, OFF), HEAR(MS, ANSWER, UP, 'd'), WISH(MS, ON),
      TOLD(MS, NO_ANSWER, 0, 'u', OFF_UNANSWERED), WISH(MS, OFF),
      TOLD(MS, BLIND, 0, 'd', NO_STATUS), WISH(MS, ON),
      TOLD(MS, NO_ANSWER, 0, 'u', OFF_UNANSWERED), WISH(MS, OFF),
      HEAR(9 * S, NO_ANSWER, 0, 'd')}},
    {"an on that is not wanted any more is not repeated",
     {ASKS, WISH(MS, LOOK), SERVE(MS, '.'), WISH(MS, ON),
      HEAR(MS, NO_ANSWER, 0, 'u'), WISH(MS, GUARD), SERVE(MS, '.')}},
    {"an off that is not wanted any more decides nothing",
     {SINKS, WISH(MS, ON), HEAR(MS, ANSWER, UP, 'u')}},
    {"an off that no status showed is not owed by another want",
     {SINKS, BLIND_OFF(MS), WISH(MS, GUARD), SERVE(MS, '.'),
      TOLD(MS, ANSWER, UP, 0, LASER_CAME_UP)}},
    {"one that stays up is looked at each second",
     {RISES, SERVE(S - 1, 0), SERVE(S, '.'), HEAR(S + MS, ANSWER, UP, 0),
      SERVE(2 * S - 1, 0), SERVE(2 * S, '.')}},
    {"one that is not shown up any more, as after a restart, is switched off",
     {RISES, SERVE(S, '.'), TOLD(S + MS, ANSWER, 0, 'd', LASER_FELL)}},
    {"nor is on asked for any less until it is shown up",
     {ASKS, HEAR(MS, ANSWER, 0, 0), SERVE(201 * MS, 'u')}},
    {"one that goes down is switched off",
     {RISES, SERVE(S, '.'), TOLD(S + MS, ANSWER, REFUSED, 'd', LASER_FELL)}},
    {"one that was switched off needs no other off",
     {RISES, SERVE(S, '.'), TOLD(S + MS, ANSWER, OFF | 1, 0, LASER_FELL),
      SERVE(2 * S - 1, 0), SERVE(2 * S, '.')}},
    {"an alert of a hazard counts at once, and the session repeats its off",
     {RISES, SERVE(S, '.'), TOLD(S, ALERT, HOT, 'd', LASER_FELL),
      SERVE(2 * S, 0), SERVE(9 * S, 0)}},
    {"command bits of an alert are not believed",
     {RISES, TOLD(2 * MS, ALERT, OFF | HEAT, 'd', LASER_FELL)}},
    {"another alert is asked about",
     {RISES, HEAR(2 * MS, ALERT, UP, '.'), BLIND_OFF(3 * MS),
      HEAR(4 * MS, ALERT, OFF, '.'), HEAR(5 * MS, BLIND, 0, 0),
      HEAR(6 * MS, ALERT, REFUSED, '.'), HEAR(7 * MS, BLIND, 0, 0),
      HEAR(8 * MS, BLIND_ALERT, HOT, '.')}},
    {"an alert hastens no on, and one before it was sent is no answer to it",
     {ASKS, HEAR(MS, ANSWER, REFUSED, 0), HEAR(2 * MS, ALERT, HOT, 0),
      SERVE(201 * MS - 1, 0), SERVE(201 * MS, 'u'),
      TOLD(202 * MS, ANSWER, UP, 0, LASER_UP)}},
    {"off is sent until a status shows it, and told once that none does",
     {SINKS, TOLD(S, NO_ANSWER, 0, 'd', OFF_UNANSWERED),
      HEAR(S, NO_ANSWER, 0, 0), SERVE(2 * S, 'd'), HEAR(2 * S, ANSWER, UP, 0),
      SERVE(2200 * MS - 1, 0), SERVE(2200 * MS, 'd'),
      TOLD(3 * S, NO_ANSWER, 0, 0, OFF_UNANSWERED), WISH(3 * S, OFF),
      SERVE(3 * S, 'd'), TOLD(4 * S, NO_ANSWER, 0, 'd', OFF_UNANSWERED),
      HEAR(4 * S, ANSWER, OFF, 0), SERVE(5 * S - 1, 0), SERVE(5 * S, '.')}},
    {"off is repeated while the command on stands",
     {SINKS, HEAR(0, ANSWER, HOT, 0), SERVE(S, 'd'),
      HEAR(S, ANSWER, REFUSED, 0), SERVE(2 * S, 'd'),
      /* with both in effect, which no sensor should show, not so often */
      HEAR(2 * S, ANSWER, HOT | OFF, 0), SERVE(3 * S - 1, 0), SERVE(3 * S, 'd'),
      HEAR(3 * S, ANSWER, HEAT, 0), SERVE(4 * S, '.')}},
    {"off without a status is sent again once it is seen up",
     {FALLS, BLIND_OFF(MS), SERVE(S + MS, '.'),
      HEAR(S + 2 * MS, ANSWER, UP, 'd')}},
    {"and is done once it is seen down",
     {FALLS, BLIND_OFF(MS), SERVE(S + MS, '.'), HEAR(S + MS, ANSWER, OFF, 0),
      SERVE(2 * S + MS, '.'), TOLD(2 * S + MS, ANSWER, UP, 0, LASER_CAME_UP)}},
    {"another program may switch it on again",
     {LIES, HEAR(S, ANSWER, 0, 0), SERVE(2 * S, '.'),
      TOLD(2 * S, ANSWER, UP, 0, LASER_CAME_UP), SERVE(3 * S, '.'),
      TOLD(3 * S, ANSWER, HOT, 'd', LASER_FELL)}},
    {"what a hazard refuses to it does not stand",
     {LIES, HEAR(S, ANSWER, HOT, 'd'), HEAR(S, ANSWER, OFF, 0),
      SERVE(2 * S, '.'), HEAR(2 * S, ANSWER, HOT | OFF, 'd')}},
    {"a hazard alone, or no heartbeats, are left alone",
     {LIES, HEAR(S, ANSWER, HEAT | OFF, 0), SERVE(2 * S, '.'),
      HEAR(2 * S, ANSWER, REFUSED, 0), SERVE(3 * S, '.')}},
    {"what the program asks puts off no off, and nothing tells its lack",
     {WISH(0, OFF), HEAR(0, LEND, 0, 0), HEAR(0, NO_ANSWER, 0, 'd'),
      HEAR(MS, ANSWER, UP, 0), HEAR(100 * MS, LEND, 0, 0),
      SERVE(201 * MS - 1, 0), SERVE(201 * MS, 'd')}},
    {"its answer is none to the laser session's, and no try",
     {ASKS, HEAR(0, LEND, 0, 0), HEAR(MS, ANSWER, UP, 0), SERVE(S - 1, 0),
      SERVE(S, 'u'), HEAR(S, ANSWER, REFUSED, 0), SERVE(2 * S, 'u'),
      TOLD(2 * S, ANSWER, REFUSED, 'd', LASER_REFUSED), WISH(2 * S, GUARD),
      HEAR(2 * S, LEND, 0, 0), TOLD(2 * S, ANSWER, UP, 0, LASER_CAME_UP)}},
};

/* Beside the news of a story, answers and hazards are not looked at. */
static lum_news next_of_story(void)
{
    lum_news news = next_news();
    while (news.kind == LUM_NEWS_HAZARD || news.kind == LUM_NEWS_NO_ANSWER ||
           news.kind == LUM_NEWS_ANSWERS) {
        news = next_news();
    }
    return news;
}

static void play(void **state)
{
    const story *told = *state;
    open_session();
    options.owns = false;
    options.attempts = 3;
    begin();
    lum_laser_session_note_owner(laser, true);
    for (const step *s = told->steps; s->what != END; s++) {
        fake.now_ns = SECOND + s->ns;
        happen(s->what, s->status);
        const char asked = s->what >= WANT ? (char)0 : serve();
        const lum_news news = next_of_story();
        if (asked != s->asked || news.kind != s->news) {
            fail_msg("step %d: asked %c, news %d", (int)(s - told->steps),
                     asked, (int)news.kind);
        }
        if (news.kind != NOTHING && news.kind <= LUM_NEWS_LASER_CAME_UP) {
            assert_int_equal(news.status, s->status);
        }
        if (news.kind == LUM_NEWS_LASER_UNANSWERED) {
            assert_int_equal(news.tries, 8);
        }
        assert_int_equal(next_of_story().kind, NOTHING);
    }
}

/* --- Life, and what its user wants --- */

static lum_laser_session_view look(void)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    assert_int_equal(lum_laser_session_look(laser, &view), LUM_OK);
    return view;
}

static void a_laser_session_is_made_of_the_session_s_options(void **state)
{
    lum_sensor_options session;
    lum_error error;
    lum_laser_session_view small = {.struct_size = 0};
    lum_news news = {.struct_size = 0};
    char name[] = "eth0";
    (void)state;
    open_session();
    lum_sensor_options_default(&session);
    session.owns = true;
    session.interface_name = name;
    session.sensor.address++;
    lum_laser_session_options_default(&options, &session);
    assert_int_equal(options.give_up_ms, 5000);
    assert_int_equal(options.attempts, 20);
    assert_int_equal(options.laser, LUM_WANT_LOOK);
    assert_true(options.owns);
    begin();
    name[3] = '1';
    hear(LINK_UP, 0);
    assert_int_equal(lum_laser_session_look(laser, &small), LUM_E_VALUE);
    assert_false(lum_laser_session_next(laser, &news)); /* and it is not lost */
    news = take_news(LUM_NEWS_LINK_UP);
    assert_string_equal(news.interface_name, "eth0");
    assert_int_equal(news.sensor.address, session.sensor.address);
    assert_int_equal(news.tlv_status, 2);
    assert_int_equal(news.to.address, 0);
    lum_laser_session_free(laser);
    options.interface_name = "";
    begin();
    hear(LINK_UP, 0);
    assert_string_equal(take_news(LUM_NEWS_LINK_UP).interface_name, "");
    options.struct_size = 0;
    assert_int_equal(lum_laser_session_new(&options, 0, NULL, &error), -1);
    assert_non_null(strstr(error.text, "struct_size"));
}

static void a_laser_session_may_be_told_to_try_once_and_not_to_wait(
    void **state)
{
    (void)state;
    open_session();
    options.laser = LUM_WANT_ON;
    options.attempts = 0;
    options.give_up_ms = 0;
    begin();
    assert_int_equal(serve(), 'u');
    hear(ANSWER, REFUSED);
    (void)take_news(LUM_NEWS_LASER_REFUSED);
    want(LUM_WANT_ON);
    assert_int_equal(serve(), 'u');
    hear(NO_ANSWER, 0);
    (void)take_news(LUM_NEWS_LASER_UNANSWERED);
}

static void a_hazard_before_the_answer_to_on_refuses_it(void **state)
{
    (void)state;
    begin_with(LUM_WANT_ON);
    assert_int_equal(serve(), 'u');
    hear(ALERT, HOT);
    hear(ANSWER, UP);
    assert_int_equal(take_news(LUM_NEWS_LASER_REFUSED).status, HOT);
    want(LUM_WANT_ON);
    assert_int_equal(serve(), 'u');
    hear(ANSWER, UP);
    (void)take_news(LUM_NEWS_LASER_UP);
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
        const char *other = cases[i].is_off_due ? "u" : "d";
        begin_with(LUM_WANT_LOOK);
        assert_int_equal(lum_laser_session_command(laser, sensor, cases[i].text,
                                                   fake.now_ns),
                         LUM_OK);
        /* one at a time: what is not sent is not wanted */
        assert_int_equal(
            lum_laser_session_command(laser, sensor, other, fake.now_ns),
            LUM_E_VALUE);
        assert_int_equal(look().laser, cases[i].laser);
        assert_int_equal(look().is_off_due, cases[i].is_off_due);
        hear(ANSWER, UP);
        (void)take_news(cases[i].then);
        assert_int_equal(look().is_off_due, cases[i].is_off_due);
    }
}

/* What a text asks for besides changes nothing for the laser, and its answer is
 * none to laser off, which follows at once. */
static void other_commands_are_not_about_the_laser(void **state)
{
    (void)state;
    begin_with(LUM_WANT_ON);
    assert_int_equal(serve(), 'u');
    hear(ANSWER, UP);
    (void)take_news(LUM_NEWS_LASER_UP);
    assert_int_equal(
        lum_laser_session_command(laser, sensor, "50p", fake.now_ns), LUM_OK);
    assert_int_equal(look().laser, LUM_LASER_UP);
    hear(ANSWER, UP);
    want(LUM_WANT_OFF);
    assert_int_equal(
        lum_laser_session_command(laser, sensor, "50p", fake.now_ns), LUM_OK);
    hear(ANSWER, UP);
    assert_true(look().is_off_due);
    assert_int_equal(serve(), 'd');
    hear(ANSWER, OFF);
    assert_false(look().is_off_due);
    assert_int_equal(lum_laser_session_command(laser, sensor, "d", fake.now_ns),
                     LUM_OK);
    assert_true(look().is_off_due);
    hear(ANSWER, OFF);
    assert_false(look().is_off_due);
}

/* After the answer to "off": when what is sent next. */
static void an_off_is_repeated_by_what_its_answer_shows(void **state)
{
    static const struct {
        uint16_t status;
        int64_t after_ns;
        char next;
    } cases[] = {{OFF, SECOND, '.'},
                 {HEAT, SECOND, '.'},
                 {UP | OFF, SECOND, 'd'},
                 {UP | 1, SECOND / 5, 'd'},
                 {UP, SECOND / 5, 'd'}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin_with(LUM_WANT_OFF);
        assert_int_equal(serve(), 'd');
        hear(ANSWER, cases[i].status);
        fake.now_ns += cases[i].after_ns - 1;
        assert_int_equal(serve(), 0);
        fake.now_ns++;
        assert_int_equal(serve(), cases[i].next);
    }
}

static void it_is_told_how_long_the_program_stood_still(void **state)
{
    (void)state;
    begin_with(LUM_WANT_ON);
    fake.now_ns += 2500 * MS;
    assert_int_equal(serve(), 'd');
    assert_true(take_news(LUM_NEWS_LASER_HELD_UP).ns == 2500 * MS);
    (void)take_news(NOTHING);
}

/* The causes of a fall after pauses, before and after the laser came up. */
static void a_fall_after_a_pause_of_the_program_says_so(void **state)
{
    static const struct {
        bool owns;
        int64_t before_ns;
        int64_t pause_ns;
        int64_t after_ns;
        uint16_t status;
        int64_t expected_ns;
    } cases[] = {{true, 0, 4 * S, S / 2, OFF, 4 * S},
                 {true, 0, 2 * S, 0, OFF, 2 * S},
                 {true, 0, 2 * S - 1, 0, OFF, 0},
                 {true, 0, 3 * S, 0, HOT, 0},
                 {true, 9 * S, 0, 0, OFF, 0},
                 {true, 0, 3 * S, 2 * S - 1, OFF, 3 * S},
                 {true, 0, 3 * S, 2 * S, OFF, 0},
                 {false, 0, 3 * S, S, OFF, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        open_session();
        options.owns = cases[i].owns;
        begin();
        fake.now_ns += cases[i].before_ns;
        want(LUM_WANT_GUARD);
        hear(ANSWER, UP);
        (void)take_news(LUM_NEWS_LASER_CAME_UP);
        fake.now_ns++;
        hear(IDLE, 0);
        fake.now_ns += cases[i].pause_ns;
        (void)serve();
        fake.now_ns += cases[i].after_ns / 2;
        hear(IDLE, 0);
        fake.now_ns += cases[i].after_ns - cases[i].after_ns / 2;
        hear(ANSWER, cases[i].status);
        assert_true(find_news(LUM_NEWS_LASER_FELL).ns == cases[i].expected_ns);
    }
}

static void of_a_full_queue_the_oldest_are_lost(void **state)
{
    lum_sensor_event event = {.kind = LUM_SENSOR_LINK};
    char *text = event.error.text;
    (void)state;
    begin_with(LUM_WANT_LOOK);
    for (unsigned told = 20; told < 200; told += 20) {
        for (unsigned n = 0; n < told; n++) {
            text[0] = (char)n;
            give(event);
        }
        unsigned n =
            told > LUM_LASER_SESSION_NEWS ? told - LUM_LASER_SESSION_NEWS : 0;
        for (; n < told; n++) {
            assert_int_equal(take_news(LUM_NEWS_LINK_DOWN).text[0], (char)n);
        }
        (void)take_news(NOTHING);
    }
}

/* An event with texts of the sensor, and a TLV that is none. */
static void say(lum_sensor_event_kind kind, const char *text, uint16_t len,
                unsigned count)
{
    lum_sensor_event event = {.kind = kind, .has_status = true};
    lum_tlv_writer tlvs;
    uint8_t bytes[700];
    uint32_t number = 0;
    assert_int_equal(lum_tlv_begin(&tlvs, bytes, sizeof bytes, 1), LUM_OK);
    assert_int_equal(lum_tlv_add(&tlvs, 1, "no text", 7), LUM_OK);
    for (unsigned i = 0; i < count; i++) {
        assert_int_equal(lum_tlv_add(&tlvs, 3, text, len), LUM_OK);
    }
    assert_int_equal(lum_tlv_open(bytes, tlvs.len, &number, &event.tlvs),
                     LUM_OK);
    give(event);
}

static void texts_of_the_sensor_are_told_up_to_a_limit(void **state)
{
    static const char text[300] = {'\n', '~', '\x7f', ' ', '\x1f'};
    (void)state;
    begin_with(LUM_WANT_LOOK);
    for (unsigned i = 1; i <= LUM_LASER_SESSION_TEXTS; i++) {
        say(i % 2u == 0 ? LUM_SENSOR_ALERT : LUM_SENSOR_ANSWER, text,
            i == 1 ? 300 : 5, 1);
        const lum_news news = take_news(LUM_NEWS_TEXT);
        assert_int_equal(strlen(news.text), i == 1 ? 226 : i < 20 ? 5 : 5 + 29);
        assert_memory_equal(news.text, "?~? ?", 5);
        assert_string_equal(news.text + (i < 20 ? strlen(news.text) : 5),
                            i < 20 ? "" : " (further ones are not shown)");
    }
    say(LUM_SENSOR_ALERT, "more", 4, 1);
    (void)take_news(NOTHING);
}

static void texts_leave_room_for_other_news(void **state)
{
    (void)state;
    begin_with(LUM_WANT_LOOK);
    for (unsigned i = 0; i < 30; i++) {
        hear(LINK_UP, 0);
    }
    say(LUM_SENSOR_ALERT, "one", 3, 3);
    for (unsigned i = 0; i < 32; i++) {
        (void)take_news(i < 30 ? LUM_NEWS_LINK_UP : LUM_NEWS_TEXT);
    }
    (void)take_news(NOTHING);
}

/* --- Data --- */

static void data_is_told_from_what_is_of_another_layout(void **state)
{
    static const struct {
        const char *datagrams;
        bool has_unknown;
        bool has_data;
    } cases[] = {{"af", false, false}, {"x", true, false},  {"t", true, false},
                 {"g", true, false},   {"ax", true, false}, {"at", true, false},
                 {".x", false, true},  {"a.x", false, true}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin_with(LUM_WANT_LOOK);
        give_datagrams(cases[i].datagrams, 1);
        assert_int_equal(look().has_unknown, cases[i].has_unknown);
        assert_int_equal(look().has_data, cases[i].has_data);
    }
}

static void times_of_data_are_kept_and_told(void **state)
{
    (void)state;
    begin_with(LUM_WANT_LOOK);
    wait_for(3 * SECOND);
    (void)serve();
    assert_true(take_news(LUM_NEWS_NO_ANSWER_YET).ns == 3 * SECOND);
    const int64_t first_ns = fake.now_ns;
    give_datagrams(".", SECOND / 1000);
    fake.now_ns += SECOND / 2;
    give_datagrams(".", SECOND / 1000);
    wait_for(4 * SECOND);
    (void)serve();
    assert_true(take_news(LUM_NEWS_SILENT).ns == 4 * SECOND);
    assert_true(look().is_silent);
    assert_true(look().data_ns == first_ns + SECOND / 2);
    give_datagrams(".", 0);
    assert_true(take_news(LUM_NEWS_BACK).ns == 4 * SECOND);
    assert_false(look().is_silent);
    fake.now_ns += SECOND;
    give_datagrams("..", SECOND / 1000);
    (void)take_news(LUM_NEWS_RESTARTED);
    (void)take_news(NOTHING);
    assert_true(look().data_ns == fake.now_ns);
    assert_true(look().first_data_ns == first_ns);
}

static void a_hazard_is_told_when_it_begins(void **state)
{
    static const struct {
        int64_t after_ns;
        what what;
        uint16_t status;
        uint16_t told;                          /* 0: none is */
    } cases[] = {{0, ANSWER, HOT | COLD, HEAT}, /* no heartbeat came yet */
                 {S - 1, ANSWER, HOT | COLD, 0},
                 {0, ALERT, 0x1ff, 0},
                 {1, ANSWER, HOT | COLD, COLD},
                 {2 * S, ANSWER, HOT | COLD, 0}, /* a pause; it begins anew */
                 {S, ANSWER, HOT | COLD, 0},
                 {0, ANSWER, OFF | COLD, 0},
                 {0, ANSWER, HOT, HEAT},
                 {0, ANSWER, UINT16_MAX, 0x1df}};
    (void)state;
    begin_with(LUM_WANT_LOOK);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fake.now_ns += cases[i].after_ns;
        give_data();
        hear(cases[i].what, cases[i].status);
        const lum_news news = next_news();
        assert_int_equal(news.kind,
                         cases[i].told != 0 ? LUM_NEWS_HAZARD : NOTHING);
        assert_int_equal(news.status, cases[i].told);
        (void)take_news(NOTHING);
    }
}

/* --- What holds --- */

/* What it knows besides, after an event. */
static void check_view(const lum_news *first, what heard, uint16_t status)
{
    static bool is_unheard;
    static bool has_answered;
    const lum_laser_session_view view = look();
    has_answered |= heard == ANSWER;
    assert_int_equal(view.has_answered, has_answered);
    is_unheard =
        heard == NO_ANSWER || (is_unheard && heard != ANSWER && heard != BLIND);
    assert_int_equal(view.is_unheard, is_unheard);
    assert_true(heard != ANSWER || (view.has_status && view.status == status));
    assert_true(first->kind != LUM_NEWS_LASER_LEFT ||
                view.is_off_due == first->was_away);
    assert_true(first->kind != LUM_NEWS_SILENT || first->ns == 3 * SECOND);
}

/* What is shown after each event, the first with its "away", and why lines are
 * dark. */
static void what_holds_is_shown_by_its_weight(void **state)
{
    static const struct {
        what what;
        uint16_t status;
        const char *dark;
        const char *shown;
    } cases[] = {{WANT, LUM_WANT_OFF, "", " laser-left away"},
                 {WANT, LUM_WANT_LOOK, "", ""},
                 {PAUSE, 0, "", " no-answer-yet"},
                 {DATA, 0, "", ""},
                 {ANSWER, 0, "laser-is-off", " laser-is-off"},
                 {ANSWER, OFF, "laser-is-off", " laser-is-off"},
                 {ANSWER, HOT, "hazard", " laser-is-off hazard"},
                 {LINK_DOWN, 0, "hazard", " link-down laser-is-off hazard"},
                 {LINK_UP, 0, "hazard", " laser-is-off hazard"},
                 {ANSWER, COLD, "laser-is-off", " laser-is-off hazard"},
                 {ANSWER, 1, "hazard", " laser-is-off hazard"},
                 {ANSWER, UP, "", ""},
                 /* without data for a while no more than that */
                 {ANSWER, HOT, "hazard", " laser-is-off hazard"},
                 {PAUSE, 0, "hazard", " silent"},
                 {ANSWER, HOT, "hazard", " data-stopped"},
                 {NO_ANSWER, 0, "hazard", " silent"},
                 {DATA, 0, "hazard", " unheard"},
                 /* one that was left; first it is being switched off */
                 {WANT, LUM_WANT_OFF, "hazard", " unheard off-unanswered"},
                 {ANSWER, UP, "", " laser-left away"},
                 {ANSWER, OFF, "laser-left", " laser-left away"},
                 {ALERT, UP, "laser-left", " laser-left away"},
                 {SERVED, 0, "laser-left", " laser-left away"},
                 {BLIND, 0, "laser-left", " laser-left away"},
                 {NO_ANSWER, 0, "laser-left", " unheard off-unanswered"},
                 {ANSWER, OFF, "laser-left", " laser-left"},
                 {WANT, LUM_WANT_ON, "", ""},
                 {WANT, LUM_WANT_GUARD, "laser-left", " laser-left"},
                 {ANSWER, UP, "", ""},
                 {PAUSE, 0, "", " silent"},
                 {ANSWER, OFF, "laser-fell", " data-stopped"},
                 {DATA, 0, "laser-fell", " laser-fell away"},
                 {WANT, LUM_WANT_ON, "", ""}};
    (void)state;
    begin_with(LUM_WANT_LOOK);
    assert_false(look().has_status);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lum_news news[4] = {{.struct_size = sizeof news[0]}};
        char shown[100] = "";
        happen(cases[i].what, cases[i].status);
        const size_t count =
            lum_laser_session_standing(laser, fake.now_ns, news, 4);
        for (size_t n = 0; n < count; n++) {
            assert_true(has_time(news[n].kind) || news[n].ns == 0);
            strcat(strcat(shown, " "), lum_news_name(news[n].kind));
        }
        strcat(shown, count > 0 && news[0].was_away ? " away" : "");
        assert_string_equal(shown, cases[i].shown);
        check_view(&news[0], cases[i].what, cases[i].status);
        const bool is_dark = lum_laser_session_darkness(laser, &news[0]);
        assert_string_equal(is_dark ? lum_news_name(news[0].kind) : "",
                            cases[i].dark);
    }
}

static void no_more_is_shown_than_there_is_room_for(void **state)
{
    lum_news unset = {.struct_size = 0};
    lum_news news[2] = {{.struct_size = sizeof news[0]},
                        {.struct_size = sizeof news[0], .status = 7}};
    (void)state;
    begin_with(LUM_WANT_LOOK);
    hear(ANSWER, OFF);
    assert_false(lum_laser_session_darkness(laser, &unset));
    assert_int_equal(lum_laser_session_standing(laser, fake.now_ns, news, 1),
                     1);
    assert_int_equal(news[0].status, OFF);
    hear(LINK_DOWN, 0);
    hear(IDLE, 0);
    assert_int_equal(lum_laser_session_standing(laser, fake.now_ns, news, 0),
                     0);
    assert_int_equal(lum_laser_session_standing(laser, fake.now_ns, news, 1),
                     1);
    assert_int_equal(news[0].kind, LUM_NEWS_LINK_DOWN);
    assert_int_equal(strlen(news[0].text), LUM_NEWS_TEXT_BYTES - 1u);
    assert_int_equal(news[1].status, 7);
}

static void a_silence_is_shown_in_whole_seconds(void **state)
{
    lum_news news = {.struct_size = sizeof news};
    (void)state;
    begin_with(LUM_WANT_LOOK);
    fake.now_ns += 300 * MS;
    give_data();
    wait_for(4 * SECOND + SECOND / 2);
    assert_int_equal(lum_laser_session_standing(laser, fake.now_ns, &news, 1),
                     1);
    assert_int_equal(news.kind, LUM_NEWS_SILENT);
    assert_true(news.ns == 4 * SECOND);
    /* silent it stays, though it is known now where its data comes from */
    (void)serve();
    (void)take_news(LUM_NEWS_SILENT);
    sensor->stranger.from = (lum_endpoint){0x0a2a0063, LUM_PORT};
    sensor->stranger.count = LUM_SENSOR_MOVED_COUNT;
    (void)serve();
    (void)serve();
    assert_true(look().is_silent);
}

static void without_an_owner_no_heartbeats_are_no_hazard(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        lum_news news[4] = {{.struct_size = sizeof news[0]}};
        open_session();
        options.owns = i == 2;
        begin();
        wait_for(8 * SECOND + SECOND / 2);
        lum_laser_session_note_owner(laser, i == 1);
        hear(ANSWER, REFUSED);
        (void)take_news(i == 0 ? NOTHING : LUM_NEWS_HAZARD);
        assert_int_equal(
            lum_laser_session_standing(laser, fake.now_ns, news, 4), 3);
        assert_int_equal(news[0].kind, LUM_NEWS_NO_DATA_YET);
        assert_true(news[0].ns == 8 * SECOND);
    }
}

/* --- The session --- */

static void a_sensor_that_moved_is_told_with_its_address(void **state)
{
    lum_news moved = {.struct_size = sizeof moved};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        begin_with(LUM_WANT_LOOK);
        sensor->stranger.from = (lum_endpoint){0x0a2a0063, LUM_PORT};
        sensor->stranger.count = LUM_SENSOR_MOVED_COUNT;
        if (i == 0) {
            (void)serve();
            assert_int_equal(take_news(LUM_NEWS_MOVED).to.address, 0x0a2a0063);
            assert_int_equal(
                lum_laser_session_standing(laser, fake.now_ns, &moved, 1), 1);
            assert_int_equal(moved.kind, LUM_NEWS_MOVED);
        }
        lum_laser_session_end(laser, sensor, 100, 0, NULL);
        assert_true(fake.now_ns == SECOND + 100 * MS);
        assert_int_equal(take_news(LUM_NEWS_ENDED_UNKNOWN).to.address,
                         0x0a2a0063);
    }
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

/* Only the command itself is answered. */
static void answer_commands(const struct fake_sent *sent)
{
    if (name_request(sent->bytes, sent->len) == 'd') {
        answer_each(sent);
    }
}

/* A session whose requests are answered with a status. */
static void begin_answered(uint16_t status,
                           void (*on_send)(const struct fake_sent *sent))
{
    begin_with(LUM_WANT_LOOK);
    end_status = status;
    end_has_status = true;
    fake.on_send = on_send;
}

/* Late ones are told from none by the session's count of them. */
static void answers_that_are_late_are_told(void **state)
{
    (void)state;
    begin_with(LUM_WANT_LOOK);
    assert_int_equal(serve(), '.');
    hear(NO_ANSWER, 0);
    sensor->counters.answers_dropped++;
    (void)serve();
    (void)take_news(LUM_NEWS_LATE_ANSWERS);
}

static char name_sent(size_t i)
{
    return name_request(fake.sent[i].bytes, fake.sent[i].len);
}

static void each_end_is_told(void **state)
{
    static const struct {
        uint16_t status;
        bool has_status;
        lum_laser_off off; /* UNKNOWN: without a session */
        lum_news_kind last;
        lum_news_kind again; /* where it is tried on */
    } cases[] = {
        {OFF, true, LUM_LASER_OFF_SEEN, LUM_NEWS_ENDED_OFF, LUM_NEWS_ENDED_OFF},
        {1, true, LUM_LASER_OFF_SEEN, LUM_NEWS_ENDED_OFF, LUM_NEWS_ENDED_OFF},
        {UP | 1, true, LUM_LASER_OFF_REFUSED, LUM_NEWS_ENDED_IN_EFFECT,
         LUM_NEWS_OFF_GOES_ON},
        {UP, true, LUM_LASER_OFF_REFUSED, LUM_NEWS_ENDED_ON,
         LUM_NEWS_OFF_GOES_ON},
        {0, false, LUM_LASER_OFF_UNSEEN, LUM_NEWS_ENDED_UNSEEN,
         LUM_NEWS_ENDED_UNSEEN},
        {0, false, LUM_LASER_OFF_UNKNOWN, LUM_NEWS_ENDED_UNKNOWN,
         LUM_NEWS_OFF_GOES_ON}};
    (void)state;
    for (size_t i = 0; i < 12; i++) {
        const bool is_last = i < 6;
        const lum_laser_off off = cases[i % 6u].off;
        const uint16_t status = cases[i % 6u].status;
        begin_answered(status, answer_each);
        end_has_status = cases[i % 6u].has_status;
        assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
        assert_int_equal(
            lum_laser_session_end(laser,
                                  off != LUM_LASER_OFF_UNKNOWN ? sensor : NULL,
                                  1000, is_last ? 0 : 7000, NULL),
            off);
        /* a status that shows it down is looked at once more */
        if (lum_laser_is_down(status)) {
            assert_int_equal(name_sent(0), 'd');
            assert_int_equal(name_sent(1), '.');
            assert_true(fake.sent[1].ns - fake.sent[0].ns == 300 * MS);
        }
        const lum_news news =
            take_news(is_last ? cases[i % 6u].last : cases[i % 6u].again);
        assert_int_equal(news.status, status);
        assert_int_equal(news.tries, off == LUM_LASER_OFF_REFUSED);
        assert_true(news.ns == (is_last ? 0 : 7 * SECOND));
        assert_true(news.is_owner && news.to.address == 0);
        assert_int_equal(look().has_status, end_has_status);
        assert_int_equal(look().laser, LUM_LASER_LEFT);
        assert_int_equal(look().is_off_due, off != LUM_LASER_OFF_SEEN);
    }
}

/* --- Laser off --- */

/* A send stops the program for so long that a request is not sent again. */
static void stop_at_send(const struct fake_sent *sent)
{
    (void)sent;
    fake.now_ns += 3 * SECOND;
}

static lum_laser_off switch_off(uint32_t ms)
{
    return lum_sensor_laser_off(sensor, ms, NULL, NULL);
}

static void an_off_goes_on_after_a_standstill(void **state)
{
    (void)state;
    begin_answered(OFF, stop_at_send);
    assert_int_equal(switch_off(5000), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(fake.sent_count, 2);
}

static void an_off_that_is_not_seen_twice_begins_again(void **state)
{
    (void)state;
    begin_answered(OFF, answer_commands);
    const int64_t begin_ns = fake.now_ns;
    assert_int_equal(switch_off(2320), LUM_LASER_OFF_UNKNOWN);
    size_t last = fake.sent_count - 1u;
    assert_int_equal(name_sent(last), '.');
    while (name_sent(last) != 'd') {
        last--;
    }
    assert_true(fake.sent[last].ns - begin_ns == 2300 * MS);
}

static void an_off_that_is_not_answered_ends_in_time(void **state)
{
    (void)state;
    begin_with(LUM_WANT_LOOK);
    const int64_t begin_ns = fake.now_ns;
    assert_int_equal(switch_off(320), LUM_LASER_OFF_UNKNOWN);
    assert_true(fake.now_ns - begin_ns == 320 * MS);
}

static void raise_cancel(const struct fake_sent *sent)
{
    (void)sent;
    fake.is_raised = true;
}

static void a_cancel_ends_an_off_before_its_next_send(void **state)
{
    const lum_cancel *const any = (const lum_cancel *)(const void *)&fake;
    (void)state;
    begin_answered(OFF, raise_cancel);
    const int64_t begin_ns = fake.now_ns;
    assert_int_equal(lum_sensor_laser_off(sensor, 5000, any, NULL),
                     LUM_LASER_OFF_UNKNOWN);
    assert_true(fake.now_ns - begin_ns == 50 * MS);
}

static void an_off_changes_nothing_else_of_the_session(void **state)
{
    lum_sensor_event event;
    lum_error error;
    (void)state;
    begin_answered(OFF, answer_each);
    fake.send = LUM_NET_FAILED; /* before it, and not told yet */
    assert_int_equal(lum_sensor_set_ip(sensor, 0x0a2a0063, &error),
                     LUM_NET_FAILED);
    fake.send = LUM_NET_OK;
    assert_int_equal(switch_off(1000), LUM_LASER_OFF_SEEN);
    fake.on_send = NULL;
    lum_sensor_receive(sensor, fake.now_ns, &event);
    assert_int_equal(event.kind, LUM_SENSOR_IDLE);
}

#define STORIES (sizeof stories / sizeof stories[0])
#define FACTS   (sizeof facts / sizeof facts[0])

static const struct CMUnitTest facts[] = {
    cmocka_unit_test(a_laser_session_is_made_of_the_session_s_options),
    cmocka_unit_test(a_laser_session_may_be_told_to_try_once_and_not_to_wait),
    cmocka_unit_test(a_hazard_before_the_answer_to_on_refuses_it),
    cmocka_unit_test(a_text_of_commands_is_what_is_wanted),
    cmocka_unit_test(other_commands_are_not_about_the_laser),
    cmocka_unit_test(an_off_is_repeated_by_what_its_answer_shows),
    cmocka_unit_test(it_is_told_how_long_the_program_stood_still),
    cmocka_unit_test(a_fall_after_a_pause_of_the_program_says_so),
    cmocka_unit_test(of_a_full_queue_the_oldest_are_lost),
    cmocka_unit_test(texts_of_the_sensor_are_told_up_to_a_limit),
    cmocka_unit_test(texts_leave_room_for_other_news),
    cmocka_unit_test(data_is_told_from_what_is_of_another_layout),
    cmocka_unit_test(times_of_data_are_kept_and_told),
    cmocka_unit_test(a_hazard_is_told_when_it_begins),
    cmocka_unit_test(what_holds_is_shown_by_its_weight),
    cmocka_unit_test(no_more_is_shown_than_there_is_room_for),
    cmocka_unit_test(a_silence_is_shown_in_whole_seconds),
    cmocka_unit_test(without_an_owner_no_heartbeats_are_no_hazard),
    cmocka_unit_test(a_sensor_that_moved_is_told_with_its_address),
    cmocka_unit_test(answers_that_are_late_are_told),
    cmocka_unit_test(each_end_is_told),
    cmocka_unit_test(an_off_goes_on_after_a_standstill),
    cmocka_unit_test(an_off_that_is_not_seen_twice_begins_again),
    cmocka_unit_test(an_off_that_is_not_answered_ends_in_time),
    cmocka_unit_test(a_cancel_ends_an_off_before_its_next_send),
    cmocka_unit_test(an_off_changes_nothing_else_of_the_session),
};

static struct CMUnitTest tests[STORIES + FACTS];

int main(void)
{
    memcpy(tests, facts, sizeof facts);
    for (size_t i = 0; i < STORIES; i++) {
        tests[FACTS + i] =
            (struct CMUnitTest){stories[i].fact, play, NULL, NULL, &stories[i]};
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
