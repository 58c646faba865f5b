/* Made-up runs: what the tools print, line by line. */
#define _POSIX_C_SOURCE 200809L
#include "test_run.h"

#include <signal.h>

/* --- Ground --- */

static void a_table_that_is_full_is_told(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status", 1 * S, RECORD_NEVER, 0);
    for (int i = 0; i <= RECORD_SPANS; i++) {
        record_signal_to(&run->record, t, 2 * S, SIGCHLD);
    }
    judge_ground(&run->record, &run->verdict);
    assert_true(verdict_has(&run->verdict, "room-for-all"));
}

static void more_rules_than_there_is_room_for_are_told(void **state)
{
    static char names[VERDICT_RULES + 1][8];
    struct run *run = *state;
    for (unsigned i = 0; i <= VERDICT_RULES; i++) {
        (void)snprintf(names[i], sizeof names[i], "r%u", i);
        verdict_asked(&run->verdict, names[i]);
    }
    judge_ground(&run->record, &run->verdict);
    assert_true(verdict_has(&run->verdict, "room-for-all"));
}

static void a_rule_is_left_with_need_alone(void **state)
{
    struct run *run = *state;
    verdict_leave(&run->verdict, "status-2");
    assert_true(verdict_is_left(&run->verdict, "status-2"));
    assert_false(verdict_is_left(&run->verdict, "status-3"));
    judge_ground(&run->record, &run->verdict);
    assert_true(verdict_has(&run->verdict, "leave-needed"));
}

static void a_rule_that_is_broken_may_be_left(void **state)
{
    struct run *run = *state;
    verdict_leave(&run->verdict, "status-2");
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 2);
    judge(run);
    judge_ground(&run->record, &run->verdict);
    assert_false(verdict_has(&run->verdict, "leave-needed"));
    assert_false(verdict_has(&run->verdict, "room-for-all"));
}

/* --- Lines of a shell --- */

static char *join(char *text, const char *more)
{
    const size_t had = text != NULL ? strlen(text) : 0;
    char *out = realloc(text, had + strlen(more) + 1);
    assert_non_null(out);
    memcpy(out + had, more, strlen(more) + 1);
    return out;
}

/* It prints at a moment. */
static void print(record_tool *t, int64_t t_ns, const char *text)
{
    t->out = join(t->out, text);
    t->err = join(t->err, "");
    record_add_print(
        t, (record_print){.t_ns = t_ns, .out = strlen(t->out), .err = 0});
}

static void complain(record_tool *t, int64_t t_ns, const char *text)
{
    t->out = join(t->out, "");
    t->err = join(t->err, text);
    record_add_print(t, (record_print){.t_ns = t_ns,
                                       .out = strlen(t->out),
                                       .err = strlen(t->err)});
}

static record_tool *shell(struct run *run)
{
    record_tool *t = tool(run, "lumctl shell", 1 * S, 60 * S, 0);
    print(t, 1 * S, "");
    return t;
}

#define DONE_50 "10.42.0.37: power 50 done; laser down: TLV_CMD_OFF\n"

static void a_line_of_a_shell_is_done(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 50\n");
    print(t, 2100 * MS, DONE_50);
    command(run, 0, 2050 * MS, 1, "50p");
    say(run, BOOT TLV("2.050000", "1", "50p"));
    assert_fine(run);
    assert_true(was_asked(run, "done-true"));
    assert_true(was_asked(run, "line-in-time"));
}

static void a_line_that_no_sensor_did_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 50\n");
    print(t, 2100 * MS, DONE_50);
    say(run, BOOT);
    assert_breaks(run, "done-true");
}

/* What the first line did is not the second's. */
static void each_line_is_judged_by_itself(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 50\npower 50\n");
    print(t, 2100 * MS, DONE_50);
    print(t, 3300 * MS, DONE_50);
    command(run, 0, 2050 * MS, 1, "50p");
    say(run, BOOT TLV("2.050000", "1", "50p"));
    assert_breaks(run, "done-true");
}

static void a_laser_that_a_shell_calls_off_is_off(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "laser off\n");
    print(t, 2500 * MS, "10.42.0.37: laser off; laser down: TLV_CMD_OFF\n");
    command(run, 0, 2050 * MS, 1, "d");
    command(run, 0, 2350 * MS, 2, "");
    beat(run, 0, 1900 * MS);
    say(run,
        BOOT BEAT("1.900000") TLV("1.950000", "9", "u")
            LASER("1.950000", "true") TLV("2.050000", "1", "d")
                TLV("2.350000", "2", "status poll") LASER("4.950000", "false"));
    assert_breaks(run, "off-true");
}

static void a_report_comes_within_the_limit_of_its_line(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 50\n");
    print(t, 7 * S, DONE_50);
    command(run, 0, 2050 * MS, 1, "50p");
    say(run, BOOT TLV("2.050000", "1", "50p"));
    assert_breaks(run, "line-in-time");
}

/* The first of them was not done. */
static void a_report_is_of_the_line_that_is_not_over(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 50\n");
    record_type(t, 20 * S, "power 50\n");
    print(t, 20100 * MS, DONE_50);
    command(run, 0, 20050 * MS, 1, "50p");
    say(run, BOOT TLV("20.050000", "1", "50p"));
    assert_fine(run);
}

/* And not what a line before it says, which did not ask for it. */
static void a_laser_on_is_taken_back_by_its_own_line(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "d\n");
    record_type(t, 5 * S, "power 50\n");
    record_type(t, 6 * S, "laser on\n");
    print(t, 5100 * MS, DONE_50);
    complain(t, 6300 * MS, "lumctl: cancelled: it will not come up\n");
    command(run, 0, 2050 * MS, 1, "d");
    command(run, 0, 5050 * MS, 2, "50p");
    command(run, 0, 6050 * MS, 3, "u");
    command(run, 0, 6150 * MS, 4, "d");
    say(run, BOOT TLV("2.050000", "1", "d") TLV("5.050000", "2", "50p")
                 TLV("6.050000", "3", "refused u") TLV("6.150000", "4", "d"));
    assert_fine(run);
    assert_true(was_asked(run, "done-true"));
    assert_true(was_asked(run, "taken-back"));
}

static void the_limit_of_a_line_begins_behind_the_one_before(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 40\npower 50\n");
    print(t, 7 * S, DONE_50);
    command(run, 0, 6900 * MS, 1, "50p");
    say(run, BOOT TLV("6.900000", "1", "50p"));
    assert_fine(run);
}

static void a_report_of_what_nobody_typed_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = shell(run);
    record_type(t, 2 * S, "power 40\n");
    print(t, 2100 * MS, DONE_50);
    say(run, BOOT);
    assert_breaks(run, "line-typed");
}

static void a_line_that_a_shell_forgets_is_found(void **state)
{
    struct run *run = *state;
    record_type(shell(run), 5 * S, "power 50\n");
    (void)tool(run, "lumsim --log -", 0, RECORD_NEVER, 0);
    run->record.tools[1].host = 2;
    say(run, BOOT);
    assert_breaks(run, "line-in-calm");
}

static void a_shell_that_is_to_end_sends_no_heartbeat_more(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl shell --heartbeat", 1 * S, 15 * S, 0);
    print(t, 1 * S, "");
    record_signal_to(&run->record, t, 3 * S, SIGTERM);
    beats(run, 0, 1 * S, 3 * S);
    command(run, 0, 3100 * MS, 1, "d");
    assert_fine(run);
    beat(run, 0, 12 * S);
    assert_breaks(run, "heartbeat-late");
}

/* --- Clocks --- */

/* An exchange: the sensor reads its clock a millisecond behind the request. */
static void exchange(struct run *run, int index, int64_t t_ns,
                     uint32_t sequence, int64_t sensor_drift_ppb)
{
    const record_clock host = {t_ns + 100 * S, t_ns + 5000 * S, 0};
    const record_clock sensor = {t_ns, t_ns, sensor_drift_ppb};
    record_datagram *d = mail(run, index, t_ns - MS, false);
    d->packet = RECORD_IS_TIMESTAMP;
    d->sequence = sequence;
    record_add_stamp(&run->record,
                     (record_stamp){d->number, t_ns, host, sensor});
    d = mail(run, index, t_ns, true);
    d->packet = RECORD_IS_TIMESTAMP;
    d->sequence = sequence;
    d->clock_us = (uint32_t)(t_ns / RECORD_US);
    record_add_stamp(&run->record,
                     (record_stamp){d->number, t_ns, host, sensor});
}

/* The true offset is 5000 s. */
static void print_time(record_tool *t, int64_t t_ns, const char *text)
{
    print(t, t_ns, text);
    t->prints[t->print_count - 1].clock =
        (record_clock){t_ns + 100 * S, t_ns + 5000 * S, 0};
}

static void assert_time(struct run *run, const char *text, bool is_true)
{
    record_tool *t = tool(run, "lumctl time", 1 * S, 3 * S, 0);
    exchange(run, 0, 2 * S, 7, 0);
    print_time(t, 2500 * MS, text);
    if (is_true) {
        assert_fine(run);
        assert_true(was_asked(run, "time-true"));
    } else {
        assert_breaks(run, "time-true");
    }
}

static void an_offset_within_its_error_is_true(void **state)
{
    assert_time(*state,
                "{\"offset_ns\": 5000000900000, \"error_ns\": 1000000}\n",
                true);
}

static void an_offset_beyond_its_error_is_found(void **state)
{
    assert_time(*state,
                "{\"offset_ns\": 5000001100000, \"error_ns\": 1000000}\n",
                false);
}

static void an_offset_below_its_error_is_found(void **state)
{
    assert_time(*state,
                "{\"offset_ns\": 4999998900000, \"error_ns\": 1000000}\n",
                false);
}

static void wraps_of_the_clock_do_not_count(void **state)
{
    assert_time(*state,
                "{\"offset_ns\": 705032704000, \"error_ns\": 1000000}\n", true);
}

static void a_line_of_a_watch_is_read(void **state)
{
    assert_time(*state, "x  clock 0:00:02.0  offset 5000.002000 s +-1.00 ms\n",
                false);
}

static void an_offset_for_people_is_read(void **state)
{
    assert_time(*state,
                "  was 0 at    1970-01-01T01:23:20.000Z by this host's clock, "
                "+-182 us\n",
                true);
}

static void a_wrong_offset_for_people_is_found(void **state)
{
    assert_time(*state,
                "  was 0 at    1970-01-01T01:23:20.003Z by this host's clock, "
                "+-182 us\n",
                false);
}

static void clocks_beyond_the_promise_are_not_asked(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl time", 1 * S, 3 * S, 0);
    exchange(run, 0, 2 * S, 7, 600000);
    print_time(t, 2500 * MS, "{\"offset_ns\": 1, \"error_ns\": 1}\n");
    assert_fine(run);
    assert_false(was_asked(run, "time-true"));
}

/* --- find, show, doctor --- */

#define FOUND                                                                  \
    "{\"sensors\": [{\"sensor\": \"10.42.0.37\", \"how\": \"answers\"}]}\n"
#define NOTHING_FOUND "{\"sensors\": []}\n"

static record_tool *find(struct run *run, const char *text, int status)
{
    record_tool *t = tool(run, "lumctl find --subnet 10.42.0.32/27 --json",
                          3 * S, 6 * S, status);
    print(t, 5900 * MS, text);
    return t;
}

static void a_sensor_that_answered_is_found(void **state)
{
    struct run *run = *state;
    (void)find(run, FOUND, 0);
    exchange(run, 0, 4 * S, 7, 0);
    assert_fine(run);
    assert_true(was_asked(run, "found-true"));
    assert_true(was_asked(run, "found-all"));
}

static void a_sensor_that_did_not_answer_is_not_found(void **state)
{
    struct run *run = *state;
    (void)find(run, FOUND, 0);
    assert_breaks(run, "found-true");
}

static void a_sensor_that_find_forgets_is_missed(void **state)
{
    struct run *run = *state;
    (void)find(run, NOTHING_FOUND, 3);
    exchange(run, 0, 4 * S, 7, 0);
    assert_breaks(run, "found-all");
}

static void in_calm_a_sensor_is_found(void **state)
{
    struct run *run = *state;
    (void)find(run, NOTHING_FOUND, 3);
    (void)tool(run, "lumsim --log -", 0, RECORD_NEVER, 0);
    run->record.tools[1].host = 2;
    say(run, BOOT);
    assert_breaks(run, "found-in-calm");
}

static void the_status_of_find_is_that_of_its_list(void **state)
{
    struct run *run = *state;
    (void)find(run, FOUND, 3);
    exchange(run, 0, 4 * S, 7, 0);
    assert_breaks(run, "status-of-find");
}

static void show_tells_whether_a_sensor_answers(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl show --json", 1 * S, 3 * S, 0);
    print(t, 2900 * MS, "{\"answers\": true}\n");
    assert_breaks(run, "show-true");
}

static void show_does_not_overhear_an_answer(void **state)
{
    struct run *run = *state;
    print(tool(run, "lumctl show", 1 * S, 3 * S, 3), 2900 * MS, "\n");
    exchange(run, 0, 2 * S, 7, 0);
    assert_breaks(run, "show-true");
}

static void doctor_does_not_invent_answers(void **state)
{
    struct run *run = *state;
    print(tool(run, "lumctl doctor --json", 1 * S, 3 * S, 0), 2900 * MS,
          "{\"checks\": [{\"name\": \"answer\", \"result\": \"fine\"}]}\n");
    assert_breaks(run, "doctor-true");
}

static void doctor_does_not_overhear_an_answer(void **state)
{
    struct run *run = *state;
    print(tool(run, "lumctl doctor", 3 * S, 5 * S, 3), 4900 * MS,
          "no answer to 4 timestamp requests to 10.42.0.37\n");
    (void)tool(run, "lumsim --log -", 0, RECORD_NEVER, 0);
    run->record.tools[1].host = 2;
    say(run, BOOT);
    exchange(run, 0, 4 * S, 7, 0);
    assert_breaks(run, "doctor-true");
}

/* --- Ends --- */

static void in_calm_a_setting_ends_with_0(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl time", 3 * S, 4 * S, 4);
    (void)tool(run, "lumsim --log -", 0, RECORD_NEVER, 0);
    run->record.tools[1].host = 2;
    say(run, BOOT);
    assert_breaks(run, "status-in-calm");
}

/* Two owners on two computers take each other's data. */
static void a_shared_sensor_is_no_calm(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37 --duration 2", 3 * S, 9 * S, 3);
    (void)tool(run, "lumsim --log -", 0, RECORD_NEVER, 0);
    run->record.tools[1].host = 2;
    (void)tool(run, "lumdump udp://10.42.0.37", 4 * S, 8 * S, 3);
    run->record.tools[2].host = 3;
    say(run, BOOT);
    judge(run);
    assert_false(verdict_has(&run->verdict, "status-in-calm"));
    run->record.tools[2].began_ns = 9500 * MS;
    run->record.tools[2].ended_ns = 9600 * MS;
    judge(run);
    assert_true(verdict_has(&run->verdict, "status-in-calm"));
}

static record_tool *recording_with_a_signal(struct run *run, int status)
{
    record_tool *t =
        tool(run, "lumdump udp://10.42.0.37 -o a.csv", 1 * S, 4 * S, status);
    record_signal_to(&run->record, t, 3900 * MS, SIGINT);
    beats(run, 0, 1100 * MS, 3800 * MS);
    return t;
}

static void a_recording_ends_in_good_order(void **state)
{
    struct run *run = *state;
    recording_with_a_signal(run, 0)->status = SIGINT;
    assert_breaks(run, "status-of-signal");
}

static void a_recording_without_data_ends_with_3(void **state)
{
    struct run *run = *state;
    (void)recording_with_a_signal(run, 0);
    assert_breaks(run, "status-of-signal");
}

static void a_recording_with_data_ends_with_0(void **state)
{
    struct run *run = *state;
    (void)recording_with_a_signal(run, 0);
    data(run, 0, 3850 * MS, "data");
    assert_fine(run);
    assert_true(was_asked(run, "status-of-signal"));
}

static void what_is_interrupted_ends_by_the_signal(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl power 50", 1 * S, 2 * S, 1);
    record_signal_to(&run->record, t, 1900 * MS, SIGINT);
    t->err = copy("lumctl: interrupted: whether the sensor got it ...\n");
    assert_breaks(run, "status-of-signal");
}

/* --- At each event --- */

static void a_laser_is_due_while_it_is_on(void **state)
{
    struct run *run = *state;
    judge_watch watch = {0};
    say(run, BOOT BEAT("1.000000") LASER("1.500000", "true")
                 LASER("3.000000", "false"));
    const record_device *d = &run->record.devices[0];
    for (size_t i = 0; i < 3; i++) {
        judge_watch_line(&watch, &d->lines[i], &run->verdict);
    }
    assert_int_equal(judge_watch_due(&watch), 4200 * MS + 1);
    judge_watch_until(&watch, 4200 * MS, &run->verdict);
    assert_false(verdict_has(&run->verdict, "laser-late"));
    judge_watch now = watch;
    judge_watch_until(&now, 4200 * MS + 1, &run->verdict);
    assert_true(verdict_has(&run->verdict, "laser-late"));
    assert_int_equal(judge_watch_due(&now), RECORD_NEVER);
    judge_watch_line(&watch, &d->lines[3], &run->verdict);
    assert_int_equal(judge_watch_due(&watch), RECORD_NEVER);
}

static void an_on_is_judged_when_it_is_sent(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 1, "50p");
    judge_on_sent(&run->record, &run->record.datagrams[0], &run->verdict);
    assert_int_equal(run->verdict.count, 0);
    command(run, 0, 1200 * MS, 2, "u");
    judge_on_sent(&run->record, &run->record.datagrams[1], &run->verdict);
    assert_true(verdict_has(&run->verdict, "laser-asked"));
}

/* --- Points --- */

#define PACKET 24u

static void put_u16(uint8_t *at, unsigned value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}

/* Angles of pixels, or a word of 1.95 m for each. */
static void keep(record_tool *t, unsigned tag, unsigned line, unsigned first,
                 unsigned count)
{
    static const uint8_t begin[] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe,
                                    0x34, 0x12, 8,    0,    0,    0};
    uint8_t bytes[PACKET + 4 * 1000] = {0};
    memcpy(bytes, begin, sizeof begin);
    bytes[12] = (uint8_t)tag;
    put_u16(bytes + 14, line);
    put_u16(bytes + 16, count);
    put_u16(bytes + 18, tag == 2 ? first : 0);
    put_u16(bytes + 20, line * 1500);
    for (unsigned i = 0; i < count && tag == 3; i++) {
        const uint32_t word = 1000u << 12 | 0x400u | (first + i);
        put_u16(bytes + PACKET + (size_t)4 * i, word & 0xffffu);
        put_u16(bytes + PACKET + (size_t)4 * i + 2, word >> 16);
    }
    record_keep(t, bytes, PACKET + (size_t)4 * count);
}

#define SUMMARY(received, points, lines)                                       \
    "{\"received\": " received                                                 \
    ", \"ring_drops\": 0, \"outputs\": [{\"name\": "                           \
    "\"a.csv\", \"end\": \"done\", \"datagrams\": " received                   \
    ", \"dropped\": 0}], \"sensors\": [{\"lines\": " lines                     \
    ", \"points\": " points "}]}"

/* Two lines, of which the second lacks angles. */
static record_tool *recorded(struct run *run, const char *summary)
{
    record_tool *t =
        tool(run, "lumdump udp://10.42.0.37 -o a.csv", 1 * S, 3 * S, 0);
    keep(t, 2, 1, 0, 500);
    keep(t, 2, 1, 500, 500);
    keep(t, 3, 1, 10, 3);
    keep(t, 2, 2, 0, 500);
    keep(t, 3, 2, 499, 2);
    keep(t, 3, 2, 499, 2); /* again */
    t->out = copy(summary);
    return t;
}

static void assert_points(struct run *run, const char *summary, bool is_true)
{
    (void)recorded(run, summary);
    judge_points(&run->record, &run->verdict);
    assert_true(was_asked(run, "counts-of-lines"));
    assert_true(verdict_has(&run->verdict, "counts-of-lines") != is_true);
}

static void points_are_those_of_the_datagrams(void **state)
{
    assert_points(*state, SUMMARY("6", "4", "2"), true);
}

static void a_point_too_few_is_found(void **state)
{
    assert_points(*state, SUMMARY("6", "3", "2"), false);
}

static void a_line_too_many_is_found(void **state)
{
    assert_points(*state, SUMMARY("6", "4", "3"), false);
}

/* Those that the summary does not count as received. */
static void what_came_after_the_summary_does_not_count(void **state)
{
    assert_points(*state, SUMMARY("4", "3", "2"), true);
}

static void assert_written(struct run *run, const char *text, bool is_true)
{
    const judge_file file = {"a.csv", (const uint8_t *)text, strlen(text), S,
                             true};
    (void)recorded(run, SUMMARY("6", "4", "2"));
    judge_cloud(&run->record, 0, &file, &run->verdict);
    assert_true(was_asked(run, "points-written"));
    assert_true(verdict_has(&run->verdict, "points-written") != is_true);
}

static void a_table_has_the_points_that_came(void **state)
{
    assert_written(*state,
                   "x,range,y\n1,1.9500,2\n1,1.9500,2\n1,1.9500,2\n"
                   "1,1.9500,2\n",
                   true);
}

static void a_row_that_lacks_is_found(void **state)
{
    assert_written(*state, "x,range,y\n1,2.6,2\n1,2.6,2\n1,2.6,2\n", false);
}

static void a_range_that_is_another_is_found(void **state)
{
    assert_written(*state,
                   "x,range,y\n1,1.9500,2\n1,1.9500,2\n1,1.9500,2\n"
                   "1,1.9700,2\n",
                   false);
}

static void what_is_too_much_to_keep_is_not_judged(void **state)
{
    struct run *run = *state;
    recorded(run, SUMMARY("6", "9", "9"))->is_too_much = true;
    judge_points(&run->record, &run->verdict);
    assert_false(was_asked(run, "counts-of-lines"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FACT(a_table_that_is_full_is_told),
        FACT(more_rules_than_there_is_room_for_are_told),
        FACT(a_rule_is_left_with_need_alone),
        FACT(a_rule_that_is_broken_may_be_left),
        FACT(a_line_of_a_shell_is_done),
        FACT(a_line_that_no_sensor_did_is_found),
        FACT(each_line_is_judged_by_itself),
        FACT(a_laser_that_a_shell_calls_off_is_off),
        FACT(a_report_comes_within_the_limit_of_its_line),
        FACT(a_report_is_of_the_line_that_is_not_over),
        FACT(a_laser_on_is_taken_back_by_its_own_line),
        FACT(the_limit_of_a_line_begins_behind_the_one_before),
        FACT(a_report_of_what_nobody_typed_is_found),
        FACT(a_line_that_a_shell_forgets_is_found),
        FACT(a_shell_that_is_to_end_sends_no_heartbeat_more),
        FACT(an_offset_within_its_error_is_true),
        FACT(an_offset_beyond_its_error_is_found),
        FACT(an_offset_below_its_error_is_found),
        FACT(wraps_of_the_clock_do_not_count),
        FACT(a_line_of_a_watch_is_read),
        FACT(an_offset_for_people_is_read),
        FACT(a_wrong_offset_for_people_is_found),
        FACT(clocks_beyond_the_promise_are_not_asked),
        FACT(a_sensor_that_answered_is_found),
        FACT(a_sensor_that_did_not_answer_is_not_found),
        FACT(a_sensor_that_find_forgets_is_missed),
        FACT(in_calm_a_sensor_is_found),
        FACT(the_status_of_find_is_that_of_its_list),
        FACT(show_tells_whether_a_sensor_answers),
        FACT(show_does_not_overhear_an_answer),
        FACT(doctor_does_not_invent_answers),
        FACT(doctor_does_not_overhear_an_answer),
        FACT(in_calm_a_setting_ends_with_0),
        FACT(a_shared_sensor_is_no_calm),
        FACT(a_recording_ends_in_good_order),
        FACT(a_recording_without_data_ends_with_3),
        FACT(a_recording_with_data_ends_with_0),
        FACT(what_is_interrupted_ends_by_the_signal),
        FACT(a_laser_is_due_while_it_is_on),
        FACT(an_on_is_judged_when_it_is_sent),
        FACT(points_are_those_of_the_datagrams),
        FACT(a_point_too_few_is_found),
        FACT(a_line_too_many_is_found),
        FACT(what_came_after_the_summary_does_not_count),
        FACT(a_table_has_the_points_that_came),
        FACT(a_row_that_lacks_is_found),
        FACT(a_range_that_is_another_is_found),
        FACT(what_is_too_much_to_keep_is_not_judged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
