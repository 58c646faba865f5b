/* A laser session as its user, its sensor and time might treat it, beside a
 * model of docs/safety.md: what it sends, each news of the laser, and what it
 * says that holds are those of the model. The session is one of a few words,
 * here below.
 *
 * With LUM_RANDOM it is a program, fuzz_keeper RUNS SEED, that makes so many
 * random sequences without a fuzzer. */
#include "lum/base/time.h"
#include "lum/group.h"
#include "lum/laser.h"
#include "lum/live/laser_session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MS        INT64_C(1000000)
#define SECOND    (1000 * MS)
#define GIVE_UP   (5 * SECOND)
#define SILENCE   (LUM_SENSOR_SILENCE_MS * MS)
#define TIMED_OUT LUM_LASER_HEARTBEAT_TIMEOUT
#define ON        LUM_LASER_TLV_CMD_ON
#define OFF       LUM_LASER_TLV_CMD_OFF
#define HOT       LUM_LASER_BOARD_OVER_105
#define HEAT      0x1efu /* hazards that heartbeats do not end */
#define OTHER     'x'    /* a request of the user's that is not for the laser */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static unsigned long sequence; /* that is tried */

static void require_at(bool fact, int line)
{
    if (!fact) {
        (void)fprintf(stderr, "fuzz_keeper.c:%d: sequence %lu\n", line,
                      sequence);
        abort();
    }
}

#define REQUIRE(fact) require_at(fact, __LINE__)

/* --- The session --- */

struct lum_sensor {
    bool is_waiting, is_moved;
    bool refuses; /* nothing can be sent */
    char request; /* u, d, OTHER, or a point: a look */
    uint64_t dropped;
    lum_laser_off off; /* how the end goes, and what it shows */
    uint16_t status;
};

static const lum_endpoint home = {0x0a2a0025, 5517};
static const lum_endpoint elsewhere = {0x0a2a0063, 5517};

/* What the input decides. */
static struct run {
    const uint8_t *input; /* taken from its end on */
    size_t left;
    int64_t now_ns, boot_ns;
    int64_t utc_ns; /* ahead of it */
    lum_sensor session;
    lum_laser_session *laser;
    char asked;    /* in this call; 0: nothing */
    bool owns;     /* the session sends heartbeats */
    bool is_user;  /* it is not the laser session that asks */
    uint64_t hash; /* of all that came out */
} run;

/* --- The model --- */

#define ALONE  LUM_LASER_UNTOUCHED
#define RISING LUM_LASER_ASKED
#define UP     LUM_LASER_UP
#define DOWN   LUM_LASER_LEFT

static struct model {
    lum_laser_state phase;
    bool owes;     /* "on" may be in effect: off is sent until a status tells */
    bool trusts;   /* an answer without a status said that it is done */
    bool is_on;    /* a person's ON holds, and no news said that it fell */
    bool is_owned; /* somebody sends heartbeats */
    bool has_status;
    uint16_t status, left; /* the last one; that with which it was left */
    bool is_out;           /* "on" was sent, and nothing came of it */
    unsigned hit;          /* hazards before the answer to "on" */
    unsigned tries, most;  /* at "on" */
    int64_t began_ns, tick_ns, due_ns;

    bool has_data, is_unheard, is_moved;
    lum_news_kind quiet; /* that data has stopped was told */
    bool told_unheard, told_blind, told_off, told_waiting;
    bool may_restart, was_spoiled;
    unsigned hazards, texts;   /* that were told */
    int64_t data_ns, heard_ns; /* 0: never */
    int64_t passed_ns;         /* a call that time passes with */
    int64_t listens_ns;        /* since then, without a pause */

    unsigned expected[LUM_NEWS_END]; /* news that must come in this step */
} model;

static bool is_shown_up(unsigned status)
{
    return (status & (LUM_LASER_ALL_DOWN | ON)) == ON;
}

static bool is_in_effect(unsigned status)
{
    return (status & LUM_LASER_ALL_DOWN) == 0 || (status & ON) != 0;
}

/* A hazard's end brings it up, unless "off" came last. */
static bool comes_up(unsigned status)
{
    return (status & (ON | OFF)) != OFF;
}

static void expect(lum_news_kind kind, bool is_due)
{
    model.expected[kind] += is_due;
}

static void owe(int64_t due_ns)
{
    model.owes = true;
    model.due_ns = due_ns;
}

static void fall(lum_news_kind why, uint16_t status, bool owes)
{
    model.phase = DOWN;
    model.left = status;
    expect(why, true);
    if (owes) {
        owe(run.now_ns);
    }
}

static void model_want(lum_laser_want want)
{
    static const lum_laser_state phases[] = {ALONE, DOWN, RISING, DOWN};
    model.phase = phases[want];
    model.is_on = want == LUM_WANT_ON;
    model.owes = want == LUM_WANT_OFF;
    model.trusts = model.told_off = false;
    model.tries = model.hit = model.left = 0;
    model.began_ns = model.tick_ns = model.due_ns = run.now_ns;
}

/* The answer to "on". */
static void model_rise(uint16_t answered)
{
    const uint16_t status = (uint16_t)(answered | model.hit);
    if (is_shown_up(status)) {
        model.phase = UP;
        expect(LUM_NEWS_LASER_UP, true);
    } else if ((status & HEAT) != 0 || model.tries >= model.most ||
               ((status & TIMED_OUT) != 0 && !model.is_owned)) {
        fall(LUM_NEWS_LASER_REFUSED, status, comes_up(status));
    } else {
        model.due_ns = run.now_ns + SECOND / 5;
    }
}

/* The answer to anything else. */
static void model_look(uint16_t status)
{
    const bool is_held = (status & HEAT) != 0 && comes_up(status);
    if (model.phase == UP && !is_shown_up(status)) {
        fall(LUM_NEWS_LASER_FELL, status, comes_up(status));
    } else if (model.phase == DOWN) {
        if (is_held || (model.trusts && is_in_effect(status))) {
            owe(run.now_ns);
        } else if (is_shown_up(status) && !model.owes) {
            model.phase = UP;
            expect(LUM_NEWS_LASER_CAME_UP, true);
        }
        model.trusts = false;
    }
}

static void model_answer(char request, bool has_status, uint16_t status)
{
    model.is_out = false;
    model.has_status |= has_status;
    model.status = has_status ? status : model.status;
    if (request == 'd' && model.phase == DOWN) {
        model.trusts = !has_status;
        model.owes = has_status && is_in_effect(status);
        if (model.owes && (status & LUM_LASER_TLV_CMD_OFF) == 0) {
            model.due_ns = run.now_ns + SECOND / 5;
        }
    } else if (request == 'u' && model.phase == RISING && !has_status) {
        fall(LUM_NEWS_LASER_UNSEEN, 0, true);
    } else if (request == 'u' && model.phase == RISING) {
        model_rise(status);
    } else if (has_status) {
        model_look(status);
    }
}

static void model_sent(char request)
{
    model.tries += request == 'u';
    model.is_out = request == 'u';
    if (request != OTHER || !model.owes) {
        model.due_ns = run.now_ns + SECOND;
    }
}

/* What the program did not listen to is no silence. */
static void model_pass(void)
{
    if (run.now_ns - model.passed_ns >= 2 * SECOND) {
        model.listens_ns = run.now_ns;
    }
    model.passed_ns = run.now_ns;
}

static bool is_silent(int64_t since_ns)
{
    return run.now_ns - since_ns >= SILENCE &&
           run.now_ns - model.listens_ns >= SILENCE;
}

/* What is to be sent in a call that passes the time; 0: nothing. */
static char model_next(void)
{
    const lum_sensor *s = &run.session;
    const char next = model.phase == RISING ? 'u' : model.owes ? 'd' : '.';
    const bool gives_up =
        s->request != next && (next == 'd' || s->request == 'u');
    const bool can = !s->refuses && (!s->is_waiting || gives_up);
    return can && run.now_ns >= model.due_ns ? next : (char)0;
}

/* --- What the laser session calls --- */

int64_t lum_time_monotonic_ns(void)
{
    return run.now_ns;
}

static void note(uint64_t value)
{
    run.hash = (run.hash ^ value) * UINT64_C(0x100000001b3);
}

static lum_result begin(lum_sensor *s, char request)
{
    if (s->is_waiting || s->refuses) {
        return s->is_waiting ? LUM_E_VALUE : LUM_E_SPACE;
    }
    if (!run.is_user) {
        REQUIRE(run.asked == 0 && (request != 'u' || model.is_on));
        REQUIRE(request == '.' || model.phase != ALONE);
        run.asked = request;
    }
    s->is_waiting = true;
    s->request = request;
    note((uint64_t)request);
    return LUM_OK;
}

lum_result lum_sensor_request(lum_sensor *s, const void *tlvs, size_t len)
{
    REQUIRE(tlvs == NULL && len == 0);
    return begin(s, '.');
}

/* Its last letter of these decides. */
static char switch_of(const char *text)
{
    const char *u = strrchr(text, 'u');
    const char *d = strrchr(text, 'd');
    const bool is_on = u != NULL && (d == NULL || u > d);
    return is_on ? 'u' : d != NULL ? 'd' : OTHER;
}

lum_result lum_sensor_command(lum_sensor *s, const char *text)
{
    REQUIRE(run.is_user || strlen(text) == 1);
    return begin(s, switch_of(text));
}

void lum_sensor_give_up(lum_sensor *s)
{
    s->is_waiting = false;
}

bool lum_sensor_moved_to(const lum_sensor *s, lum_endpoint *out)
{
    *out = s->is_moved ? elsewhere : *out;
    return s->is_moved;
}

lum_result lum_sensor_count(lum_sensor *s, lum_sensor_counters *out)
{
    out->answers_dropped = s->dropped;
    return LUM_OK;
}

lum_laser_off lum_sensor_laser_off(lum_sensor *s, uint32_t ms,
                                   const lum_cancel *cancel, uint16_t *status)
{
    REQUIRE(ms == 3000 && cancel == NULL);
    s->is_waiting = false;
    if (s->off == LUM_LASER_OFF_SEEN || s->off == LUM_LASER_OFF_REFUSED) {
        *status = s->status;
    }
    return s->off;
}

/* --- News --- */

/* Of its data and its answers: which may come, but need not in this step. */
static void check_contact(const lum_news *news)
{
    const lum_news_kind kind = news->kind;
    if (kind == LUM_NEWS_SILENT || kind == LUM_NEWS_DATA_STOPPED) {
        const bool answers = model.heard_ns != 0 && !model.is_unheard &&
                             run.now_ns - model.heard_ns < 2 * SECOND;
        REQUIRE(model.has_data && !model.is_moved && model.quiet != kind);
        REQUIRE(is_silent(model.data_ns));
        REQUIRE((kind == LUM_NEWS_DATA_STOPPED) == answers);
        model.quiet = kind;
    } else if (kind == LUM_NEWS_RESTARTED) {
        REQUIRE(model.may_restart);
        model.may_restart = model.was_spoiled; /* and back */
    } else if (kind == LUM_NEWS_ANSWERS) {
        REQUIRE(model.told_unheard && !model.is_unheard);
    } else if (kind == LUM_NEWS_UNHEARD || kind == LUM_NEWS_NO_ANSWER ||
               kind == LUM_NEWS_LATE_ANSWERS) {
        REQUIRE(model.is_unheard && !model.told_unheard);
        REQUIRE(kind == LUM_NEWS_LATE_ANSWERS ||
                model.has_data == (kind == LUM_NEWS_UNHEARD));
        model.told_unheard = true;
    } else if (kind == LUM_NEWS_HAZARD) {
        REQUIRE(news->status != 0 && (news->status & ~model.status) == 0);
        REQUIRE((news->status & model.hazards) == 0);
        model.hazards |= news->status;
    } else if (kind == LUM_NEWS_TEXT) {
        REQUIRE(++model.texts <= LUM_LASER_SESSION_TEXTS);
    } else {
        REQUIRE(kind >= LUM_NEWS_NO_ANSWER_YET &&
                kind <= LUM_NEWS_UNKNOWN_LAYOUT);
        REQUIRE(run.owns && !model.has_data && !model.told_waiting);
        REQUIRE(is_silent(0));
        model.told_waiting = true;
    }
}

static void check_text(const lum_news *news)
{
    char text[300];
    const size_t room = 1u + (size_t)(run.hash % sizeof text);
    const char *end = memchr(lum_news_tell(news, text, room), 0, room);
    REQUIRE(end != NULL && lum_news_name(news->kind) != NULL);
    for (const char *at = text; at < end; at++) {
        REQUIRE(*at >= ' ' && *at <= '~');
    }
}

static void check_news(const lum_news *news)
{
    const lum_news_kind kind = news->kind;
    REQUIRE(kind >= LUM_NEWS_LASER_UP && kind < LUM_NEWS_END);
    if (model.expected[kind] == 0) {
        check_contact(news);
    } else {
        model.expected[kind]--;
    }
    if (kind <= LUM_NEWS_LASER_CAME_UP) {
        REQUIRE(news->status ==
                (model.phase == UP ? model.status : model.left));
        model.is_on = model.is_on && kind == LUM_NEWS_LASER_UP;
    }
}

static void drain(void)
{
    static const unsigned none[LUM_NEWS_END];
    lum_news news = {.struct_size = sizeof news};
    while (lum_laser_session_next(run.laser, &news)) {
        note(news.kind);
        note(news.status);
        check_news(&news);
        if (run.hash % 64u == 0) {
            check_text(&news);
        }
    }
    REQUIRE(memcmp(model.expected, none, sizeof none) == 0);
}

/* --- Steps --- */

static uint8_t take_byte(void)
{
    return run.left > 0 ? run.input[--run.left] : 0;
}

static uint16_t take_status(void)
{
    static const uint16_t commands[] = {ON, OFF, 0, ON | OFF};
    static const uint16_t hazards[] = {
        0, 0, 0, 0, TIMED_OUT, HOT, HOT | TIMED_OUT, 0x8400};
    const uint8_t b = take_byte();
    return commands[b % 4u] | hazards[b / 4u % 8u];
}

static void check_view(void)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    lum_news news[4] = {{.struct_size = sizeof news[0]}};
    REQUIRE(lum_laser_session_look(run.laser, &view) == LUM_OK);
    REQUIRE(view.laser == model.phase);
    REQUIRE(view.is_off_due == (model.owes || model.trusts));
    REQUIRE(view.has_status == model.has_status);
    REQUIRE(view.status == model.status);
    REQUIRE(view.has_data == model.has_data);
    REQUIRE(view.is_unheard == model.is_unheard);
    const size_t count = lum_laser_session_standing(run.laser, run.now_ns, news,
                                                    1u + run.hash % 4u);
    REQUIRE(count <= 4);
    for (size_t i = 0; i < count; i++) {
        REQUIRE(lum_news_name(news[i].kind) != NULL);
    }
    if (lum_laser_session_darkness(run.laser, &news[0])) {
        REQUIRE(model.has_status && !is_shown_up(model.status));
        REQUIRE(news[0].kind == LUM_NEWS_HAZARD ||
                lum_news_is_dark(news[0].kind));
    }
}

static void pass(int64_t ns)
{
    run.now_ns += ns;
    const int64_t stood_ns = run.now_ns - model.tick_ns;
    model.tick_ns = run.now_ns;
    if (model.phase == RISING && stood_ns >= 2 * SECOND) {
        fall(LUM_NEWS_LASER_HELD_UP, 0, true);
    }
    expect(LUM_NEWS_MOVED, run.session.is_moved && !model.is_moved);
    model.is_moved = run.session.is_moved;
    model_pass();
    const char next = model_next();
    run.asked = 0;
    lum_laser_session_serve(run.laser, &run.session, run.now_ns);
    REQUIRE(run.asked == next);
    REQUIRE(stood_ns < 2 * SECOND || run.asked != 'u');
    if (run.asked != 0) {
        model_sent(run.asked);
    }
    REQUIRE(!run.session.is_waiting || run.session.request != 'u' ||
            model.phase == RISING || run.session.refuses);
    drain();
    REQUIRE(model.quiet != 0 || model.is_moved || !model.has_data ||
            !is_silent(model.data_ns));
}

/* An event, with words of the sensor or none, and its news. */
static void hear(lum_sensor_event event, bool has_text)
{
    uint8_t packet[64];
    uint32_t number = 0;
    lum_tlv_writer w;
    REQUIRE(lum_tlv_begin(&w, packet, 64, 1) == LUM_OK);
    if (has_text) {
        REQUIRE(lum_tlv_add(&w, 3, "hot\n\xff", 5) == LUM_OK);
    }
    REQUIRE(lum_tlv_open(packet, w.len, &number, &event.tlvs) == LUM_OK);
    model_pass();
    lum_laser_session_take(run.laser, &event, run.now_ns);
    drain();
}

static void answer(uint8_t how)
{
    const bool has_status = how % 8u > 1;
    const uint16_t status = take_status();
    const char request = run.session.request;
    const bool is_judged = request == 'u' && model.phase == RISING;
    if (!run.session.is_waiting) {
        return;
    }
    run.session.is_waiting = false;
    expect(LUM_NEWS_NO_STATUS, !has_status && !model.told_blind && !is_judged);
    model.is_unheard = false;
    model.heard_ns = run.now_ns;
    model.told_off = false;
    model.told_blind = !has_status;
    model_answer(request, has_status, status);
    model.hazards &= has_status ? status : UINT16_MAX;
    hear((lum_sensor_event){.kind = LUM_SENSOR_ANSWER,
                            .has_status = has_status,
                            .status = status},
         how >= 224);
    model.told_unheard = false;
}

/* It is asked about, and a hazard counts. */
static void alert(uint8_t how)
{
    const bool has_status = how % 4u != 0;
    const uint16_t status = take_status();
    const unsigned hazards = has_status ? status & HEAT : 0;
    model.due_ns = model.phase == RISING ? model.due_ns : run.now_ns;
    if (model.phase == RISING && model.is_out) {
        model.hit |= hazards;
    } else if (model.phase == UP && hazards != 0) {
        fall(LUM_NEWS_LASER_FELL, status, true);
    }
    hear((lum_sensor_event){.kind = LUM_SENSOR_ALERT,
                            .has_status = has_status,
                            .status = status},
         how % 4u == 1);
}

static void no_answer(uint8_t how)
{
    (void)how;
    const char request = run.session.request;
    if (!run.session.is_waiting) {
        return;
    }
    run.session.is_waiting = false;
    model.is_unheard = true;
    model.is_out = false;
    if (request == 'u' && model.phase == RISING &&
        run.now_ns - model.began_ns >= GIVE_UP) {
        fall(LUM_NEWS_LASER_UNANSWERED, 0, true);
    }
    expect(LUM_NEWS_OFF_UNANSWERED, request == 'd' && !model.told_off);
    model.told_off |= request == 'd';
    hear((lum_sensor_event){.kind = LUM_SENSOR_NO_ANSWER, .tries = 4}, false);
}

static void other(uint8_t how)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_LINK, LUM_SENSOR_LINK,      LUM_SENSOR_IDLE,
        LUM_SENSOR_TIME, LUM_SENSOR_CANCELLED, LUM_SENSOR_FAILED};
    const unsigned which = how % 6u;
    expect(LUM_NEWS_LINK_UP, which == 0);
    expect(LUM_NEWS_LINK_DOWN, which == 1);
    hear((lum_sensor_event){.kind = kinds[which],
                            .has_status = true,
                            .status = take_status(),
                            .is_up = which == 0},
         false);
}

/* A packet, with the sensor's clock or any. */
static void arrive(uint8_t how)
{
    lum_layout layout;
    uint8_t bytes[64] = {0};
    size_t len = 0;
    const bool is_spoiled = how % 8u == 0;
    const bool restarts = how % 8u == 1;
    run.boot_ns = restarts ? run.now_ns : run.boot_ns;
    run.utc_ns += how % 8u == 2 ? how * SECOND : 0;
    const uint32_t clock_us = (uint32_t)((run.now_ns - run.boot_ns) / 1000);
    const lum_group group = {.tag = LUM_TAG_RANGES,
                             .num_samples = 1,
                             .clock_raw =
                                 is_spoiled ? (uint32_t)how << 24 : clock_us};
    model.may_restart |=
        restarts || (is_spoiled && (model.was_spoiled || !model.has_data));
    model.was_spoiled = is_spoiled;
    lum_layout_default(&layout);
    REQUIRE(lum_group_encode(&layout, &group, bytes, sizeof bytes, &len) ==
            LUM_OK);
    const lum_received datagram = {bytes, len + 4u, home,
                                   run.now_ns + run.utc_ns, false};
    expect(LUM_NEWS_BACK, model.quiet != 0);
    model.quiet = 0;
    model.has_data = true;
    model.data_ns = run.now_ns;
    hear((lum_sensor_event){.kind = LUM_SENSOR_DATAGRAMS,
                            .datagrams = &datagram,
                            .datagram_count = 1},
         false);
}

static void command(uint8_t how)
{
    static const char *const texts[] = {"u",     "d",   "50p",
                                        "50p u", "u d", "d u 1h"};
    const char *text = texts[how % 6u];
    const char request = switch_of(text);
    run.session.is_waiting = run.session.is_waiting && how < 128;
    const bool is_taken = !run.session.is_waiting && !run.session.refuses;
    run.is_user = true;
    REQUIRE((lum_laser_session_command(run.laser, &run.session, text,
                                       run.now_ns) == LUM_OK) == is_taken);
    run.is_user = false;
    if (is_taken && request != OTHER) {
        model_want(request == 'u' ? LUM_WANT_ON : LUM_WANT_OFF);
    }
    if (is_taken) {
        model_sent(request);
    }
}

static void want(uint8_t how)
{
    const lum_laser_want laser = (lum_laser_want)(how % 4u);
    model_want(laser);
    lum_laser_session_want(run.laser, laser, run.now_ns);
}

static void lend(uint8_t how)
{
    run.session.is_waiting = true;
    run.session.request = OTHER;
    if (how % 4u == 0) {
        want(LUM_WANT_GUARD);
    }
    lum_laser_session_lend(run.laser, run.now_ns);
    model_sent(OTHER);
}

static void end(uint8_t how)
{
    /* by lum_laser_off, where it is up, only in effect, and is tried on */
    static const lum_news_kind kinds[3][4] = {
        {LUM_NEWS_ENDED_OFF, LUM_NEWS_ENDED_UNKNOWN, LUM_NEWS_ENDED_ON,
         LUM_NEWS_ENDED_UNSEEN},
        {LUM_NEWS_ENDED_OFF, LUM_NEWS_ENDED_UNKNOWN, LUM_NEWS_ENDED_IN_EFFECT,
         LUM_NEWS_ENDED_UNSEEN},
        {LUM_NEWS_ENDED_OFF, LUM_NEWS_OFF_GOES_ON, LUM_NEWS_OFF_GOES_ON,
         LUM_NEWS_ENDED_UNSEEN}};
    lum_sensor *s = how < 200 ? &run.session : NULL;
    const bool goes_on = how % 8u > 3;
    const bool is_up = how % 16u < 8;
    run.session.off = (lum_laser_off)(how % 4u);
    const lum_laser_off off = s != NULL ? s->off : LUM_LASER_OFF_UNKNOWN;
    const bool is_seen = off == LUM_LASER_OFF_SEEN;
    run.session.status = is_seen ? OFF : is_up ? ON : ON | HOT;
    model_want(LUM_WANT_OFF);
    if (is_seen || off == LUM_LASER_OFF_REFUSED) {
        model.has_status = true;
        model.status = run.session.status;
    }
    model.owes = !is_seen;
    expect(kinds[goes_on ? 2 : !is_up][off], true);
    REQUIRE(lum_laser_session_end(run.laser, s, 3000, goes_on ? 7000 : 0,
                                  NULL) == off);
    run.session.is_waiting = false;
    model.is_moved = s != NULL ? s->is_moved : model.is_moved;
    drain();
}

/* Without a look at the news: of a full queue the oldest are lost. */
static void overflow(uint8_t how)
{
    const lum_sensor_event up = {.kind = LUM_SENSOR_LINK, .is_up = true};
    const unsigned ups = how % 100u;
    model_pass();
    for (unsigned i = 0; i < ups; i++) {
        lum_laser_session_take(run.laser, &up, run.now_ns);
    }
    model.expected[LUM_NEWS_LINK_UP] =
        ups < LUM_LASER_SESSION_NEWS ? ups : LUM_LASER_SESSION_NEWS - 1u;
    expect(LUM_NEWS_LINK_DOWN, true);
    hear((lum_sensor_event){.kind = LUM_SENSOR_LINK}, false);
}

static void stand_still(uint8_t how)
{
    pass(2 * SECOND - 100 * MS + how * 2 * MS);
}

static void change_session(uint8_t how)
{
    run.session.refuses = how >= 128 && !run.session.refuses;
    run.session.is_moved = how % 64u < 32;
    run.session.dropped += how / 64u;
}

static void note_owner(uint8_t how)
{
    model.is_owned = run.owns || how >= 128;
    lum_laser_session_note_owner(run.laser, how >= 128);
}

static void step(void)
{
    static void (*const steps[])(uint8_t how) = {
        answer, answer,    answer,    answer,    answer,         answer,
        answer, no_answer, no_answer, no_answer, alert,          alert,
        want,   command,   lend,      end,       change_session, note_owner,
        arrive, arrive,    overflow,  other,     stand_still};
    const uint8_t op = take_byte();
    if (op % 32u < sizeof steps / sizeof steps[0]) {
        steps[op % 32u](take_byte());
    } else {
        pass(take_byte() * 4 * MS);
    }
    check_view();
}

static uint64_t play(const uint8_t *data, size_t size)
{
    lum_sensor_options session;
    lum_laser_session_options options;
    lum_error error;
    memset(&model, 0, sizeof model);
    run = (struct run){
        .input = data, .left = size, .now_ns = SECOND, .utc_ns = 1000 * SECOND};
    const uint8_t how = take_byte();
    lum_sensor_options_default(&session);
    lum_laser_session_options_default(&options, &session);
    options.laser = (lum_laser_want)(how % 4u);
    run.owns = (how & 4u) != 0;
    options.owns = run.owns;
    options.attempts = (how & 16u) != 0 ? 1 : options.attempts;
    model.most = options.attempts;
    options.interface_name = (how & 8u) != 0 ? "eth0" : NULL;
    model.is_owned = options.owns;
    model.passed_ns = run.now_ns;
    model.listens_ns = run.now_ns;
    model_want(options.laser);
    REQUIRE(lum_laser_session_new(&options, run.now_ns, &run.laser, &error) ==
            0);
    while (run.left > 0) {
        step();
    }
    lum_laser_session_free(run.laser);
    return run.hash;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint64_t hash = play(data, size);
    REQUIRE(sequence % 8u != 0 || hash == play(data, size));
    return 0;
}

#ifdef LUM_RANDOM
int main(int argc, char **argv)
{
    static uint8_t input[256];
    if (argc != 3) {
        (void)fprintf(stderr, "usage: fuzz_keeper RUNS SEED\n");
        return 2;
    }
    const unsigned long runs = strtoul(argv[1], NULL, 10);
    uint64_t state = strtoul(argv[2], NULL, 10);
    for (; sequence < runs; sequence++) {
        for (size_t i = 0; i < sizeof input; i++) {
            state = state * UINT64_C(6364136223846793005) +
                    UINT64_C(1442695040888963407);
            input[i] = (uint8_t)(state >> 56);
        }
        (void)LLVMFuzzerTestOneInput(input,
                                     (size_t)(1u + (state >> 33) % 255u));
    }
    return 0;
}
#endif
