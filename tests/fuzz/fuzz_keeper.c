/* A keeper as its user, its sensor and time might treat it, beside a model of
 * docs/safety.md: what it sends, each news of the laser, and what it says that
 * holds are those of the model. The session is one of a few words, here below.
 *
 * With LUM_RANDOM it is a program, fuzz_keeper RUNS SEED, that makes so many
 * random sequences without a fuzzer. */
#include "lum/base/time.h"
#include "lum/group.h"
#include "lum/laser.h"
#include "lum/live/keeper.h"

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
#define OTHER     'x' /* a request of the user's that is not for the laser */

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
    bool is_waiting;
    bool refuses; /* nothing can be sent */
    bool is_moved;
    char request; /* u, d, OTHER, or a point: a look */
    uint64_t dropped;
    lum_laser_off off; /* how the end goes, and what it shows */
    uint16_t status;
};

static const lum_endpoint home = {0x0a2a0025, 5517};
static const lum_endpoint elsewhere = {0x0a2a0063, 5517};

/* What the input decides. */
static struct run {
    const uint8_t *next;
    size_t left;
    int64_t now_ns;
    int64_t utc_ns; /* ahead of it */
    int64_t boot_ns;
    lum_sensor session;
    lum_keeper *keeper;
    char asked;    /* in this call; 0: nothing */
    bool owns;     /* the session sends heartbeats */
    bool is_user;  /* it is not the keeper that asks */
    uint64_t hash; /* of all that came out */
} run;

/* --- The model --- */

typedef enum phase {
    ALONE,
    RISING,
    UP,
    DOWN
} phase;

static struct model {
    phase phase;
    bool owes;     /* "on" may be in effect: off is sent until a status tells */
    bool trusts;   /* an answer without a status said that it is done */
    bool is_on;    /* a person's ON holds, and no news said that it fell */
    bool is_owned; /* somebody sends heartbeats */
    unsigned tries; /* at "on" */
    unsigned most;
    int64_t began_ns;
    int64_t tick_ns;
    int64_t due_ns;
    bool has_status;
    uint16_t status;
    bool is_out;            /* "on" was sent, and nothing came of it */
    unsigned hit;           /* hazards before the answer to "on" */
    uint16_t left;          /* the status with which it was left */
    lum_news_kind expected; /* of the laser, not taken yet; 0: none */

    bool has_data;
    bool is_quiet; /* that was told */
    bool is_unheard;
    bool told_unheard;
    bool told_blind;
    bool told_off;
    bool told_waiting;
    bool is_moved;
    bool may_restart;
    bool was_spoiled;
    unsigned hazards;
    unsigned texts;
    int64_t data_ns;
    int64_t heard_ns;   /* 0: never */
    int64_t passed_ns;  /* a call that time passes with */
    int64_t listens_ns; /* since then, without a pause */
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

static unsigned heat(unsigned status)
{
    return status & 0x1efu; /* hazards that heartbeats do not end */
}

static void expect(lum_news_kind kind)
{
    REQUIRE(model.expected == 0);
    model.expected = kind;
}

static void fall(lum_news_kind why, uint16_t status, bool owes)
{
    model.phase = DOWN;
    model.left = status;
    model.owes = owes;
    model.due_ns = owes ? run.now_ns : model.due_ns;
    expect(why);
}

static void owe(int64_t due_ns)
{
    model.owes = true;
    model.due_ns = due_ns;
}

static void model_want(lum_laser_want want)
{
    static const phase phases[] = {ALONE, DOWN, RISING, DOWN};
    model.phase = phases[want];
    model.is_on = want == LUM_WANT_ON;
    model.owes = want == LUM_WANT_OFF;
    model.trusts = false;
    model.told_off = false;
    model.tries = 0;
    model.hit = 0;
    model.left = 0;
    model.began_ns = run.now_ns;
    model.tick_ns = run.now_ns;
    model.due_ns = run.now_ns;
}

/* Is down, or does not tell, in the answer to anything. */
static void model_down(uint16_t status)
{
    if (model.phase == UP) {
        fall(LUM_NEWS_LASER_FELL, status, comes_up(status));
    } else if (model.phase == DOWN) {
        if ((heat(status) != 0 && comes_up(status)) ||
            (model.trusts && is_in_effect(status))) {
            owe(run.now_ns);
        }
        model.trusts = false;
    }
}

static void model_up(void)
{
    if (model.phase != DOWN) {
        return;
    }
    if (model.trusts) {
        model.trusts = false;
        owe(run.now_ns);
    } else if (!model.owes) {
        model.phase = UP;
        expect(LUM_NEWS_LASER_CAME_UP);
    }
}

/* The answer to "on". */
static void model_rise(uint16_t answered)
{
    const uint16_t status = (uint16_t)(answered | model.hit);
    if (is_shown_up(status)) {
        model.phase = UP;
        expect(LUM_NEWS_LASER_UP);
    } else if (heat(status) != 0 || model.tries >= model.most ||
               ((status & TIMED_OUT) != 0 && !model.is_owned)) {
        fall(LUM_NEWS_LASER_REFUSED, status, comes_up(status));
    } else {
        model.due_ns = run.now_ns + SECOND / 5;
    }
}

static void model_answer(char request, bool has_status, uint16_t status)
{
    model.is_out = false;
    if (has_status) {
        model.has_status = true;
        model.status = status;
    }
    if (request == 'd' && model.phase == DOWN) {
        model.trusts = !has_status;
        model.owes = has_status && is_in_effect(status);
        model.due_ns = model.owes ? run.now_ns + SECOND / 5 : model.due_ns;
    } else if (request == 'u' && model.phase == RISING) {
        if (has_status) {
            model_rise(status);
        } else {
            fall(LUM_NEWS_LASER_UNSEEN, 0, true);
        }
    } else if (has_status) {
        if (is_shown_up(status)) {
            model_up();
        } else {
            model_down(status);
        }
    }
}

static void model_alert(bool has_status, uint16_t status)
{
    if (model.phase == RISING) {
        model.hit |= has_status && model.is_out ? heat(status) : 0;
        return;
    }
    model.due_ns = run.now_ns;
    if (has_status && model.phase == UP && heat(status) != 0) {
        fall(LUM_NEWS_LASER_FELL, status, true);
    }
}

static void model_no_answer(char request)
{
    model.is_out = false;
    if (request == 'u' && model.phase == RISING &&
        run.now_ns - model.began_ns >= GIVE_UP) {
        fall(LUM_NEWS_LASER_UNANSWERED, 0, true);
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
    if (run.now_ns < model.due_ns || s->refuses) {
        return 0;
    }
    const bool waits = s->is_waiting && s->request == next;
    const bool is_kept = next != 'd' && s->request != 'u';
    return waits || (s->is_waiting && is_kept) ? 0 : next;
}

/* --- What the keeper calls --- */

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
        REQUIRE(run.asked == 0);
        REQUIRE(request != 'u' || model.is_on);
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
    if (u == NULL && d == NULL) {
        return OTHER;
    }
    return d == NULL || (u != NULL && u > d) ? 'u' : 'd';
}

lum_result lum_sensor_command(lum_sensor *s, const char *text)
{
    REQUIRE(run.is_user || strlen(text) == 1);
    return begin(s, switch_of(text));
}

bool lum_sensor_is_waiting(const lum_sensor *s)
{
    return s->is_waiting;
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

static bool is_of_laser(lum_news_kind kind)
{
    return kind >= LUM_NEWS_LASER_UP && kind <= LUM_NEWS_LASER_CAME_UP;
}

static void check_laser(const lum_news *news)
{
    REQUIRE(model.expected == news->kind);
    REQUIRE(news->status == (model.phase == UP ? model.status : model.left));
    model.expected = (lum_news_kind)0;
    model.is_on = model.is_on && news->kind == LUM_NEWS_LASER_UP;
}

static void check_contact(const lum_news *news)
{
    const lum_news_kind kind = news->kind;
    REQUIRE(kind >= LUM_NEWS_LASER_UP && kind < LUM_NEWS_END);
    if (kind == LUM_NEWS_SILENT || kind == LUM_NEWS_DATA_STOPPED) {
        REQUIRE(model.has_data && !model.is_moved && !model.is_quiet);
        REQUIRE(is_silent(model.data_ns));
        REQUIRE((kind == LUM_NEWS_DATA_STOPPED) ==
                (model.heard_ns != 0 && !model.is_unheard &&
                 run.now_ns - model.heard_ns < 2 * SECOND));
        model.is_quiet = true;
    } else if (kind == LUM_NEWS_BACK) {
        REQUIRE(model.is_quiet && model.data_ns == run.now_ns);
        model.is_quiet = false;
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
    } else if (kind == LUM_NEWS_OFF_UNANSWERED) {
        REQUIRE(!model.told_off && model.is_unheard);
        model.told_off = true;
    } else if (kind >= LUM_NEWS_NO_ANSWER_YET &&
               kind <= LUM_NEWS_UNKNOWN_LAYOUT) {
        REQUIRE(run.owns && !model.has_data && !model.told_waiting);
        REQUIRE(is_silent(0));
        model.told_waiting = true;
    } else if (kind == LUM_NEWS_TEXT) {
        REQUIRE(++model.texts <= LUM_KEEPER_TEXTS);
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

/* How often a kind came among those of the call. */
static unsigned drain(lum_news_kind asked)
{
    lum_news news = {.struct_size = sizeof news};
    unsigned found = 0;
    while (lum_keeper_next(run.keeper, &news)) {
        note(news.kind);
        note(news.status);
        found += news.kind == asked;
        if (is_of_laser(news.kind)) {
            check_laser(&news);
        } else {
            check_contact(&news);
        }
        if (run.hash % 64u == 0) {
            check_text(&news);
        }
    }
    REQUIRE(model.expected == 0);
    return found;
}

/* --- Steps --- */

static uint8_t take_byte(void)
{
    if (run.left == 0) {
        return 0;
    }
    run.left--;
    return *run.next++;
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
    static const lum_laser_state states[] = {[ALONE] = LUM_LASER_UNTOUCHED,
                                             [RISING] = LUM_LASER_ASKED,
                                             [UP] = LUM_LASER_UP,
                                             [DOWN] = LUM_LASER_LEFT};
    lum_keeper_view view = {.struct_size = sizeof view};
    lum_news news[4] = {{.struct_size = sizeof news[0]}};
    REQUIRE(lum_keeper_look(run.keeper, &view) == LUM_OK);
    REQUIRE(view.laser == states[model.phase]);
    REQUIRE(view.is_off_due == (model.owes || model.trusts));
    REQUIRE(view.has_status == model.has_status);
    REQUIRE(!view.has_status || view.status == model.status);
    REQUIRE(view.has_data == model.has_data);
    REQUIRE(view.is_unheard == model.is_unheard);
    const size_t count =
        lum_keeper_standing(run.keeper, run.now_ns, news, 1u + run.hash % 4u);
    REQUIRE(count <= 4);
    for (size_t i = 0; i < count; i++) {
        REQUIRE(lum_news_name(news[i].kind) != NULL);
    }
    if (lum_keeper_darkness(run.keeper, &news[0])) {
        REQUIRE(model.has_status && !is_shown_up(model.status));
        REQUIRE(news[0].kind == LUM_NEWS_HAZARD ||
                lum_news_is_dark(news[0].kind));
    }
}

static void pass(int64_t ns)
{
    run.now_ns += ns;
    const int64_t stood_ns = run.now_ns - model.tick_ns;
    const bool moves = run.session.is_moved && !model.is_moved;
    model.tick_ns = run.now_ns;
    if (model.phase == RISING && stood_ns >= 2 * SECOND) {
        fall(LUM_NEWS_LASER_HELD_UP, 0, true);
    }
    model.is_moved = run.session.is_moved;
    model_pass();
    const char next = model_next();
    run.asked = 0;
    lum_keeper_serve(run.keeper, &run.session, run.now_ns);
    REQUIRE(run.asked == next);
    REQUIRE(stood_ns < 2 * SECOND || run.asked != 'u');
    if (run.asked != 0) {
        model_sent(run.asked);
    }
    REQUIRE(!run.session.is_waiting || run.session.request != 'u' ||
            model.phase == RISING || run.session.refuses);
    const unsigned told = drain(LUM_NEWS_MOVED);
    REQUIRE(told == moves);
    REQUIRE(model.is_quiet || model.is_moved || !model.has_data ||
            !is_silent(model.data_ns));
}

static void take(const lum_sensor_event *event)
{
    model_pass();
    lum_keeper_take(run.keeper, event, run.now_ns);
}

static lum_tlv_reader words(uint8_t packet[64], bool has_text)
{
    uint32_t number = 0;
    lum_tlv_reader reader;
    lum_tlv_writer w;
    REQUIRE(lum_tlv_begin(&w, packet, 64, 1) == LUM_OK);
    if (has_text) {
        REQUIRE(lum_tlv_add(&w, 3, "hot\n\xff", 5) == LUM_OK);
    }
    REQUIRE(lum_tlv_open(packet, w.len, &number, &reader) == LUM_OK);
    return reader;
}

static void answer(uint8_t how)
{
    const bool has_status = how % 8u > 1;
    const bool has_text = how >= 224;
    uint8_t packet[64];
    const uint16_t status = take_status();
    const char request = run.session.request;
    const lum_sensor_event event = {.kind = LUM_SENSOR_ANSWER,
                                    .tlvs = words(packet, has_text),
                                    .has_status = has_status,
                                    .status = status};
    if (!run.session.is_waiting) {
        return;
    }
    run.session.is_waiting = false;
    const bool is_blind = !has_status && !model.told_blind;
    const bool is_judged = request == 'u' && model.phase == RISING;
    model.is_unheard = false;
    model.heard_ns = run.now_ns;
    model.told_off = false;
    model.told_blind = !has_status;
    model_answer(request, has_status, status);
    model.hazards &= has_status ? status : UINT16_MAX;
    take(&event);
    const unsigned told = drain(LUM_NEWS_NO_STATUS);
    REQUIRE(told == (is_blind && !is_judged));
    model.told_unheard = false;
}

static void alert(uint8_t how)
{
    uint8_t packet[64];
    const uint16_t status = take_status();
    const lum_sensor_event event = {.kind = LUM_SENSOR_ALERT,
                                    .tlvs = words(packet, how % 4u == 1),
                                    .has_status = how % 4u != 0,
                                    .status = status};
    model_alert(event.has_status, status);
    take(&event);
    (void)drain(LUM_NEWS_END);
}

static void no_answer(uint8_t how)
{
    (void)how;
    const lum_sensor_event event = {.kind = LUM_SENSOR_NO_ANSWER, .tries = 4};
    if (run.session.is_waiting) {
        const bool is_news = run.session.request == 'd' && !model.told_off;
        run.session.is_waiting = false;
        model.is_unheard = true;
        model_no_answer(run.session.request);
        take(&event);
        const unsigned told = drain(LUM_NEWS_OFF_UNANSWERED);
        REQUIRE(told == is_news);
    }
}

static void other(uint8_t how)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_LINK, LUM_SENSOR_LINK,      LUM_SENSOR_IDLE,
        LUM_SENSOR_TIME, LUM_SENSOR_CANCELLED, LUM_SENSOR_FAILED};
    const lum_sensor_event event = {.kind = kinds[how % 6u],
                                    .has_status = true,
                                    .status = take_status(),
                                    .is_up = how % 6u == 0};
    take(&event);
    const unsigned told =
        drain(how % 6u == 0 ? LUM_NEWS_LINK_UP : LUM_NEWS_LINK_DOWN);
    REQUIRE(told == (how % 6u < 2));
}

/* A packet, with the sensor's clock or any. */
static void arrive(uint8_t how)
{
    lum_layout layout;
    uint8_t bytes[64] = {0};
    size_t len = 0;
    const bool is_spoiled = how % 8u == 0;
    lum_group group = {.tag = LUM_TAG_RANGES, .num_samples = 1};
    lum_layout_default(&layout);
    if (how % 8u == 1) {
        run.boot_ns = run.now_ns;
    } else if (how % 8u == 2) {
        run.utc_ns += how * SECOND;
    }
    model.may_restart |= how % 8u == 1;
    model.may_restart |= is_spoiled && (model.was_spoiled || !model.has_data);
    model.was_spoiled = is_spoiled;
    group.clock_raw = is_spoiled
                          ? (uint32_t)how << 24
                          : (uint32_t)((run.now_ns - run.boot_ns) / 1000);
    REQUIRE(lum_group_encode(&layout, &group, bytes, sizeof bytes, &len) ==
            LUM_OK);
    const lum_received datagram = {bytes, len + 4u, home,
                                   run.now_ns + run.utc_ns, false};
    const lum_sensor_event event = {.kind = LUM_SENSOR_DATAGRAMS,
                                    .datagrams = &datagram,
                                    .datagram_count = 1};
    const bool was_quiet = model.is_quiet;
    model.has_data = true;
    model.data_ns = run.now_ns;
    take(&event);
    const unsigned told = drain(LUM_NEWS_BACK);
    REQUIRE(told == was_quiet);
}

static void command(uint8_t how)
{
    static const char *const texts[] = {"u",     "d",   "50p",
                                        "50p u", "u d", "d u 1h"};
    const char *text = texts[how % 6u];
    if (how >= 128) {
        lum_sensor_give_up(&run.session);
    }
    const bool is_taken = !run.session.is_waiting && !run.session.refuses;
    run.is_user = true;
    REQUIRE((lum_keeper_command(run.keeper, &run.session, text, run.now_ns) ==
             LUM_OK) == is_taken);
    run.is_user = false;
    if (is_taken) {
        if (switch_of(text) != OTHER) {
            model_want(switch_of(text) == 'u' ? LUM_WANT_ON : LUM_WANT_OFF);
        }
        model_sent(switch_of(text));
    }
}

static void lend(uint8_t how)
{
    const bool is_on = how % 4u == 0;
    run.session.is_waiting = true;
    run.session.request = OTHER;
    if (is_on) {
        lum_keeper_want(run.keeper, LUM_WANT_GUARD, run.now_ns);
    }
    lum_keeper_lend(run.keeper, run.now_ns);
    if (is_on) {
        model_want(LUM_WANT_GUARD);
    }
    model_sent(OTHER);
}

static void end(uint8_t how)
{
    static const lum_news_kind kinds[] = {
        [LUM_LASER_OFF_SEEN] = LUM_NEWS_ENDED_OFF,
        [LUM_LASER_OFF_UNKNOWN] = LUM_NEWS_ENDED_UNKNOWN,
        [LUM_LASER_OFF_REFUSED] = LUM_NEWS_ENDED_ON,
        [LUM_LASER_OFF_UNSEEN] = LUM_NEWS_ENDED_UNSEEN};
    const lum_laser_off off = (lum_laser_off)(how % 4u);
    const bool is_there = how < 200;
    const bool goes_on = how % 8u > 3;
    const bool tells =
        is_there && (off == LUM_LASER_OFF_SEEN || off == LUM_LASER_OFF_REFUSED);
    const bool is_up = how % 16u < 8;
    run.session.off = off;
    run.session.status = off == LUM_LASER_OFF_SEEN ? OFF
                         : is_up                   ? ON
                                                   : ON | HOT;
    const lum_laser_off found = is_there ? off : LUM_LASER_OFF_UNKNOWN;
    lum_news_kind kind = kinds[found];
    if (goes_on &&
        (found == LUM_LASER_OFF_UNKNOWN || found == LUM_LASER_OFF_REFUSED)) {
        kind = LUM_NEWS_OFF_GOES_ON;
    } else if (found == LUM_LASER_OFF_REFUSED && !is_up) {
        kind = LUM_NEWS_ENDED_IN_EFFECT;
    }
    model_want(LUM_WANT_OFF);
    if (tells) {
        model.has_status = true;
        model.status = run.session.status;
    }
    model.owes = found != LUM_LASER_OFF_SEEN;
    REQUIRE(lum_keeper_end(run.keeper, is_there ? &run.session : NULL, 3000,
                           goes_on ? 7000 : 0, NULL) == found);
    if (!is_there) {
        run.session.is_waiting = false; /* its socket is closed */
    }
    model.is_moved = is_there ? run.session.is_moved : model.is_moved;
    REQUIRE(drain(kind) == 1);
}

/* Without a look at the news: of a full queue the oldest are lost. */
static void overflow(uint8_t how)
{
    const lum_sensor_event event = {.kind = LUM_SENSOR_LINK, .is_up = true};
    const lum_sensor_event last = {.kind = LUM_SENSOR_LINK};
    const unsigned ups = how % 100u;
    for (unsigned i = 0; i < ups; i++) {
        take(&event);
    }
    take(&last);
    const unsigned kept = ups < LUM_KEEPER_NEWS ? ups : LUM_KEEPER_NEWS - 1u;
    REQUIRE(drain(LUM_NEWS_LINK_UP) == kept);
}

static void want(uint8_t how)
{
    const lum_laser_want laser = (lum_laser_want)(how % 4u);
    model_want(laser);
    lum_keeper_want(run.keeper, laser, run.now_ns);
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
    lum_keeper_note_owner(run.keeper, how >= 128);
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
    lum_keeper_options options;
    lum_error error;
    memset(&run, 0, sizeof run);
    memset(&model, 0, sizeof model);
    run.next = data;
    run.left = size;
    run.now_ns = SECOND;
    run.utc_ns = 1000 * SECOND;
    const uint8_t how = take_byte();
    lum_sensor_options_default(&session);
    lum_keeper_options_default(&options, &session);
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
    REQUIRE(lum_keeper_new(&options, run.now_ns, &run.keeper, &error) == 0);
    while (run.left > 0) {
        step();
    }
    lum_keeper_free(run.keeper);
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
        (void)LLVMFuzzerTestOneInput(input, 1u + (state >> 33) % 255u);
    }
    return 0;
}
#endif
