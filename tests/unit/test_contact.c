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

#include <string.h>

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define NOTHING ((lum_news_kind)0)
#define INFO    LUM_NEWS_INFO
#define WARN    LUM_NEWS_WARNING
#define ERROR   LUM_NEWS_ERROR
#define ON      LUM_LASER_TLV_CMD_ON
#define OFF     LUM_LASER_TLV_CMD_OFF
#define BAD     LUM_LASER_HW_SAFETY_BAD

/* --- Texts --- */

#define CTL   "lumctl --host 10.42.0.37 --interface eth0"
#define AGAIN "it is not switched on again automatically: when it is safe, run"

static const struct {
    const char *name;
    lum_news_weight weight;
    const char *text;
} golden[] = {
    {"laser-up", INFO, "the laser of 10.42.0.37 is on"},
    {"laser-fell", ERROR,
     "the laser of 10.42.0.37 went off (HW_SAFETY_BAD); " AGAIN " " CTL
     " laser on"},
    {"laser-refused", ERROR,
     "the laser of 10.42.0.37 stays down (HW_SAFETY_BAD); " AGAIN " " CTL
     " laser on"},
    {"laser-unseen", ERROR,
     "10.42.0.37 answered to laser on without a status: whether it is on is "
     "not known, so it is switched off; tlv.status of the profile says 2"},
    {"laser-unanswered", ERROR,
     "10.42.0.37 did not answer to laser on (sent 4 times): it is switched "
     "off; look with " CTL " status"},
    {"laser-held-up", ERROR,
     "this program was held up for 3.3 s while it switched the laser of "
     "10.42.0.37 on: it is switched off; when it is safe, run " CTL
     " laser on"},
    {"laser-came-up", WARN,
     "the laser of 10.42.0.37 is on, by another program"},
    {"laser-left", WARN,
     "the laser of 10.42.0.37 is off; " AGAIN " " CTL " laser on"},
    {"laser-is-off", INFO,
     "the laser is off; begin with --laser, or run " CTL " laser on"},
    {"off-unanswered", ERROR,
     "10.42.0.37 does not answer to laser off: until it does, its laser may be "
     "on, or come on by itself when a hazard ends"},
    {"hazard", WARN, "10.42.0.37 reports a hazard: HW_SAFETY_BAD"},
    {"text", WARN, "10.42.0.37 says: a text"},
    {"no-answer-yet", WARN,
     "no data from 10.42.0.37 within 3.3 s, nor any answer; is it on, "
     "connected and at this address? It boots at 10.42.0.37; look with " CTL
     " doctor"},
    {"no-data-yet", WARN,
     "no data from 10.42.0.37 within 3.3 s, though it answers; is a profile "
     "needed, or does a firewall drop what is not an answer? look with " CTL
     " doctor"},
    {"unknown-layout", WARN,
     "10.42.0.37 sends packets, and none of them fits the layout; is a "
     "--profile needed?"},
    {"silent", WARN,
     "no data from 10.42.0.37 for 3.3 s; heartbeats go on, waiting; a sensor "
     "that was restarted is at 10.42.0.37 again; " CTL
     " doctor finds out more"},
    {"data-stopped", WARN,
     "no data from 10.42.0.37 for 3.3 s, though it answers; heartbeats go on, "
     "waiting; another host may own it now; " CTL " doctor finds out more"},
    {"back", WARN, "data from 10.42.0.37 again, after 3.3 s without"},
    {"moved", ERROR,
     "the data comes from 10.42.0.99:6000 now, not from 10.42.0.37: the sensor "
     "has got that address. It is not taken, and ends in 3 s, since the "
     "heartbeats go to 10.42.0.37; end this session, and begin one with "
     "udp://10.42.0.99:6000"},
    {"restarted", WARN,
     "10.42.0.37 was restarted: its clock began anew; its laser and its "
     "settings are as after power-up"},
    {"unheard", WARN,
     "10.42.0.37 sends data, but does not answer when asked for its status"},
    {"no-answer", WARN,
     "10.42.0.37 does not answer; " CTL " doctor finds out why"},
    {"answers", INFO, "10.42.0.37 answers again"},
    {"late-answers", WARN,
     "10.42.0.37 answers so late that its answers cannot be used; use a longer "
     "timeout, or look with " CTL " doctor"},
    {"no-status", WARN,
     "10.42.0.37 answers without a status, so nothing shows its laser; "
     "tlv.status of the profile says 2"},
    {"link-down", WARN,
     "sending to 10.42.0.37 fails: a text; it is tried again and again"},
    {"link-up", WARN, "sending to 10.42.0.37 works again"},
    {"off-goes-on", WARN,
     "10.42.0.37: laser on is still in effect: laser off is repeated for 3.3 s "
     "more"},
    {"ended-off", INFO, "10.42.0.37: the laser is off"},
    {"ended-unknown", ERROR,
     "10.42.0.37: laser off was not answered: it MAY BE ON or come on by "
     "itself; a sensor that "
     "lives switches it off 3 s after the last heartbeat, which has been sent; "
     "make sure by lumctl --host 10.42.0.99:6000 --interface eth0 laser off, "
     "or cut its power"},
    {"ended-unseen", ERROR,
     "10.42.0.37: laser off was answered without a status TLV, so nothing "
     "shows it off: it MAY BE ON or come on by itself; a sensor that lives "
     "switches it off 3 s "
     "after the last heartbeat, which has been sent; tlv.status of the profile "
     "says 2"},
    {"ended-in-effect", ERROR,
     "10.42.0.37: LASER ON IS STILL IN EFFECT after laser off: the laser comes "
     "up by itself when what keeps it down ends (status: HW_SAFETY_BAD "
     "TLV_CMD_ON); make sure by lumctl --host 10.42.0.99:6000 --interface eth0 "
     "laser off, or cut its power"},
    {"ended-on", ERROR,
     "10.42.0.37: THE LASER IS STILL ON after laser off (status: HW_SAFETY_BAD "
     "TLV_CMD_ON); make sure by lumctl --host 10.42.0.99:6000 --interface eth0 "
     "laser off, or cut its power"},
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
    (void)state;
    assert_int_equal(GOLDEN, LUM_NEWS_END - 1);
    assert_int_equal(LUM_NEWS_ENDED_ON, 33);
    for (size_t i = 0; i < GOLDEN; i++) {
        const lum_news news = news_of((lum_news_kind)(i + 1u));
        char text[LUM_ERROR_BYTES];
        char remedy[LUM_ERROR_BYTES];
        assert_string_equal(lum_news_name(news.kind), golden[i].name);
        assert_int_equal(lum_news_weigh(news.kind), golden[i].weight);
        assert_string_equal(lum_news_tell(&news, text, sizeof text),
                            golden[i].text);
        (void)lum_news_sentence(&news, text, sizeof text);
        (void)lum_news_remedy(&news, remedy, sizeof remedy);
        if (remedy[0] != '\0') {
            strcat(strcat(text, "; "), remedy);
        }
        assert_string_equal(text, golden[i].text);
    }
}

static void each_text_is_cut_to_its_room(void **state)
{
    (void)state;
    for (size_t i = 0; i < GOLDEN; i++) {
        const lum_news news = news_of((lum_news_kind)(i + 1u));
        const size_t len = strlen(golden[i].text);
        for (size_t room = 1; room <= len + 1u; room++) {
            char text[LUM_ERROR_BYTES];
            memset(text, '#', sizeof text);
            assert_ptr_equal(lum_news_tell(&news, text, room), text);
            assert_memory_equal(text, golden[i].text, room - 1u);
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
        assert_int_equal(lum_news_weigh(news.kind), INFO);
        assert_false(lum_news_is_dark(news.kind));
        assert_string_equal(lum_news_tell(&news, text, sizeof text), "");
        text[0] = '#';
        assert_string_equal(lum_news_sentence(&news, text, sizeof text), "");
        text[0] = '#';
        assert_string_equal(lum_news_remedy(&news, text, sizeof text), "");
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

static void check_has(const lum_news *news, const char *part)
{
    char text[LUM_ERROR_BYTES];
    if (strstr(lum_news_tell(news, text, sizeof text), part) == NULL) {
        fail_msg("%s is not in: %s", part, text);
    }
}

static void ways_to_a_sensor_are_named(void **state)
{
    lum_news news = news_of(LUM_NEWS_NO_ANSWER);
    (void)state;
    news.sensor.port = 0;
    check_has(&news, "10.42.0.37 does not answer; lumctl --host 10.42.0.37 "
                     "--interface eth0 doctor");
    news.sensor.port = 6000;
    news.interface_name = NULL;
    check_has(&news, "10.42.0.37:6000 does not answer; lumctl --host "
                     "10.42.0.37:6000 doctor");
    news = news_of(LUM_NEWS_ENDED_OFF);
    check_has(&news, "10.42.0.37: the");
    news = news_of(LUM_NEWS_ENDED_UNKNOWN);
    news.to = (lum_endpoint){0, 0};
    check_has(&news, "make sure by " CTL " laser off");
    news.is_owner = false;
    check_has(&news, "3 s after the last heartbeat; end the programs that send "
                     "heartbeats, or cut its power");
    news = news_of(LUM_NEWS_LASER_LEFT);
    check_has(&news, CTL " laser on");
}

static void commands_name_an_interface_as_a_shell_takes_it(void **state)
{
    static const struct {
        const char *name;
        const char *text;
    } cases[] = {
        {NULL, "lumctl --host 10.42.0.37"},
        {"", "lumctl --host 10.42.0.37"},
        {"eth0", CTL},
        {"Ethernet 2", "lumctl --host 10.42.0.37 --interface \"Ethernet 2\""}};
    const lum_endpoint sensor = {0x0a2a0025, 5517};
    char text[LUM_ERROR_BYTES];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_ptr_equal(lum_news_ctl(sensor, cases[i].name, text, sizeof text),
                         text);
        assert_string_equal(text, cases[i].text);
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

static void bits_are_named(void **state)
{
    lum_news news = news_of(LUM_NEWS_LASER_FELL);
    (void)state;
    news.status = 0;
    check_has(&news, "went off (none: TLV_CMD_ON is gone, as after a restart "
                     "of the sensor);");
    news.status = UINT16_MAX;
    check_has(&news, "(GALVO_AMP_BX_BAD GALVO_AMP_BY_BAD GALVO_AMP_GX_BAD "
                     "GALVO_AMP_GY_BAD HEARTBEAT_TIMEOUT BOARD_OVER_105 "
                     "FAN_PWM_BAD HW_SAFETY_BAD SYS_ON_SW_OFF TLV_CMD_OFF "
                     "BIT_10)");
    news.status = OFF | BAD;
    check_has(&news, "(HW_SAFETY_BAD TLV_CMD_OFF);");
    news.status = OFF;
    check_has(&news, "(TLV_CMD_OFF: switched off by another program's command, "
                     "or when no heartbeat came for 3 s);");
    news.was_away = true;
    check_has(&news, "(TLV_CMD_OFF: the sensor was restarted, or got no "
                     "heartbeat for 3 s);");
    news.ns = 3 * SECOND;
    check_has(&news, "(TLV_CMD_OFF: this program sent no heartbeats for 3 s);");
    news.ns = 0;
    news.status = ON | BAD;
    check_has(&news, "(HW_SAFETY_BAD);");
    news.kind = LUM_NEWS_ENDED_ON;
    news.to.address = 0;
    check_has(&news, "(status: HW_SAFETY_BAD TLV_CMD_ON)");
    news.status = 0x8001;
    check_has(&news, "(status: GALVO_AMP_BX_BAD BIT_15)");
    news.status = 0;
    check_has(&news, "(status: none)");
}

static void where_the_laser_stands_is_named(void **state)
{
    lum_news news = news_of(LUM_NEWS_OFF_GOES_ON);
    (void)state;
    news.status = ON;
    check_has(&news, "10.42.0.37: the laser is still on: laser off");
    news.tries = 0;
    check_has(&news, "10.42.0.37: no answer yet: laser off");
    news = news_of(LUM_NEWS_LASER_CAME_UP);
    news.status = ON;
    check_has(&news, "10.42.0.37 is on, by");
    news = news_of(LUM_NEWS_LASER_IS_OFF);
    news.status = 1;
    check_has(&news, "the laser is off;");
    news.status = 0;
    check_has(&news, "the laser may be off;");
    assert_string_equal(lum_laser_cause(LUM_LASER_TLV_CMD_ON, false), "");
    news = news_of(LUM_NEWS_LASER_LEFT);
    news.was_away = true;
    check_has(&news, "10.42.0.37 is being switched off;");
}

static void seconds_are_rounded(void **state)
{
    static const struct {
        int64_t ns;
        const char *text;
    } cases[] = {{3050 * MS - 1, "after 3 s"},
                 {3050 * MS, "after 3.1 s"},
                 {99 * SECOND, "after 99 s"},
                 {0, "after 0 s"}};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        lum_news news = news_of(LUM_NEWS_BACK);
        news.ns = cases[i].ns;
        check_has(&news, cases[i].text);
    }
}

/* --- Data --- */

static lum_contact contact;
static lum_layout layout;

static void begin(void)
{
    lum_layout_default(&layout);
    lum_contact_begin(&contact, SECOND);
}

static lum_news_kind pass(int64_t now_ns)
{
    return lum_contact_tick(&contact, true, 0, now_ns);
}

static lum_news_kind hear(bool has_status, int64_t now_ns)
{
    const lum_sensor_event event = {.kind = LUM_SENSOR_ANSWER,
                                    .has_status = has_status};
    return lum_contact_take(&contact, &event, now_ns);
}

static lum_news_kind take(lum_sensor_event_kind kind, bool is_up)
{
    const lum_sensor_event event = {
        .kind = kind, .has_status = true, .is_up = is_up};
    return lum_contact_take(&contact, &event, 2 * SECOND);
}

static void data_that_stops_is_told_once_and_again_when_it_is_back(void **state)
{
    (void)state;
    begin();
    assert_int_equal(lum_contact_note_data(&contact, 2 * SECOND), NOTHING);
    assert_int_equal(pass(5 * SECOND - 1), NOTHING);
    assert_int_equal(lum_contact_standing(&contact, 5 * SECOND - 1), NOTHING);
    assert_int_equal(pass(5 * SECOND), LUM_NEWS_SILENT);
    assert_int_equal(pass(9 * SECOND), NOTHING);
    assert_int_equal(lum_contact_standing(&contact, 9 * SECOND),
                     LUM_NEWS_SILENT);
    assert_int_equal(lum_contact_note_data(&contact, 10 * SECOND),
                     LUM_NEWS_BACK);
    assert_int_equal(lum_contact_note_data(&contact, 10 * SECOND), NOTHING);
    assert_int_equal(lum_contact_standing(&contact, 10 * SECOND), NOTHING);
    assert_int_equal(pass(13 * SECOND), LUM_NEWS_SILENT);
    assert_int_equal(contact.first_data_ns, 2 * SECOND);
    assert_int_equal(contact.data_ns, 10 * SECOND);
}

static void what_a_program_does_not_listen_to_is_no_silence(void **state)
{
    (void)state;
    begin();
    (void)lum_contact_note_data(&contact, 2 * SECOND);
    lum_contact_pass(&contact, 2500 * MS);
    lum_contact_pass(&contact, 5 * SECOND);
    assert_true(contact.pause_ns == 2500 * MS);
    assert_int_equal(pass(8 * SECOND - 1), NOTHING);
    assert_int_equal(pass(8 * SECOND), LUM_NEWS_SILENT);
}

static void whose_answers_go_on_has_lost_its_client(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        begin();
        assert_int_equal(lum_contact_note_data(&contact, 2 * SECOND), NOTHING);
        if (i != 3) {
            assert_int_equal(hear(true, 3 * SECOND + (i == 0)), NOTHING);
        }
        if (i == 2) {
            assert_int_equal(hear(true, 4 * SECOND), NOTHING);
            assert_int_equal(take(LUM_SENSOR_NO_ANSWER, false), NOTHING);
        }
        assert_int_equal(pass(5 * SECOND),
                         i == 0 ? LUM_NEWS_DATA_STOPPED : LUM_NEWS_SILENT);
    }
}

static void a_pause_explains_what_is_seen_for_a_while(void **state)
{
    (void)state;
    begin();
    assert_false(lum_contact_was_away(&contact, 9 * SECOND));
    (void)lum_contact_note_data(&contact, 2 * SECOND);
    assert_false(lum_contact_was_away(&contact, 3 * SECOND - 1));
    assert_true(lum_contact_was_away(&contact, 3 * SECOND));
    (void)lum_contact_note_data(&contact, 3 * SECOND - 1);
    assert_false(lum_contact_was_away(&contact, 3 * SECOND));
    (void)lum_contact_note_data(&contact, 4 * SECOND - 1);
    for (int64_t now_ns = 4 * SECOND; now_ns < 9 * SECOND; now_ns += 500 * MS) {
        assert_true(lum_contact_was_away(&contact, now_ns));
        (void)lum_contact_note_data(&contact, now_ns);
    }
    assert_true(lum_contact_was_away(&contact, 9 * SECOND - 2));
    assert_false(lum_contact_was_away(&contact, 9 * SECOND - 1));
}

static void a_sensor_that_moves_is_not_silent(void **state)
{
    const lum_endpoint to = {0x0a2a0063, 5517};
    (void)state;
    begin();
    (void)lum_contact_note_data(&contact, 2 * SECOND);
    assert_int_equal(lum_contact_move(&contact, false, to), NOTHING);
    assert_int_equal(lum_contact_move(&contact, true, to), LUM_NEWS_MOVED);
    assert_int_equal(lum_contact_move(&contact, true, to), NOTHING);
    assert_int_equal(contact.to.address, to.address);
    assert_int_equal(pass(9 * SECOND), NOTHING);
    assert_int_equal(take(LUM_SENSOR_LINK, false), LUM_NEWS_LINK_DOWN);
    assert_int_equal(lum_contact_standing(&contact, 9 * SECOND),
                     LUM_NEWS_MOVED);
    assert_int_equal(lum_contact_move(&contact, false, to), NOTHING);
    assert_int_equal(lum_contact_standing(&contact, 9 * SECOND),
                     LUM_NEWS_LINK_DOWN);
    assert_int_equal(take(LUM_SENSOR_LINK, true), LUM_NEWS_LINK_UP);
    assert_int_equal(lum_contact_standing(&contact, 9 * SECOND),
                     LUM_NEWS_SILENT);
    assert_int_equal(lum_contact_move(&contact, true, to), LUM_NEWS_MOVED);
}

static void data_that_an_owner_waits_for_is_told_once(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        const lum_news_kind told = i == 0   ? LUM_NEWS_NO_ANSWER_YET
                                   : i == 1 ? LUM_NEWS_NO_DATA_YET
                                            : LUM_NEWS_UNKNOWN_LAYOUT;
        begin();
        if (i > 0) {
            assert_int_equal(hear(true, 2 * SECOND), NOTHING);
        }
        contact.has_unknown = i == 2;
        assert_int_equal(pass(4 * SECOND - 1), NOTHING);
        assert_int_equal(lum_contact_standing(&contact, 4 * SECOND - 1),
                         NOTHING);
        assert_int_equal(lum_contact_tick(&contact, false, 0, 4 * SECOND),
                         NOTHING);
        assert_int_equal(pass(4 * SECOND), told);
        assert_int_equal(pass(4 * SECOND), NOTHING);
        assert_int_equal(lum_contact_standing(&contact, 4 * SECOND), told);
        (void)lum_contact_note_data(&contact, 5 * SECOND);
        assert_int_equal(lum_contact_standing(&contact, 5 * SECOND), NOTHING);
        begin();
        (void)lum_contact_note_data(&contact, 2 * SECOND);
        assert_int_equal(pass(4 * SECOND), NOTHING);
    }
}

/* --- Clocks --- */

/* A packet at two times of the host, in s, with a clock in s. */
static lum_news_kind read_clock(double now, double utc, double clock)
{
    const uint32_t ticks = (uint32_t)(uint64_t)(clock * 1e6);
    const lum_group group = {.clock_raw = ticks};
    return lum_contact_note_clock(&contact, &layout.profile, &group,
                                  (int64_t)(now * 1e9), (int64_t)(utc * 1e9));
}

/* And with one in ticks. */
static lum_news_kind read_ticks(double now, uint64_t ticks)
{
    const lum_group group = {.clock_raw = ticks};
    const int64_t now_ns = (int64_t)(now * 1e9);
    return lum_contact_note_clock(&contact, &layout.profile, &group, now_ns,
                                  now_ns);
}

static lum_news_kind read_at(double now, double clock)
{
    return read_clock(now, now, clock);
}

static void a_clock_that_begins_anew_is_a_restart(void **state)
{
    (void)state;
    begin();
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 501), NOTHING);
    assert_int_equal(read_at(15, 1), NOTHING);
    assert_false(lum_contact_was_away(&contact, 16 * SECOND));
    assert_int_equal(read_clock(16, 99, 2), LUM_NEWS_RESTARTED);
    assert_true(lum_contact_was_away(&contact, 21 * SECOND - 1));
    assert_false(lum_contact_was_away(&contact, 21 * SECOND));
    contact.began_ns = 1;
    contact.first_data_ns = 2;
    contact.data_ns = 3;
    contact.heard_ns = 4;
    assert_int_equal(read_at(17, 3), NOTHING);
    assert_true(contact.away_ns == 16 * SECOND);
    assert_int_equal(read_at(18, 504), NOTHING);
    assert_int_equal(read_at(19, 5), NOTHING);
}

static void one_that_wraps_is_not(void **state)
{
    const double wrap = 4294.967296;
    (void)state;
    begin();
    assert_int_equal(read_at(10, wrap - 1), NOTHING);
    assert_int_equal(read_at(12, 1), NOTHING);
    assert_int_equal(read_at(13, 2), NOTHING);
    assert_int_equal(read_at(13 + wrap, 2), NOTHING);
    assert_int_equal(read_at(14 + wrap, 3), NOTHING);
}

static void one_damaged_packet_is_not(void **state)
{
    (void)state;
    begin();
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 3000), NOTHING);
    assert_int_equal(read_at(12, 502), NOTHING);
    assert_int_equal(read_at(13, 3002), NOTHING);
    assert_int_equal(read_at(14, 2000), NOTHING); /* nor two apart */
    assert_int_equal(read_at(15, 505), NOTHING);
    /* one that fits to it goes on from before, too */
    assert_int_equal(read_at(16, 508.5), NOTHING);
    assert_int_equal(read_at(17, 508.5), NOTHING);
}

static void what_waited_for_a_program_that_stood_still_is_not(void **state)
{
    (void)state;
    begin();
    assert_int_equal(read_clock(10, 1000, 500), NOTHING);
    /* all at once, as they had come while it stood still for 60 s */
    assert_int_equal(read_clock(70, 1001, 501), NOTHING);
    assert_false(contact.odd.is_there);
    assert_int_equal(read_clock(70, 1030, 530), NOTHING);
    assert_false(contact.odd.is_there);
    assert_int_equal(read_clock(70, 1060, 560), NOTHING);
    /* and where the host's clock is set */
    assert_int_equal(read_clock(71, 5000, 561), NOTHING);
    assert_int_equal(read_clock(72, 100, 562), NOTHING);
    assert_int_equal(read_clock(73, 101, 563), NOTHING);
}

static void a_clock_may_be_a_little_off(void **state)
{
    static const struct {
        double now;
        double clock;
        bool fits;
    } cases[] = {
        {10, 502, true},       {10, 502.0001, false},  {10, 498, true},
        {10, 497.9999, false}, {110, 603, true},       {110, 603.0001, false},
        {110, 597, true},      {110, 596.9999, false}, {9, 499, false}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin();
        assert_int_equal(read_at(10, 500), NOTHING);
        assert_int_equal(read_at(cases[i].now, cases[i].clock), NOTHING);
        assert_int_equal(contact.odd.is_there, !cases[i].fits);
    }
}

static void ticks_may_be_a_nanosecond(void **state)
{
    (void)state;
    for (unsigned more = 0; more < 2; more++) {
        begin();
        layout.profile.clock_unit_ns = 1;
        layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = 8;
        assert_int_equal(read_ticks(10, 0), NOTHING);
        assert_int_equal(read_ticks(10, 2000000000u + more), NOTHING);
        assert_int_equal(contact.odd.is_there, more);
    }
}

static void no_clock_fits_to_a_time_before_the_last(void **state)
{
    const lum_group group = {.clock_raw = UINT64_MAX / 1000u & UINT32_MAX};
    (void)state;
    begin();
    assert_int_equal(read_ticks(10, 0), NOTHING);
    assert_int_equal(lum_contact_note_clock(&contact, &layout.profile, &group,
                                            10 * SECOND - 1, 10 * SECOND - 1),
                     NOTHING);
    assert_true(contact.odd.is_there);
}

static void clocks_of_any_width_are_followed(void **state)
{
    lum_field *field = &layout.profile.group[LUM_FIELD_TIMESTAMP];
    (void)state;
    begin();
    field->bytes = 0; /* no clock */
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 1), NOTHING);
    assert_int_equal(read_at(12, 2), NOTHING);
    /* a wrap of 28 bits is none of 32 */
    field->bytes = 4;
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 501 - 268.435456), NOTHING);
    assert_int_equal(read_at(12, 502 - 268.435456), LUM_NEWS_RESTARTED);
    begin();
    field->bytes = 8;
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 1), NOTHING);
    assert_int_equal(read_at(12, 2), LUM_NEWS_RESTARTED);
    /* 63 bits of it are looked at */
    assert_int_equal(read_ticks(13, 3000000u | UINT64_C(1) << 63), NOTHING);
    assert_false(contact.odd.is_there);
    assert_int_equal(read_ticks(14, 4000000u | UINT64_C(1) << 62), NOTHING);
    assert_true(contact.odd.is_there);
    begin();
    field->bytes = 8;
    field->bits = 62;
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_ticks(11, 501000000u | UINT64_C(1) << 62), NOTHING);
    assert_false(contact.odd.is_there);
    begin();
    field->bytes = 8;
    field->bits = 40;
    assert_int_equal(read_at(10, 500), NOTHING);
    assert_int_equal(read_at(11, 1), NOTHING);
    assert_int_equal(read_at(12, 2), LUM_NEWS_RESTARTED);
    begin();
    field->bits = 21; /* wraps after 2.097 s: any reading is where it should */
    assert_int_equal(read_at(10, 2), NOTHING);
    assert_int_equal(read_at(11, 0.1), NOTHING);
    assert_int_equal(read_at(12, 0), NOTHING);
    assert_false(contact.odd.is_there);
}

/* --- Answers --- */

static void no_answers_are_told_once_by_what_else_comes(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        begin();
        if (i > 0) {
            (void)lum_contact_note_data(&contact, 2 * SECOND);
        }
        assert_int_equal(hear(true, 2 * SECOND), NOTHING);
        assert_int_equal(lum_contact_tick(&contact, false, 7, 2 * SECOND),
                         NOTHING);
        assert_int_equal(take(LUM_SENSOR_NO_ANSWER, false), NOTHING);
        assert_int_equal(lum_contact_standing(&contact, 2 * SECOND),
                         i == 0 ? NOTHING : LUM_NEWS_UNHEARD);
        /* where data has stopped too, that is what is told */
        assert_int_equal(lum_contact_tick(&contact, false, 7, 3 * SECOND),
                         i == 0 ? LUM_NEWS_NO_ANSWER : NOTHING);
        if (i > 0) {
            (void)lum_contact_note_data(&contact, 3 * SECOND);
            (void)lum_contact_note_data(&contact, 3500 * MS);
            assert_int_equal(lum_contact_tick(&contact, false, i == 2 ? 8 : 7,
                                              4500 * MS - 1),
                             i == 2 ? LUM_NEWS_LATE_ANSWERS : NOTHING);
        }
        /* the request may be of before the pause */
        for (int64_t ns = 4 * SECOND; i == 1 && ns <= 8 * SECOND;
             ns += SECOND / 2) {
            (void)lum_contact_note_data(&contact, ns);
            assert_int_equal(lum_contact_tick(&contact, false, 7, ns),
                             ns < 8 * SECOND ? NOTHING : LUM_NEWS_UNHEARD);
        }
        assert_int_equal(lum_contact_tick(&contact, false, 9, 4 * SECOND - 1),
                         NOTHING);
        assert_int_equal(hear(true, 4 * SECOND), LUM_NEWS_ANSWERS);
        assert_int_equal(hear(true, 4 * SECOND), NOTHING);
        /* those that came meanwhile were late ones, too */
        assert_int_equal(take(LUM_SENSOR_NO_ANSWER, false), NOTHING);
        assert_int_equal(lum_contact_tick(&contact, false, 9, 4 * SECOND),
                         LUM_NEWS_LATE_ANSWERS);
    }
}

static void answers_without_a_status_are_told_once(void **state)
{
    (void)state;
    begin();
    assert_int_equal(hear(false, SECOND), LUM_NEWS_NO_STATUS);
    assert_int_equal(hear(false, SECOND), NOTHING);
    assert_int_equal(hear(true, SECOND), NOTHING);
    assert_int_equal(hear(false, SECOND), LUM_NEWS_NO_STATUS);
    assert_int_equal(take(LUM_SENSOR_NO_ANSWER, false), NOTHING);
    assert_int_equal(pass(SECOND), LUM_NEWS_NO_ANSWER);
    assert_int_equal(hear(false, SECOND), LUM_NEWS_ANSWERS);
}

static void other_events_say_nothing(void **state)
{
    static const lum_sensor_event_kind kinds[] = {
        LUM_SENSOR_IDLE, LUM_SENSOR_CANCELLED, LUM_SENSOR_DATAGRAMS,
        LUM_SENSOR_TIME, LUM_SENSOR_ALERT,     LUM_SENSOR_FAILED};
    (void)state;
    begin();
    for (size_t i = 0; i < 6; i++) {
        const lum_contact before = contact;
        assert_int_equal(take(kinds[i], true), NOTHING);
        assert_memory_equal(&before, &contact, sizeof contact);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(each_kind_has_its_name_weight_and_text),
    cmocka_unit_test(each_text_is_cut_to_its_room),
    cmocka_unit_test(what_is_no_kind_has_no_text),
    cmocka_unit_test(those_of_a_laser_that_is_down_are_dark),
    cmocka_unit_test(ways_to_a_sensor_are_named),
    cmocka_unit_test(commands_name_an_interface_as_a_shell_takes_it),
    cmocka_unit_test(a_long_interface_is_cut),
    cmocka_unit_test(bits_are_named),
    cmocka_unit_test(where_the_laser_stands_is_named),
    cmocka_unit_test(seconds_are_rounded),
    cmocka_unit_test(data_that_stops_is_told_once_and_again_when_it_is_back),
    cmocka_unit_test(what_a_program_does_not_listen_to_is_no_silence),
    cmocka_unit_test(whose_answers_go_on_has_lost_its_client),
    cmocka_unit_test(a_pause_explains_what_is_seen_for_a_while),
    cmocka_unit_test(a_sensor_that_moves_is_not_silent),
    cmocka_unit_test(data_that_an_owner_waits_for_is_told_once),
    cmocka_unit_test(a_clock_that_begins_anew_is_a_restart),
    cmocka_unit_test(one_that_wraps_is_not),
    cmocka_unit_test(one_damaged_packet_is_not),
    cmocka_unit_test(what_waited_for_a_program_that_stood_still_is_not),
    cmocka_unit_test(a_clock_may_be_a_little_off),
    cmocka_unit_test(ticks_may_be_a_nanosecond),
    cmocka_unit_test(no_clock_fits_to_a_time_before_the_last),
    cmocka_unit_test(clocks_of_any_width_are_followed),
    cmocka_unit_test(no_answers_are_told_once_by_what_else_comes),
    cmocka_unit_test(answers_without_a_status_are_told_once),
    cmocka_unit_test(other_events_say_nothing),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
