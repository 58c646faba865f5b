/* lumsim on the network, seen by its packets: what it answers, what it sends,
 * what its log says. */
#include "client.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SENSOR   "10.42.0.37"
#define MINE     50000
#define QUIET_MS 400 /* for what must not */

/* Times in the log, in seconds: of an event. */
static double t_of(const user_event *event)
{
    return user_number(event->line, "t");
}

static bool is_said(const user_event *event, const char *key, const char *value)
{
    const char *got = user_value(event->line, key);
    return got != NULL && strcmp(got, value) == 0;
}

/* The first event of a kind with a value from a number on; NULL: none. */
static const user_event *event_with(const user_sensor *s, const char *kind,
                                    size_t from, const char *key,
                                    const char *value)
{
    const size_t count = user_events(s, kind);
    for (size_t i = from; i < count; i++) {
        const user_event *event = user_event_at(s, kind, i);
        if (is_said(event, key, value)) {
            return event;
        }
    }
    return NULL;
}

/* The simulator ends; what it counted. */
static const char *stop_of(user_sensor *s)
{
    user_expect_end(s->tool, SIGTERM, 0);
    user_expect_equal(user_events(s, "stop"), 1);
    return user_last(s, "stop")->line;
}

/* --- Answers --- */

STORY(a_clock_counts_microseconds,
      "a clock counts microseconds from its start, and wraps")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--clock 4294000000");
    client *c = client_new(b.host, MINE, false);
    const uint32_t before = client_clock(c);
    user_pause_ms(user_any(1000, 2000));
    const uint32_t after = client_clock(c);
    const user_event *start = user_event_at(s, "start", 0);
    user_expect_same(user_value(start->line, "clock_us"), "4294000000");
    const double t[2] = {t_of(user_event_at(s, "timestamp", 0)),
                         t_of(user_event_at(s, "timestamp", 1))};
    user_expect(fabs((before - 4294000000u) - (t[0] - t_of(start)) * 1e6) <= 2);
    user_expect(fabs((uint32_t)(after - before) - (t[1] - t[0]) * 1e6) <= 2);
    user_expect(after < before);
}

STORY(a_clock_is_that_of_the_arrival,
      "the clock of an answer is that of its question's arrival")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--clock 0");
    client *c = client_new(b.host, MINE, false);
    const uint32_t first = client_clock(c);
    user_signal(s->tool, SIGSTOP);
    const uint32_t sequence = 7;
    client_ask_time(c, sequence);
    user_pause_ms(500);
    user_signal(s->tool, SIGCONT);
    const user_mail *answer = client_wait(c, is_answer, &sequence);
    user_until(event_with(s, "reply", 0, "sequence", "7") != NULL);
    const double heard[2] = {t_of(user_event_at(s, "timestamp", 0)),
                             t_of(user_event_at(s, "timestamp", 1))};
    user_expect(t_of(event_with(s, "reply", 0, "sequence", "7")) - heard[1] >
                0.4);
    user_expect(
        fabs(u32_at(answer, 16) - first - (heard[1] - heard[0]) * 1e6) <= 2);
}

STORY(a_poll_changes_nothing, "a poll shows the status and changes nothing")
{
    static const uint32_t sequences[] = {0, UINT32_MAX};
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    for (size_t i = 0; i < 2; i++) {
        client_order(c, sequences[i], NULL);
        const user_mail *answer = client_wait(c, is_answer, &sequences[i]);
        user_expect_equal(status_in(answer), 0);
        user_expect_equal(answer->size, 22);
    }
    user_expect_equal(user_events(s, "laser"), 0);
}

STORY(commands_are_done, "commands are done, and refusals named")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    const user_mail *answer = client_command(c, "u 50p 101p 7x");
    user_expect_equal(status_in(answer), 0x0800);
    user_expect_has(said_in(answer), "101p");
    user_expect_has(said_in(answer), "7x");
    user_expect_lacks(said_in(answer), "50p");
    user_expect_equal(status_in(client_command(c, "d")), 0x0200);
    user_expect_equal(user_events(s, "laser"), 2);
    user_expect(is_said(user_event_at(s, "laser", 0), "up", "true"));
    user_expect(is_said(user_event_at(s, "laser", 1), "up", "false"));
    user_expect_has(user_value(user_event_at(s, "tlv", 0)->line, "note"),
                    "refused 101p");
    user_expect_same(user_value(user_event_at(s, "tlv", 1)->line, "note"), "d");
}

STORY(what_is_not_for_a_sensor,
      "what is not for a sensor is ignored and counted")
{
    static const uint8_t magic[12] = {0xed, 0xfe, 0xf3, 0xa1,
                                      0xef, 0xbe, 0x34, 0x12};
    static const uint8_t zeros[1400];
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, false);
    uint8_t unknown[12], time[12], tlv[11];
    memcpy(unknown, magic, sizeof unknown);
    memcpy(time, magic, sizeof time);
    memcpy(tlv, magic, sizeof tlv);
    unknown[8] = 9;
    time[8] = 6;
    tlv[8] = 7;
    client_send(c, "", 0);
    client_send(c, "x", 1);
    client_send(c, magic, 8);
    client_send(c, unknown, sizeof unknown);
    client_send(c, time, sizeof time);
    client_send(c, tlv, sizeof tlv);
    client_send(c, zeros, sizeof zeros);
    (void)client_clock(c);
    const char *stop = stop_of(s);
    user_expect_same(user_value(stop, "heard.foreign"), "5");
    user_expect_same(user_value(stop, "heard.unknown_type"), "1");
    user_expect_same(user_value(stop, "heard.malformed"), "1");
}

STORY(a_flood_does_not_fill_the_log, "a flood does not fill the log")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, false);
    for (unsigned i = 0; i < 20; i++) {
        for (unsigned k = 0; k < 100; k++) {
            client_send(c, "not for a sensor", 16);
        }
        (void)client_clock(c);
    }
    user_expect_same(user_value(stop_of(s), "heard.foreign"), "2000");
    double total = 0;
    const size_t logged = user_events(s, "ignored");
    user_expect_at_most(logged, 199);
    for (size_t i = 0; i < logged; i++) {
        total += user_number(user_event_at(s, "ignored", i)->line, "count");
    }
    user_expect_equal(total, 2000);
}

STORY(an_answer_can_be_delayed, "an answer can be delayed")
{
    static const char *const kinds[] = {"timestamp", "tlv"};
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--answer-delay 300");
    client *c = client_new(b.host, MINE, false);
    (void)client_clock(c);
    (void)client_command(c, "d");
    for (size_t i = 0; i < 2; i++) {
        const user_event *heard = user_event_at(s, kinds[i], 0);
        const user_event *sent = event_with(s, "reply", 0, "kind", kinds[i]);
        user_expect(sent != NULL && t_of(sent) - t_of(heard) >= 0.3);
    }
}

STORY(an_answer_can_be_lost, "an answer can be lost, and the command is done")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--answer-loss 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    client_order(c, 1, "u");
    user_until(user_laser_is_on(s));
    user_until(event_with(s, "reply", 0, "lost", "true") != NULL);
    user_pause_ms(QUIET_MS);
    client_drain(c);
    const char *stop = stop_of(s);
    user_expect_same(user_value(stop, "answers"), "0");
    user_expect_same(user_value(stop, "answers_lost"), "1");
}

/* --- Heartbeats --- */

STORY(without_heartbeats_all_goes_off,
      "without heartbeats, laser and data go off after 3 s and no later, and "
      "begin anew with the next")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    (void)client_command(c, "u");
    client_take(c, 100);
    user_pause_between_ms(0, 400);
    c->beats = false;
    user_until(event_with(s, "laser", 0, "up", "false") != NULL);
    user_until(event_with(s, "stream", 0, "to", "null") != NULL);
    const double last = t_of(user_last(s, "heartbeat"));
    const double off[2] = {t_of(event_with(s, "laser", 0, "up", "false")),
                           t_of(event_with(s, "stream", 0, "to", "null"))};
    for (size_t i = 0; i < 2; i++) {
        user_expect(off[i] - last >= 2.9);
        user_expect(off[i] - last < 3.2);
    }
    user_expect_has(user_last(s, "status")->line, "HEARTBEAT_TIMEOUT");
    user_pause_ms(10); /* what is on its way */
    client_drain(c);
    user_pause_ms(QUIET_MS);
    user_expect(client_find(c, is_data, NULL) == NULL);
    c->beats = true;
    user_expect_equal(line_of(client_wait(c, is_data, NULL)), 0);
    user_expect_lacks(user_last(s, "status")->line, "HEARTBEAT_TIMEOUT");
}

STORY(the_last_ones_sender_gets_the_data,
      "the sender of the last heartbeat gets the data")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *first = client_new(b.host, MINE, true);
    client_take(first, 10);
    client *second = client_new(b.host, MINE + 1, false);
    first->beats = false;
    client_beat(second);
    user_until(event_with(s, "stream", 0, "to", "10.42.0.1:50001") != NULL);
    user_pause_ms(10);
    client_drain(first);
    client_take(second, 10);
    user_pause_ms(QUIET_MS);
    user_expect(client_find(first, is_data, NULL) == NULL);
}

STORY(nothing_before_the_first_heartbeat,
      "nothing is sent before the first heartbeat")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, false);
    user_pause_ms(QUIET_MS);
    user_expect_equal(c->count, 0);
    user_expect_same(user_value(stop_of(s), "packets"), "0");
}

/* --- The scene --- */

/* Tags of so many data packets that come from now on, as bits. */
static unsigned tags_of_next(client *c, size_t count)
{
    unsigned tags = 0;
    client_drain(c);
    for (size_t i = 0; i < count; i++) {
        tags |= 1u << tag_of(client_wait(c, is_data, NULL));
    }
    return tags;
}

STORY(the_laser_brings_the_ranges,
      "the laser brings the ranges, and takes them")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    user_expect_equal(tags_of_next(c, 500), 1u << ANGLES);
    (void)client_command(c, "u");
    (void)client_wait(c, is_range, NULL);
    (void)client_command(c, "d");
    user_expect_equal(tags_of_next(c, 500), 1u << ANGLES);
}

/* Range words of a whole frame that begins from now on, of both eyes; the same
 * number of lines each time. */
static double words_of_a_frame(client *c)
{
    double words = 0;
    client_drain(c);
    const user_mail *mail = client_wait(c, is_data, NULL);
    while (line_of(mail) != 0 || tag_of(mail) != ANGLES) {
        mail = client_wait(c, is_data, NULL);
    }
    bool is_away = false; /* from line 0 */
    while (line_of(mail) != 0 || !is_away) {
        is_away = is_away || line_of(mail) == 32;
        words += tag_of(mail) == RANGES ? count_of(mail) : 0;
        mail = client_wait(c, is_data, NULL);
    }
    return words;
}

STORY(power_and_thresholds, "power and thresholds thin the returns, which grow "
                            "after switching on")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    (void)client_command(c, "u");
    const double early = words_of_a_frame(c);
    user_pause_ms(3200); /* until full strength */
    const double full = words_of_a_frame(c);
    user_expect(words_of_a_frame(c) == full);
    user_expect(full > 1.02 * early);
    (void)client_command(c, "100b 100g");
    const double high = words_of_a_frame(c);
    (void)client_command(c, "0b 0g");
    const double low = words_of_a_frame(c);
    (void)client_command(c, "50b 50g 25p");
    const double weak = words_of_a_frame(c);
    user_expect(full > 64 * 1000.0);
    user_expect(high < full);
    user_expect(low > full);
    user_expect(weak < high);
    (void)client_command(c, "0p");
    user_expect_equal(tags_of_next(c, 500), 1u << ANGLES);
}

/* How many numbers the lines have that come from now on, in so many packets;
 * all are below it. */
static size_t lines_of_next(client *c, size_t count)
{
    bool seen[1000] = {false};
    size_t lines = 0;
    client_drain(c);
    for (size_t i = 0; i < count; i++) {
        const uint32_t line = line_of(client_wait(c, is_data, NULL));
        user_expect_at_most(line, 999);
        lines += !seen[line];
        seen[line] = true;
    }
    for (size_t i = 0; i < lines; i++) {
        user_expect(seen[i]);
    }
    return lines;
}

STORY(a_frame_has_64_lines_or_640, "a frame has 64 lines, or 640")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    user_expect_equal(lines_of_next(c, 7 * 64 * 6), 64);
    (void)client_command(c, "0f");
    user_until(event_with(s, "frames", 0, "lines", "640") != NULL);
    user_pause_ms(200);
    user_expect_equal(lines_of_next(c, 2 * 640 * 6), 640);
    (void)client_command(c, "1f");
    user_until(user_events(s, "frames") >= 3);
    user_pause_ms(200);
    user_expect_equal(lines_of_next(c, 7 * 64 * 6), 64);
}

/* Elevations of the next four frames, in degrees: their least and largest. */
static void elevations(client *c, double *low, double *high)
{
    *low = 90;
    *high = -90;
    client_drain(c);
    for (size_t i = 0; i < 4 * 64 * 6; i++) {
        const user_mail *mail = client_wait(c, is_data, NULL);
        for (size_t k = 0; tag_of(mail) == ANGLES && k < count_of(mail); k++) {
            const int16_t raw = (int16_t)u16_at(mail, 24 + 4 * k + 2);
            const double degrees = -7 + raw / 32768.0 * 10;
            *low = degrees < *low ? degrees : *low;
            *high = degrees > *high ? degrees : *high;
        }
    }
}

static void send_table(client *c, uint32_t sequence)
{
    uint8_t packet[12 + 4 + 4 + 128] = {0xed, 0xfe, 0xf3, 0xa1, 0xef,
                                        0xbe, 0x34, 0x12, 7};
    packet[12] = (uint8_t)sequence;
    packet[16] = 4;
    packet[18] = 128;
    for (int i = 0; i < 64; i++) {
        const int16_t raw = (int16_t)lround((-3 - i / 64.0 + 7) / 10 * 32768);
        packet[20 + 2 * i] = (uint8_t)((uint16_t)raw & 0xffu);
        packet[21 + 2 * i] = (uint8_t)((uint16_t)raw >> 8);
    }
    client_send(c, packet, sizeof packet);
}

STORY(a_y_scan_moves_the_lines, "a Y-scan and a table move the lines")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    double low = 0;
    double high = 0;
    elevations(c, &low, &high);
    user_expect(low < -16 && high > 2);
    (void)client_command(c, "11y");
    user_until(user_events(s, "frames") >= 2);
    user_pause_ms(200);
    elevations(c, &low, &high);
    user_expect(low > -5.7 && high > 2);
    send_table(c, 9);
    user_until(user_events(s, "frames") >= 3);
    user_pause_ms(200);
    elevations(c, &low, &high);
    user_expect(low > -4.3 && high < -2.7);
}

STORY(a_new_scan_cuts_no_line, "a new scan cuts no line")
{
    static const char *const scans[] = {"11y", "30y", "20y", "12y",
                                        "15y", "28y", "17y", "19y"};
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, false);
    user_tool *dump =
        user_start(b.host, "lumdump udp://" SENSOR " --json --quiet");
    user_until(user_events(s, "stream") > 0);
    for (size_t i = 0; i < sizeof scans / sizeof *scans; i++) {
        (void)client_command(c, scans[i]);
        user_until(user_events(s, "frames") >= 2 + i);
        user_pause_between_ms(0, 500);
    }
    user_expect_end(dump, SIGINT, 0);
    user_expect(user_number(user_out(dump), "lines") > 500);
    user_expect_same(user_value(user_out(dump), "lost_words"), "0");
    /* No more than the recording's end cuts. */
    user_expect(user_number(user_out(dump), "lines_missing_angles") <= 2);
}

STORY(the_pace_is_that_of_the_rate, "the pace is that of the rate")
{
    static const double rates[] = {10, 25};
    const user_bench b = user_bench_new();
    for (size_t i = 0; i < 2; i++) {
        user_sensor *s = user_sensor_start(b.sensor, "--rate %g", rates[i]);
        client *c = client_new(b.host, (uint16_t)(MINE + i), true);
        client_take(c, (size_t)(2.5 * rates[i] * 64 * 6));
        c->beats = false;
        const char *stop = stop_of(s);
        const double seconds =
            user_number(stop, "t") - t_of(user_event_at(s, "stream", 0));
        const double pace =
            user_number(stop, "packets") / 6 / (seconds * rates[i] * 64);
        user_expect(fabs(pace - 1) < 0.02);
        user_expect_same(user_value(stop, "lines_skipped"), "0");
    }
}

STORY(a_simulator_that_was_held_up,
      "a simulator that was held up skips lines and sends no burst")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 100);
    user_signal(s->tool, SIGSTOP);
    user_pause_ms(1000);
    user_signal(s->tool, SIGCONT);
    user_until(user_events(s, "skipped") > 0);
    const double skipped = user_number(user_last(s, "skipped")->line, "lines");
    const char *stop = stop_of(s);
    user_expect(skipped >= 600);
    user_expect(user_number(stop, "lines_skipped") >= skipped);
    const double seconds =
        user_number(stop, "t") - t_of(user_event_at(s, "stream", 0));
    user_expect(user_number(stop, "lines") + skipped <= 640 * seconds + 10);
}

STORY(data_bears_the_sensors_clock,
      "data bears the sensor's clock, which wraps under way")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--clock 4293967296");
    client *c = client_new(b.host, MINE, true);
    uint32_t before = clock_of(client_wait(c, is_data, NULL));
    user_expect(before > 0x80000000u);
    bool seen[2] = {false, false}; /* steps of 1562 and 1563 us */
    bool has_wrapped = false;
    while (!has_wrapped || before < 50000) {
        const uint32_t clock_us = clock_of(client_wait(c, is_data, NULL));
        const uint32_t step = clock_us - before;
        user_expect_at_most(step, 9999);
        seen[0] = seen[0] || step == 1562;
        seen[1] = seen[1] || step == 1563;
        has_wrapped = has_wrapped || clock_us < before;
        before = clock_us;
    }
    user_expect(seen[0] && seen[1]);
}

/* --- The network --- */

STORY(a_new_address_holds_at_once, "a new address holds at once")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 10);
    client_move(c, user_ip("10.42.0.99"));
    user_until(event_with(s, "move", 0, "address", "10.42.0.99") != NULL);
    user_expect(is_said(user_last(s, "move"), "done", "true"));
    c->sensor = user_ip("10.42.0.99");
    (void)client_clock(c);
    user_pause_ms(10);
    client_drain(c);
    for (size_t i = 0; i < 100; i++) {
        user_expect_equal(client_wait(c, is_data, NULL)->from,
                          user_ip("10.42.0.99"));
    }
    c->beats = false;
    c->sensor = user_ip(SENSOR);
    const uint32_t sequence = 1;
    client_ask_time(c, sequence);
    user_pause_ms(QUIET_MS);
    user_expect(client_find(c, is_answer, &sequence) == NULL);
}

STORY(packets_get_lost_and_repeated,
      "packets get lost, repeated and corrupted as asked for, and are counted")
{
    const user_bench b = user_bench_new();
    user_sensor *lossy = user_sensor_start(b.sensor, "--loss 1");
    client *c = client_new(b.host, MINE, true);
    user_pause_ms(QUIET_MS);
    user_expect_equal(c->count, 0);
    const char *stop = stop_of(lossy);
    user_expect_same(user_value(stop, "packets"), "0");
    user_expect(user_number(stop, "lost") > 100);
    user_sensor *noisy =
        user_sensor_start(b.sensor, "--duplicate 1 --corrupt 0.1");
    client_take(c, 1000);
    stop = stop_of(noisy);
    user_expect(
        fabs(user_number(stop, "packets") / (12 * user_number(stop, "lines")) -
             1) < 0.05);
    user_expect(user_number(stop, "corrupted") > 50);
}

STORY(jitter_reorders, "jitter reorders and loses nothing")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--jitter 20");
    client *c = client_new(b.host, MINE, true);
    uint32_t before = clock_of(client_wait(c, is_data, NULL));
    int32_t spread = 0;
    for (size_t i = 0; i < 4000; i++) {
        const uint32_t clock_us = clock_of(client_wait(c, is_data, NULL));
        const int32_t back = (int32_t)(before - clock_us);
        spread = back > spread ? back : spread;
        before = clock_us;
    }
    user_expect(spread > 5000);
    const char *stop = stop_of(s);
    user_expect_same(user_value(stop, "no_room"), "0");
    user_expect_same(user_value(stop, "given_up"), "0");
    user_expect_same(user_value(stop, "lines_skipped"), "0");
    user_expect(user_number(stop, "packets") >
                6 * (user_number(stop, "lines") - 64));
}

STORY(a_port_that_is_taken, "a taken port is told, with who has it")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
    user_tool *second = user_run(b.sensor, "lumsim --address " SENSOR);
    user_expect_status(second, 1);
    user_expect_same(user_out(second), "");
    user_expect_has(user_err(second),
                    user_format(SENSOR ":5517 is taken by lumsim (process %ld)",
                                s->tool->process->pid));
}

STORY(what_cannot_be_opened, "what a simulator cannot open is told")
{
    static const struct {
        const char *arguments;
        int status;
        const char *told;
    } cases[] = {
        {"--address 192.0.2.77", 1, "192.0.2.77"},
        {"--address 127.0.0.1 --interface nope0", 2, "nope0"},
        {"--address 127.0.0.1 --log /nonexistent/log", 1, "/nonexistent/log"},
        {"--address 127.0.0.1 --log log", 1,
         "log cannot be written: No space left"},
    };
    const user_bench b = user_bench_new();
    user_leave("status-2", "the interface is wrong on purpose");
    world_disk_fill(world_disk_of(b.host), 50);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        user_tool *tool = user_run(b.host, "lumsim %s", cases[i].arguments);
        user_expect_status(tool, cases[i].status);
        user_expect_has(user_err(tool), cases[i].told);
    }
}

STORY(another_port_of_a_simulator, "a simulator may have another port")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--port 5999");
    user_expect_has(user_err(s->tool), "udp://" SENSOR ":5999 ");
    client *c = client_new(b.host, MINE, false);
    c->port = 5999;
    (void)client_clock(c);
}

/* --- Mishaps --- */

STORY(a_hazard_takes_the_laser_down,
      "a hazard takes the laser down, is told unasked, and passes")
{
    static const struct {
        int status;
        const char *up;
    } steps[] = {{0x0840, "false"}, {0x0800, "true"}, {0x0880, "false"}};
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--fault fan@4s-5 --fault interlock@6");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    (void)client_command(c, "u");
    user_expect(user_laser_is_on(s));
    const double start = t_of(user_event_at(s, "start", 0));
    for (size_t i = 0; i < 3; i++) {
        user_expect_equal(status_in(client_wait(c, is_tlv, NULL)),
                          steps[i].status);
        user_expect(is_said(user_last(s, "laser"), "up", steps[i].up));
        const double late =
            t_of(user_event_at(s, "fault", i)) - start - (4.0 + (double)i);
        user_expect(late >= 0 && late < 0.1);
    }
    user_expect_equal(user_events(s, "laser"), 4);
    user_expect_equal(tags_of_next(c, 500), 1u << ANGLES);
}

STORY(every_hazard_has_its_bit, "every hazard has its bit")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(
        b.sensor,
        "--fault galvo-bx@0 --fault galvo-by@0 --fault galvo-gx@0 "
        "--fault galvo-gy@0 --fault board@0 --fault fan@0 --fault interlock@0 "
        "--fault switch@0");
    client *c = client_new(b.host, MINE, false);
    user_until(user_events(s, "fault") == 8);
    user_expect_equal(status_in(client_command(c, NULL)) & 0x01ef, 0x01ef);
}

STORY(a_reboot_forgets_everything,
      "a reboot forgets address, clock, laser and client")
{
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--clock 3000000000 --fault reboot@5");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 1);
    (void)client_command(c, "u 20p");
    c->beats = false;
    client_move(c, user_ip("10.42.0.99"));
    user_until(event_with(s, "move", 0, "address", "10.42.0.99") != NULL);
    user_until(event_with(s, "move", 0, "address", SENSOR) != NULL);
    user_expect(client_clock(c) < 2000000000u);
    user_expect_equal(status_in(client_command(c, NULL)) & 0x0a00, 0);
    user_expect(!user_laser_is_on(s));
    user_expect(is_said(user_last(s, "stream"), "to", "null"));
    client_drain(c);
    user_pause_ms(QUIET_MS);
    user_expect(client_find(c, is_data, NULL) == NULL);
}

STORY(a_silent_sensor, "a silent sensor hears nothing and sends nothing")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--fault silence@0");
    client *c = client_new(b.host, MINE, true);
    client_ask_time(c, 1);
    user_pause_ms(QUIET_MS);
    user_expect_equal(c->count, 0);
    const char *stop = stop_of(s);
    user_expect(user_number(stop, "unheard") > 1);
    user_expect_same(user_value(stop, "heard.heartbeat"), "0");
    user_expect_same(user_value(stop, "answers"), "0");
    user_expect_same(user_value(stop, "packets"), "0");
}

STORY(silence_passes, "silence passes, and the data goes on")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--fault silence@5-5.5");
    client *c = client_new(b.host, MINE, true);
    client_take(c, 10);
    user_until(event_with(s, "fault", 0, "ends", "true") != NULL);
    (void)client_clock(c);
    client_drain(c);
    client_take(c, 10);
    const char *stop = stop_of(s);
    user_expect(user_number(stop, "unheard") > 0);
    user_expect(user_number(stop, "unsent") > 100);
}

/* --- Ends --- */

STORY(a_signal_ends_a_simulator,
      "a signal ends a simulator well, with a summary")
{
    static const int numbers[] = {SIGINT, SIGTERM};
    const user_bench b = user_bench_new();
    client *c = client_new(b.host, MINE, true);
    for (size_t i = 0; i < 2; i++) {
        user_sensor *s = user_sensor_start(b.sensor, "--seed 1");
        client_drain(c);
        client_take(c, 200);
        user_expect_end(s->tool, numbers[i], 0);
        const double packets =
            user_number(user_last(s, "stop")->line, "packets");
        user_expect_like(
            user_err(s->tool),
            user_format("\nlumsim: [0-9]+\\.[0-9] s: heard [1-9][0-9]* "
                        "heartbeats, 0 TLV .*; sent 0 answers and %.0f data "
                        "packets\n$",
                        packets));
        user_expect(packets >= 200);
    }
}

STORY(a_duration_ends_a_simulator, "a duration ends a simulator, quiet or not")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--duration 3");
    user_expect_status(s->tool, 0);
    user_expect_equal(user_count(user_err(s->tool), "\n"), 2);
    user_expect(
        t_of(user_last(s, "stop")) - t_of(user_event_at(s, "start", 0)) >= 3);
    user_tool *quiet =
        user_run(b.sensor, "lumsim --address " SENSOR " --duration 0.1 -q");
    user_expect_status(quiet, 0);
    user_expect_same(user_out(quiet), "");
    user_expect_same(user_err(quiet), "");
}

STORY(the_logs_reader_may_leave, "the log's reader may leave")
{
    const user_bench b = user_bench_new();
    world_file *end = NULL;
    world_reader *reader = world_reader_new("log", &end);
    user_tool *tool =
        user_start_with(b.sensor, (user_with){.output = end},
                        "lumsim --address " SENSOR " --frames 1 --log -");
    user_until(user_has(user_taken(reader), "\"event\": \"start\""));
    world_reader_close(reader);
    client *c = client_new(b.host, MINE, false);
    client_ask_time(c, 1);
    client_ask_time(c, 2);
    user_expect_status(tool, 0);
}
