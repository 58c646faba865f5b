/* What is said about a live sensor: the texts of the news, and what finds those
 * of its data and its answers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "live/contact.h"
#include "lum/laser.h"
#include "lum/live/news.h"

#include <stdio.h>
#include <string.h>

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define NOTHING ((lum_news_kind)0)
#define ON      LUM_LASER_TLV_CMD_ON
#define OFF     LUM_LASER_TLV_CMD_OFF
#define BAD     LUM_LASER_HW_SAFETY_BAD

/* --- Texts --- */

#define CTL "lumctl --host 10.42.0.37 --interface eth0"

/* Of each kind its name, its weight and what is said. */
static const char *const golden[] = {
    "laser-up, info: the laser of 10.42.0.37 is on",
    "laser-fell, error: the laser of 10.42.0.37 went off (HW_SAFETY_BAD); it "
    "is not switched on again automatically: when it is safe, run lumctl "
    "--host 10.42.0.37 --interface eth0 laser on",
    "laser-refused, error: the laser of 10.42.0.37 stays down "
    "(HW_SAFETY_BAD); it is not switched on again automatically: when it is "
    "safe, run lumctl --host 10.42.0.37 --interface eth0 laser on",
    "laser-unseen, error: 10.42.0.37 answered to laser on without a status: "
    "whether it is on is not known, so it is being switched off; correct "
    "tlv.status in the profile: it says 2",
    "laser-unanswered, error: 10.42.0.37 did not answer to laser on in 4 "
    "tries: it is being switched off; look with lumctl --host 10.42.0.37 "
    "--interface eth0 status",
    "laser-held-up, error: this program was held up for 3.3 s while it "
    "switched the laser of 10.42.0.37 on: it is being switched off; when it "
    "is safe, run lumctl --host 10.42.0.37 --interface eth0 laser on",
    "laser-came-up, warning: another program switched the laser of 10.42.0.37 "
    "on",
    "laser-left, warning: the laser of 10.42.0.37 is off; it is not switched "
    "on again automatically: when it is safe, run lumctl --host 10.42.0.37 "
    "--interface eth0 laser on",
    "laser-is-off, info: the laser of 10.42.0.37 is off; lumctl --host "
    "10.42.0.37 --interface eth0 laser on switches it on",
    "off-unanswered, error: 10.42.0.37 does not answer to laser off: until it "
    "does, its laser may be on, or come on by itself when a hazard ends; stay "
    "out of the beam, or cut its power",
    "hazard, warning: 10.42.0.37 reports a hazard: HW_SAFETY_BAD; lumctl "
    "--host 10.42.0.37 --interface eth0 status says what to look at",
    "text, warning: 10.42.0.37 says: a text",
    "no-answer-yet, warning: no data from 10.42.0.37 within 3.3 s, nor any "
    "answer; is it on, connected and at this address? It boots at 10.42.0.37; "
    "look with lumctl --host 10.42.0.37 --interface eth0 doctor",
    "no-data-yet, warning: no data from 10.42.0.37 within 3.3 s, though it "
    "answers; is a profile needed, or does a firewall drop what is not an "
    "answer? look with lumctl --host 10.42.0.37 --interface eth0 doctor",
    "unknown-layout, warning: 10.42.0.37 sends packets, and none of them fits "
    "the layout; is a --profile needed?",
    "silent, warning: no data from 10.42.0.37 for 3.3 s; heartbeats continue; "
    "lumctl --host 10.42.0.37 --interface eth0 doctor finds out more; after a "
    "restart a sensor is at 10.42.0.37",
    "data-stopped, warning: no data from 10.42.0.37 for 3.3 s, though it "
    "answers; heartbeats continue; another host may own it now; lumctl --host "
    "10.42.0.37 --interface eth0 doctor finds out more",
    "back, warning: data from 10.42.0.37 again, after 3.3 s without",
    "moved, error: the data comes from 10.42.0.99:6000 now, not from "
    "10.42.0.37: the sensor now has that address, so its data is not used and "
    "ends within 3 s; end this session, and begin one with 10.42.0.99:6000",
    "restarted, warning: 10.42.0.37 was restarted: its clock began again; its "
    "settings are lost; when it is safe, run lumctl --host 10.42.0.37 "
    "--interface eth0 laser on",
    "unheard, warning: 10.42.0.37 sends data, but does not answer when asked "
    "for its status; lumctl --host 10.42.0.37 --interface eth0 doctor finds "
    "out why",
    "no-answer, warning: 10.42.0.37 does not answer; lumctl --host 10.42.0.37 "
    "--interface eth0 doctor finds out why",
    "answers, info: 10.42.0.37 answers again",
    "late-answers, warning: 10.42.0.37 answers so late that its answers "
    "cannot be used; lumctl --host 10.42.0.37 --interface eth0 doctor finds "
    "out how late",
    "no-status, warning: 10.42.0.37 answers without a status, so the state of "
    "its laser is unknown; correct tlv.status in the profile: it says 2",
    "link-down, warning: sending to 10.42.0.37 fails: a text; it is retried; "
    "lumctl --host 10.42.0.37 --interface eth0 doctor finds out why",
    "link-up, warning: sending to 10.42.0.37 works again",
    "off-goes-on, warning: 10.42.0.37: laser on is still in effect: laser off "
    "is repeated for 3.3 s more",
    "ended-off, info: 10.42.0.37: the laser is off",
    "ended-unknown, error: 10.42.0.37: laser off was not answered: it MAY BE "
    "ON or come on by itself; a working sensor switches it off within 3 s, "
    "because the heartbeats have ended; make sure by lumctl --host "
    "10.42.0.99:6000 --interface eth0 laser off, or cut its power",
    "ended-unseen, error: 10.42.0.37: laser off was answered without a status "
    "TLV, so it is not confirmed off: it MAY BE ON or come on by itself; a "
    "working sensor switches it off within 3 s, because the heartbeats have "
    "ended; correct tlv.status in the profile: it says 2",
    "ended-in-effect, error: 10.42.0.37: LASER ON IS STILL IN EFFECT after "
    "laser off: the laser comes up by itself when what keeps it down ends "
    "(status: HW_SAFETY_BAD TLV_CMD_ON); make sure by lumctl --host "
    "10.42.0.99:6000 --interface eth0 laser off, or cut its power",
    "ended-on, error: 10.42.0.37: THE LASER IS STILL ON after laser off "
    "(status: HW_SAFETY_BAD TLV_CMD_ON); make sure by lumctl --host "
    "10.42.0.99:6000 --interface eth0 laser off, or cut its power",
};

#define GOLDEN (sizeof golden / sizeof golden[0])

/* With a value for each word. */
static lum_news news_of(lum_news_kind kind)
{
    return (lum_news){.struct_size = sizeof(lum_news),
                      .kind = kind,
                      .sensor = {0x0a2a0025, 5517},
                      .interface_name = "eth0",
                      .to = {0x0a2a0063, 6000},
                      .status = ON | BAD,
                      .tlv_status = 2,
                      .tries = 4,
                      .is_owner = true,
                      .ns = kind == LUM_NEWS_LASER_FELL ? 0 : 3250 * MS,
                      .text = "a text"};
}

static void each_kind_has_its_name_weight_and_text(void **state)
{
    static const char *const weights[] = {"info", "warning", "error"};
    (void)state;
    assert_int_equal(GOLDEN, LUM_NEWS_END - 1);
    assert_int_equal(LUM_NEWS_ENDED_ON, 33);
    for (size_t i = 0; i < GOLDEN; i++) {
        const lum_news news = news_of((lum_news_kind)(i + 1u));
        char text[LUM_ERROR_BYTES];
        char fix[LUM_ERROR_BYTES];
        char all[2 * LUM_ERROR_BYTES];
        (void)snprintf(all, sizeof all, "%s, %s: %s", lum_news_name(news.kind),
                       weights[lum_news_weigh(news.kind)],
                       lum_news_tell(&news, text, sizeof text));
        assert_string_equal(all, golden[i]);
        (void)lum_news_sentence(&news, all, sizeof all);
        (void)lum_news_fix(&news, fix, sizeof fix);
        strcat(strcat(all, fix[0] != '\0' ? "; " : ""), fix);
        assert_string_equal(all, text);
    }
}

static void each_text_is_cut_to_its_room(void **state)
{
    (void)state;
    for (size_t i = 0; i < GOLDEN; i++) {
        const lum_news news = news_of((lum_news_kind)(i + 1u));
        const char *golden_text = strstr(golden[i], ": ") + 2;
        for (size_t room = 1; room <= strlen(golden_text) + 1u; room++) {
            char text[LUM_ERROR_BYTES];
            memset(text, '#', sizeof text);
            assert_ptr_equal(lum_news_tell(&news, text, room), text);
            assert_memory_equal(text, golden_text, room - 1u);
            assert_int_equal(text[room - 1u], '\0');
            assert_int_equal(text[room], '#');
        }
    }
}

static void what_is_no_kind_has_no_text(void **state)
{
    static const int kinds[] = {0, -1, LUM_NEWS_END, 1000};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        const lum_news news = news_of((lum_news_kind)kinds[i]);
        char text[8] = "#";
        assert_null(lum_news_name(news.kind));
        assert_int_equal(lum_news_weigh(news.kind), LUM_NEWS_INFO);
        assert_false(lum_news_is_dark(news.kind));
        assert_string_equal(lum_news_tell(&news, text, sizeof text), "");
    }
}

static void those_of_a_laser_that_is_down_are_dark(void **state)
{
    (void)state;
    for (int kind = LUM_NEWS_LASER_UP; kind < LUM_NEWS_END; kind++) {
        assert_int_equal(lum_news_is_dark((lum_news_kind)kind),
                         kind >= LUM_NEWS_LASER_FELL &&
                             kind <= LUM_NEWS_LASER_IS_OFF &&
                             kind != LUM_NEWS_LASER_CAME_UP);
    }
}

#define HOME  .sensor = {0x0a2a0025, 5517}
#define ROOM  HOME, .interface_name = "eth0"
#define FELL  ROOM, .kind = LUM_NEWS_LASER_FELL
#define STILL ROOM, .kind = LUM_NEWS_ENDED_ON
#define GOES  ROOM, .kind = LUM_NEWS_OFF_GOES_ON
#define BACK  ROOM, .kind = LUM_NEWS_BACK

/* And a part of what is said. */
static const struct {
    lum_news news;
    const char *part;
} parts[] = {
    /* ways to a sensor */
    {{.kind = LUM_NEWS_NO_ANSWER, .sensor = {0x0a2a0025, 0}},
     "10.42.0.37 does not answer; lumctl --host 10.42.0.37 doctor"},
    {{.kind = LUM_NEWS_NO_ANSWER, .sensor = {0x0a2a0025, 6000}},
     "10.42.0.37:6000 does not answer; lumctl --host 10.42.0.37:6000 doctor"},
    {{ROOM, .kind = LUM_NEWS_ENDED_UNKNOWN, .is_owner = true},
     "make sure by " CTL " laser off"},
    {{ROOM, .kind = LUM_NEWS_ENDED_UNKNOWN},
     "3 s after the last heartbeat; end the programs that send heartbeats, or "
     "cut its power"},
    {{ROOM, .kind = LUM_NEWS_LASER_LEFT, .to = {0x0a2a0063, 5517}},
     CTL " laser on"},
    /* bits, and what put it down */
    {{FELL, .status = ON}, "went off (none);"},
    {{FELL},
     "went off (TLV_CMD_ON is gone, as after a restart of the sensor);"},
    {{FELL, .status = UINT16_MAX},
     "(GALVO_AMP_BX_BAD GALVO_AMP_BY_BAD GALVO_AMP_GX_BAD GALVO_AMP_GY_BAD "
     "HEARTBEAT_TIMEOUT BOARD_OVER_105 FAN_PWM_BAD HW_SAFETY_BAD "
     "SYS_ON_SW_OFF TLV_CMD_OFF BIT_10)"},
    {{FELL, .status = OFF | BAD}, "(HW_SAFETY_BAD TLV_CMD_OFF);"},
    {{FELL, .status = OFF | 1}, "(GALVO_AMP_BX_BAD TLV_CMD_OFF);"},
    {{FELL, .status = OFF | 256}, "(SYS_ON_SW_OFF TLV_CMD_OFF);"},
    {{FELL, .status = ON | BAD}, "(HW_SAFETY_BAD);"},
    {{FELL, .status = OFF},
     "(TLV_CMD_OFF: switched off by another program's command, or when no "
     "heartbeat came for 3 s);"},
    {{FELL, .status = OFF, .was_away = true},
     "(TLV_CMD_OFF: the sensor was restarted, or got no heartbeat for 3 s);"},
    {{FELL, .status = OFF, .was_away = true, .ns = 3 * SECOND},
     "(TLV_CMD_OFF: this program sent no heartbeats for 3 s);"},
    {{STILL, .status = ON | BAD}, "(status: HW_SAFETY_BAD TLV_CMD_ON)"},
    {{STILL, .status = 0x8001}, "(status: GALVO_AMP_BX_BAD BIT_15)"},
    {{STILL}, "(status: none)"},
    /* where it stands */
    {{GOES, .tries = 1, .status = ON, .tlv_status = 2},
     "the laser is still on: "},
    {{GOES, .status = ON}, "10.42.0.37: no answer yet: laser off"},
    {{ROOM, .kind = LUM_NEWS_LASER_IS_OFF, .status = 1},
     "the laser of 10.42.0.37 is off;"},
    {{ROOM, .kind = LUM_NEWS_LASER_IS_OFF},
     "the laser of 10.42.0.37 is not confirmed on;"},
    {{ROOM, .kind = LUM_NEWS_LASER_LEFT, .was_away = true},
     "10.42.0.37 is being switched off;"},
    /* seconds are rounded */
    {{BACK, .ns = 3050 * MS - 1}, "after 3 s"},
    {{BACK, .ns = 3050 * MS}, "after 3.1 s"},
    {{BACK, .ns = 9950 * MS - 1}, "after 9.9 s"},
    {{BACK, .ns = 9950 * MS}, "after 10 s"},
    {{BACK, .ns = 1234 * SECOND}, "after 1234 s"},
    {{BACK}, "after 0 s"},
};

static void values_are_put_into_words(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        char text[LUM_ERROR_BYTES];
        (void)lum_news_tell(&parts[i].news, text, sizeof text);
        if (strstr(text, parts[i].part) == NULL) {
            fail_msg("%s is not in: %s", parts[i].part, text);
        }
    }
}

static void commands_name_an_interface_as_a_shell_takes_it(void **state)
{
    static const char *const cases[][2] = {
        {NULL, "lumctl --host 10.42.0.37"},
        {"", "lumctl --host 10.42.0.37"},
        {"eth0", CTL},
        {"Ethernet 2", "lumctl --host 10.42.0.37 --interface \"Ethernet 2\""}};
    const lum_endpoint sensor = {0x0a2a0025, 5517};
    char text[LUM_ERROR_BYTES];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_ptr_equal(lum_news_ctl(sensor, cases[i][0], text, sizeof text),
                         text);
        assert_string_equal(text, cases[i][1]);
    }
    assert_string_equal(lum_news_ctl(sensor, NULL, text, 7), "lumctl");
}

static void a_long_interface_is_cut(void **state)
{
    char name[400];
    char text[LUM_ERROR_BYTES];
    lum_news news = news_of(LUM_NEWS_ENDED_ON);
    (void)state;
    memset(name, 'e', sizeof name);
    name[sizeof name - 1u] = '\0';
    news.interface_name = name;
    (void)lum_news_tell(&news, text, sizeof text);
    assert_non_null(strstr(text, "eeee"));
    assert_true(strlen(text) < sizeof text);
}

/* --- Stories of a sensor --- */

typedef enum what {
    ANSWER,
    BLIND, /* an answer without a status */
    NO_ANSWER,
    DOWN, /* the link */
    UP,
    DATA,
    MOVES,
    STAYS,
    LATE,    /* an answer that fits no request */
    FOREIGN, /* a packet of another layout */
    PASS,
    TICK,
    GUEST_TICK, /* of who is no owner */
    SHOWS,      /* what holds is asked for */
    AWAY,       /* it was, a moment ago */
    NOT_AWAY,
    CLOCK, /* a packet with such ticks */
    ODD,   /* one whose ticks fit to none before */
    ANEW,  /* one that shows a restart */
    UTC,   /* of those that follow, in ns; 0: as the host's other clock */
    BYTES, /* of the clock */
    BITS,
    UNIT_NS
} what;

/* What happens, and the news of it. */
typedef struct step {
    int64_t ns; /* contact begins at a second; 0: no step */
    what what;
    lum_news_kind news;
    uint64_t number; /* from CLOCK on */
} step;

typedef struct story {
    const char *fact;
    step steps[18];
} story;

#define AT(ns, what)                                                           \
    {                                                                          \
        ns, what, NOTHING, 0                                                   \
    }
#define TOLD(ns, what, news)                                                   \
    {                                                                          \
        ns, what, LUM_NEWS_##news, 0                                           \
    }
#define READ(ns, what, number)                                                 \
    {                                                                          \
        ns, what, NOTHING, number                                              \
    }
#define S SECOND
#define M UINT64_C(1000000) /* ticks of a second */

static story stories[] = {
    {"data that stops is told once, and again when it is back",
     {AT(2 * S, DATA), AT(5 * S - 1, TICK), AT(5 * S - 1, SHOWS),
      TOLD(5 * S, TICK, SILENT), AT(9 * S, TICK), TOLD(9 * S, SHOWS, SILENT),
      TOLD(10 * S, DATA, BACK), AT(10 * S, DATA), AT(10 * S, SHOWS),
      TOLD(13 * S, TICK, SILENT)}},
    {"what a program does not listen to is no silence",
     {AT(2 * S, PASS), AT(2 * S, DATA), AT(4 * S, PASS), AT(7 * S - 1, TICK),
      TOLD(7 * S, TICK, SILENT)}},
    {"whose answers go on has lost its client",
     {AT(2 * S, DATA), AT(3 * S + 1, ANSWER), TOLD(5 * S, TICK, DATA_STOPPED)}},
    {"whose answers ended has not",
     {AT(2 * S, DATA), AT(3 * S, ANSWER), TOLD(5 * S, TICK, SILENT)}},
    {"a pause explains what is seen for 5 s",
     {AT(9 * S, NOT_AWAY), AT(2 * S, DATA), AT(3 * S - 1, NOT_AWAY),
      AT(3 * S, AWAY), AT(3 * S - 1, DATA), AT(3 * S, NOT_AWAY),
      AT(4 * S - 1, DATA), AT(4 * S, AWAY), AT(4900 * MS, DATA),
      AT(5800 * MS, DATA), AT(6700 * MS, DATA), AT(7600 * MS, DATA),
      AT(8500 * MS, DATA), AT(9 * S - 2, AWAY), AT(9 * S - 1, NOT_AWAY)}},
    {"a sensor that moves is not silent",
     {AT(2 * S, DATA), AT(2 * S, STAYS), TOLD(2 * S, MOVES, MOVED),
      AT(2 * S, MOVES), AT(9 * S, TICK), TOLD(9 * S, DOWN, LINK_DOWN),
      TOLD(9 * S, SHOWS, MOVED), AT(9 * S, STAYS),
      TOLD(9 * S, SHOWS, LINK_DOWN), TOLD(9 * S, UP, LINK_UP),
      TOLD(9 * S, SHOWS, SILENT), TOLD(9 * S, MOVES, MOVED)}},
    {"an owner that hears nothing is told so once",
     {AT(4 * S - 1, TICK), AT(4 * S - 1, SHOWS), AT(4 * S, GUEST_TICK),
      TOLD(4 * S, TICK, NO_ANSWER_YET), AT(4 * S, TICK),
      TOLD(4 * S, SHOWS, NO_ANSWER_YET), AT(5 * S, DATA), AT(5 * S, SHOWS)}},
    {"but not for what it did not listen to",
     {AT(3 * S, PASS), AT(6 * S - 1, TICK), TOLD(6 * S, TICK, NO_ANSWER_YET)}},
    {"and one whose packets are of another layout",
     {AT(2 * S, ANSWER), AT(2 * S, FOREIGN), TOLD(4 * S, TICK, UNKNOWN_LAYOUT),
      TOLD(4 * S, SHOWS, UNKNOWN_LAYOUT)}},
    {"no answers and no data are told once",
     {AT(2 * S, NO_ANSWER), AT(2 * S, ANSWER), AT(2 * S, LATE),
      AT(2 * S, GUEST_TICK), AT(2 * S, NO_ANSWER), AT(2 * S, SHOWS),
      TOLD(3 * S, GUEST_TICK, NO_ANSWER), AT(4 * S, LATE),
      AT(4 * S, GUEST_TICK), TOLD(4 * S, ANSWER, ANSWERS), AT(4 * S, ANSWER),
      /* those that came meanwhile were late ones, too */
      AT(4 * S, NO_ANSWER), TOLD(4 * S, GUEST_TICK, LATE_ANSWERS)}},
    {"no answers beside data are told 5 s after a pause of it",
     {AT(2 * S, DATA), AT(2 * S, NO_ANSWER), TOLD(2 * S, SHOWS, UNHEARD),
      AT(3 * S, GUEST_TICK), AT(3 * S, DATA), AT(3900 * MS, DATA),
      AT(4800 * MS, DATA), AT(5700 * MS, DATA), AT(6600 * MS, DATA),
      AT(7500 * MS, DATA), AT(8 * S - 1, GUEST_TICK),
      TOLD(8 * S, GUEST_TICK, UNHEARD), AT(8 * S, GUEST_TICK)}},
    {"answers without a status are told once",
     {TOLD(S, BLIND, NO_STATUS), AT(S, BLIND), AT(S, ANSWER),
      TOLD(S, BLIND, NO_STATUS), AT(S, NO_ANSWER), TOLD(S, TICK, NO_ANSWER),
      TOLD(S, BLIND, ANSWERS)}},
    {"a clock that begins anew is a restart",
     {READ(10 * S, CLOCK, 500 * M), READ(11 * S, CLOCK, 501 * M),
      READ(15 * S, ODD, 1 * M), AT(16 * S, NOT_AWAY), READ(16 * S, UTC, 99 * S),
      READ(16 * S, ANEW, 2 * M), READ(16 * S, UTC, 0), AT(21 * S - 1, AWAY),
      AT(21 * S, NOT_AWAY), READ(17 * S, CLOCK, 3 * M), AT(21 * S - 1, AWAY),
      READ(18 * S, ODD, 504 * M), READ(19 * S, CLOCK, 5 * M)}},
    {"one that wraps is none",
     {READ(10 * S, CLOCK, UINT32_MAX - M), READ(12 * S, CLOCK, M),
      READ(13 * S, CLOCK, 2 * M),
      READ(13 * S + INT64_C(4294967296000), CLOCK, 2 * M),
      READ(14 * S + INT64_C(4294967296000), CLOCK, 3 * M)}},
    {"a damaged packet is none, nor are two that do not fit",
     {READ(10 * S, CLOCK, 500 * M), READ(11 * S, ODD, 3000 * M),
      READ(12 * S, CLOCK, 502 * M), READ(13 * S, ODD, 3002 * M),
      READ(14 * S, ODD, 2000 * M), READ(15 * S, CLOCK, 505 * M),
      /* one that fits to it goes on from before, too */
      READ(16 * S, ODD, 508500000), READ(17 * S, CLOCK, 508500000)}},
    {"packets that waited while a program stood still are none",
     {READ(10 * S, UTC, 1000 * S), READ(10 * S, CLOCK, 500 * M),
      READ(70 * S, UTC, 1001 * S), READ(70 * S, CLOCK, 501 * M),
      READ(70 * S, UTC, 1030 * S), READ(70 * S, CLOCK, 530 * M),
      READ(70 * S, UTC, 1060 * S), READ(70 * S, CLOCK, 560 * M)}},
    {"a host's clock that is set is none",
     {READ(70 * S, UTC, 1060 * S), READ(70 * S, CLOCK, 560 * M),
      READ(71 * S, UTC, 5000 * S), READ(71 * S, CLOCK, 561 * M),
      READ(72 * S, UTC, 100 * S), READ(72 * S, CLOCK, 562 * M),
      READ(73 * S, UTC, 101 * S), READ(73 * S, CLOCK, 563 * M)}},
    {"a clock may be off by 2 s and a hundredth of the time",
     {READ(10 * S, CLOCK, 500 * M), READ(110 * S, ODD, 603 * M + 1),
      READ(110 * S, CLOCK, 603 * M), READ(210 * S, ODD, 700 * M - 1),
      READ(210 * S, CLOCK, 700 * M)}},
    {"its ticks may be a nanosecond",
     {READ(S, UNIT_NS, 1), READ(S, BYTES, 8), READ(10 * S, CLOCK, 0),
      READ(10 * S, ODD, 2000000001), READ(10 * S, CLOCK, 2000000000)}},
    {"no clock fits to a time before the last",
     {READ(10 * S, CLOCK, 0),
      READ(10 * S - 1, ODD, UINT64_MAX / 1000u & UINT32_MAX)}},
    {"of a wide clock 63 bits are looked at",
     {READ(S, BYTES, 8), READ(10 * S, CLOCK, 500 * M), READ(11 * S, ODD, 1 * M),
      READ(12 * S, ANEW, 2 * M), READ(13 * S, CLOCK, 3 * M | UINT64_C(1) << 63),
      READ(14 * S, ODD, 4 * M | UINT64_C(1) << 62)}},
    {"of a narrower one its bits are",
     {READ(S, BYTES, 8), READ(S, BITS, 62), READ(10 * S, CLOCK, 500 * M),
      READ(11 * S, CLOCK, 501 * M | UINT64_C(1) << 62), READ(S, BITS, 40),
      READ(12 * S, ODD, 1 * M), READ(13 * S, ANEW, 2 * M)}},
};

static lum_contact contact;
static lum_layout layout;
static uint64_t dropped;
static uint64_t utc_ns;

static lum_news_kind read_clock(const step *s)
{
    const lum_group group = {.clock_raw = s->number};
    const lum_news_kind news =
        lum_contact_note_clock(&contact, &layout.profile, &group, s->ns,
                               utc_ns != 0 ? (int64_t)utc_ns : s->ns);
    assert_int_equal(contact.odd.is_there, s->what == ODD);
    assert_int_equal(news, s->what == ANEW ? LUM_NEWS_RESTARTED : NOTHING);
    return NOTHING;
}

static void set(const step *s)
{
    lum_field *field = &layout.profile.group[LUM_FIELD_TIMESTAMP];
    const uint8_t value = (uint8_t)s->number;
    field->bytes = s->what == BYTES ? value : field->bytes;
    field->bits = s->what == BITS ? value : field->bits;
    layout.profile.clock_unit_ns =
        s->what == UNIT_NS ? value : layout.profile.clock_unit_ns;
    utc_ns = s->what == UTC ? s->number : utc_ns;
    contact.has_unknown |= s->what == FOREIGN;
    dropped += s->what == LATE;
}

static lum_news_kind take(const step *s)
{
    static const lum_sensor_event events[] = {
        [ANSWER] = {.kind = LUM_SENSOR_ANSWER, .has_status = true},
        [BLIND] = {.kind = LUM_SENSOR_ANSWER},
        [NO_ANSWER] = {.kind = LUM_SENSOR_NO_ANSWER, .has_status = true},
        [DOWN] = {.kind = LUM_SENSOR_LINK, .has_status = true},
        [UP] = {.kind = LUM_SENSOR_LINK, .has_status = true, .is_up = true}};
    switch ((int)s->what) {
    case DATA:
        return lum_contact_note_data(&contact, s->ns);
    case MOVES:
    case STAYS:
        return lum_contact_move(&contact, s->what == MOVES);
    case PASS:
        lum_contact_pass(&contact, s->ns);
        return NOTHING;
    case TICK:
    case GUEST_TICK:
        return lum_contact_tick(&contact, s->what == TICK, dropped, s->ns);
    case SHOWS:
        return lum_contact_standing(&contact, s->ns);
    case AWAY:
    case NOT_AWAY:
        assert_int_equal(lum_contact_was_away(&contact, s->ns),
                         s->what == AWAY);
        return NOTHING;
    case CLOCK:
    case ODD:
    case ANEW:
        return read_clock(s);
    default:
        set(s);
        return s->what <= UP
                   ? lum_contact_take(&contact, &events[s->what], s->ns)
                   : NOTHING;
    }
}

static void play(void **state)
{
    const story *told = *state;
    lum_layout_default(&layout);
    lum_contact_begin(&contact, SECOND);
    dropped = 0;
    utc_ns = 0;
    for (const step *s = told->steps; s->ns != 0; s++) {
        const lum_news_kind news = take(s);
        if (news != s->news) {
            fail_msg("step %d gives news %d, not %d", (int)(s - told->steps),
                     news, s->news);
        }
    }
}

#define STORIES (sizeof stories / sizeof stories[0])

static struct CMUnitTest tests[STORIES + 7] = {
    cmocka_unit_test(each_kind_has_its_name_weight_and_text),
    cmocka_unit_test(each_text_is_cut_to_its_room),
    cmocka_unit_test(what_is_no_kind_has_no_text),
    cmocka_unit_test(those_of_a_laser_that_is_down_are_dark),
    cmocka_unit_test(values_are_put_into_words),
    cmocka_unit_test(commands_name_an_interface_as_a_shell_takes_it),
    cmocka_unit_test(a_long_interface_is_cut),
};

int main(void)
{
    for (size_t i = 0; i < STORIES; i++) {
        tests[7 + i] =
            (struct CMUnitTest){stories[i].fact, play, NULL, NULL, &stories[i]};
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
