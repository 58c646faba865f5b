/* Made-up runs: each judge is content with a good one, and finds what is wrong
 * with the others. */
#define _POSIX_C_SOURCE 200809L
#include "test_run.h"

#include <signal.h>

/* --- The log --- */

static void lines_of_a_log_are_read_as_they_grow(void **state)
{
    struct run *run = *state;
    static const char log[] =
        BOOT "{\"t\": 1.500000, \"event\": \"tlv\", \"from\": "
             "\"10.42.0.1:40000\", \"sequence\": 7, \"note\": \"50p; u\"}\n"
             "{\"t\": 1.500100, \"event\": \"laser\", \"up\": true}\n";
    (void)record_add_device(&run->record, 2, 0);
    for (size_t n = 0; n <= strlen(log); n++) {
        record_read_log(&run->record, 0, log, n, NULL, NULL);
    }
    const record_device *d = &run->record.devices[0];
    assert_int_equal(d->count, 3);
    assert_int_equal(d->lines[0].event, RECORD_START);
    assert_int_equal(d->lines[0].peer.address, SENSOR);
    assert_int_equal(d->lines[1].t_ns, 1500 * MS);
    assert_int_equal(d->lines[1].sequence, 7);
    assert_int_equal(d->lines[1].peer.port, 40000);
    assert_true(record_was_done(&d->lines[1], "u"));
    assert_true(record_was_done(&d->lines[1], "50p"));
    assert_false(record_was_done(&d->lines[1], "p"));
    assert_true(d->lines[2].is_yes);
}

static void a_refusal_is_not_done(void **state)
{
    struct run *run = *state;
    say(run, "{\"t\": 1.0, \"event\": \"tlv\", \"note\": \"refused u\"}\n");
    assert_false(record_was_done(&run->record.devices[0].lines[0], "u"));
}

static void datagrams_are_told_apart(void **state)
{
    static const uint8_t on[] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34,
                                 0x12, 7,    0,    0,    0,    7,    0,
                                 0,    0,    1,    0,    1,    0,    'u'};
    record_datagram d = {0};
    (void)state;
    record_look_at(&d, on, sizeof on);
    assert_int_equal(d.packet, RECORD_IS_TLV);
    assert_int_equal(d.sequence, 7);
    assert_string_equal(d.command, "u");
    record_look_at(&d, on, 11);
    assert_int_equal(d.packet, RECORD_IS_FOREIGN);
}

/* --- The laser --- */

/* A recording with the laser on, from 1 s to 5 s. */
static record_tool *record_with_laser(struct run *run)
{
    record_tool *t = tool(run, "lumdump udp://10.42.0.37 --laser -o a.pcap",
                          1 * S, 5500 * MS, 0);
    beats(run, 0, 1050 * MS, 4850 * MS);
    for (size_t i = 1; i < run->record.datagram_count; i++) {
        run->record.datagrams[i].number += 1000;
    }
    run->numbers += 2000;
    return t;
}

static void after_laser_off(struct run *run)
{
    command(run, 0, 5000 * MS, 2, "d");
    command(run, 0, 5301 * MS, 3, "");
}

#define ON_AND_OFF                                                             \
    BOOT BEAT("1.050000") TLV("1.060000", "1", "u") LASER("1.060000", "true")  \
        BEAT("3.050000") BEAT("4.850000") TLV("5.000000", "2", "d")            \
            LASER("5.000000", "false") TLV("5.301000", "3", "status poll")

/* Its `u` comes behind the first heartbeat. */
static void insert_on(struct run *run)
{
    command(run, 0, 1060 * MS, 1, "u");
    struct record *r = &run->record;
    const record_datagram on = r->datagrams[r->datagram_count - 1];
    memmove(r->datagrams + 2, r->datagrams + 1,
            (r->datagram_count - 2) * sizeof on);
    r->datagrams[1] = on;
    r->datagrams[1].number = 500;
}

static void a_recording_with_the_laser_is_fine(void **state)
{
    struct run *run = *state;
    (void)record_with_laser(run);
    insert_on(run);
    after_laser_off(run);
    say(run, ON_AND_OFF);
    assert_fine(run);
    assert_true(was_asked(run, "laser-late"));
    assert_true(was_asked(run, "laser-asked"));
    assert_true(was_asked(run, "off-true"));
    assert_true(was_asked(run, "heartbeat-gap"));
}

static void a_laser_without_heartbeats_is_late(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true") LASER("4.201000", "false"));
    assert_breaks(run, "laser-late");
}

static void a_laser_that_ends_in_time_is_not_late(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true") LASER("4.199000", "false"));
    assert_fine(run);
}

static void a_laser_that_never_ends_is_late(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true"));
    assert_breaks(run, "laser-late");
}

static void power_off_ends_the_laser(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true"));
    run->record.devices[0].ended_ns = 4 * S;
    assert_fine(run);
}

static void a_heartbeat_that_comes_too_late_does_not_excuse(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true") BEAT("4.300000")
                     LASER("4.400000", "false"));
    assert_breaks(run, "laser-late");
}

static void heartbeats_end_with_a_signal(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl heartbeat", 1 * S, 6 * S, 0);
    record_signal_to(&run->record, t, 3 * S, SIGTERM);
    beats(run, 0, 1 * S, 3900 * MS);
    assert_fine(run);
    beat(run, 0, 4100 * MS);
    assert_breaks(run, "heartbeat-late");
}

static void a_stop_does_not_count_as_going_on(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl heartbeat", 1 * S, 9 * S, 0);
    record_signal_to(&run->record, t, 3 * S, SIGSTOP);
    record_signal_to(&run->record, t, 3 * S, SIGTERM);
    record_signal_to(&run->record, t, 8 * S, SIGCONT);
    beats(run, 0, 1 * S, 2900 * MS);
    beat(run, 0, 8100 * MS);
    assert_fine(run);
}

static void nobody_may_switch_it_on_unasked(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 1, "u");
    assert_breaks(run, "laser-asked");
}

static void an_on_that_nobody_sent_is_found(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") LASER("1.100000", "true")
                 LASER("2.000000", "false"));
    assert_breaks(run, "laser-asked");
}

static void an_on_after_an_off_is_found(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.000000", "1", "u")
                 TLV("1.050000", "1", "d") LASER("1.100000", "true")
                     LASER("2.000000", "false"));
    assert_breaks(run, "laser-asked");
}

static void no_heartbeat_brings_a_laser_back(void **state)
{
    struct run *run = *state;
    say(run,
        BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
            STATUS("1.100000", "2048") LASER("1.100000", "true")
                STATUS("4.000000", "2064") LASER("4.000000", "false")
                    BEAT("9.000000") STATUS("9.000000", "2048")
                        LASER("9.000000", "true") LASER("11.000000", "false"));
    assert_breaks(run, "laser-asked");
}

static void a_reboot_forgets_a_laser_on(void **state)
{
    struct run *run = *state;
    say(run, BOOT BEAT("1.000000") TLV("1.100000", "1", "u")
                 LASER("1.100000", "true") FAULT("2.000000", "reboot", "false")
                     LASER("2.000000", "false") BEAT("3.000000")
                         LASER("3.000000", "true") LASER("4.000000", "false"));
    assert_breaks(run, "laser-asked");
}

static void a_session_does_not_switch_on_again(void **state)
{
    struct run *run = *state;
    (void)record_with_laser(run);
    insert_on(run);
    after_laser_off(run);
    command(run, 0, 5310 * MS, 4, "u");
    say(run, ON_AND_OFF);
    assert_breaks(run, "laser-again");
}

static void a_session_gives_up_in_time(void **state)
{
    struct run *run = *state;
    record_tool *t =
        tool(run, "lumdump udp://10.42.0.37 --laser", 0, 20 * S, 1);
    t->has_stalled = true; /* this is not about its end */
    command(run, 0, 1 * S, 1, "u");
    command(run, 0, 8400 * MS, 2, "u");
    assert_fine(run);
    command(run, 0, 8600 * MS, 2, "u");
    assert_breaks(run, "laser-again");
}

static void who_was_held_up_does_not_switch_on(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl laser on", 1 * S, 9 * S, 3);
    command(run, 0, 1100 * MS, 1, "u");
    record_signal_to(&run->record, t, 1200 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 4 * S, SIGCONT);
    assert_fine(run);
    command(run, 0, 4100 * MS, 1, "u");
    assert_breaks(run, "laser-again");
}

static void who_is_stopped_hears_later_that_it_is_to_end(void **state)
{
    struct run *run = *state;
    record_tool *t =
        tool(run, "lumdump udp://10.42.0.37 --laser", 0, 20 * S, 1);
    t->has_stalled = true; /* this is not about its end */
    command(run, 0, 1 * S, 1, "u");
    record_signal_to(&run->record, t, 1500 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 2 * S, SIGTERM);
    record_signal_to(&run->record, t, 3200 * MS, SIGCONT);
    command(run, 0, 3300 * MS, 1, "u");
    assert_fine(run);
    command(run, 0, 4300 * MS, 1, "u");
    assert_breaks(run, "laser-again");
}

/* Between its look and its send: the first that it sends then. */
static void who_was_stopped_before_a_send_cannot_know(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl laser on", 1 * S, 9 * S, 3);
    command(run, 0, 1100 * MS, 1, "u");
    record_signal_to(&run->record, t, 1500 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 4 * S, SIGCONT);
    record_stop_before_send(t, 1500 * MS);
    command(run, 0, 4 * S, 1, "u");
    assert_fine(run);
    command(run, 0, 4400 * MS, 1, "u");
    assert_breaks(run, "laser-again");
}

#define HAZARD                                                                 \
    BOOT BEAT("1.050000") TLV("1.060000", "1", "u") LASER("1.060000", "true")  \
        BEAT("3.050000") FAULT("5.000000", "fan", "false")                     \
            LASER("5.000000", "false")

static void a_hazard_that_was_seen_keeps_the_laser_down(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37 --laser", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 12 * S;
    say(run, HAZARD TLV("5.500000", "2", "d") BEAT("9.900000")
                 FAULT("10.000000", "fan", "true"));
    assert_fine(run);
    assert_true(was_asked(run, "laser-back"));
}

static void a_laser_that_comes_back_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37 --laser", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 12 * S;
    say(run, HAZARD BEAT("9.900000") FAULT("10.000000", "fan", "true")
                 LASER("10.000000", "true"));
    assert_breaks(run, "laser-back");
}

static void a_network_that_was_down_excuses_it(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37 --laser", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 12 * S;
    (void)record_add_fault(&run->record, "loss", 6 * S, 7 * S);
    say(run, HAZARD BEAT("9.900000") FAULT("10.000000", "fan", "true")
                 LASER("10.000000", "true"));
    assert_fine(run);
}

/* --- What is done --- */

static void a_setting_that_the_sensor_did_is_done(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "50p");
    say(run, BOOT TLV("1.101000", "9", "50p"));
    assert_fine(run);
    assert_true(was_asked(run, "done-true"));
}

static void a_setting_that_the_sensor_refused_is_not_done(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "50p");
    say(run, BOOT TLV("1.101000", "9", "refused 50p"));
    assert_breaks(run, "done-true");
}

static void each_word_of_send_is_looked_for(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl send '50p 15y'", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "50p 15y");
    say(run, BOOT TLV("1.101000", "9", "50p"));
    assert_breaks(run, "done-true");
}

static void what_another_tool_did_does_not_count(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 2 * S, 0);
    (void)tool(run, "lumctl power 50", 1 * S, 2 * S, 3);
    command(run, 1, 1100 * MS, 9, "50p");
    say(run, BOOT "{\"t\": 1.101, \"event\": \"tlv\", \"from\": "
                  "\"10.42.0.1:40001\", \"note\": \"50p\"}\n");
    assert_breaks(run, "done-true");
}

static void a_laser_that_never_came_up_is_not_on(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl laser on", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "u");
    say(run, BOOT TLV("1.101000", "9", "u"));
    assert_breaks(run, "on-true");
}

/* It logs when it looked; what it then read may be younger. */
static void a_sensor_that_looked_before_a_command_was_sent_did_it(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 2 * S, 0);
    command(run, 0, 1100500000, 9, "50p");
    say(run, BOOT TLV("1.100000", "9", "50p"));
    assert_fine(run);
    assert_true(was_asked(run, "done-true"));
}

#define UP "{\"t\": 1.500000, \"event\": \"laser\", \"up\": true}\n"

static void a_wait_for_what_was_so_is_fine(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl wait up --for 3", 1 * S, 2 * S, 0);
    (void)tool(run, "lumctl wait down", 1 * S, 2 * S, 0);
    (void)tool(run, "lumctl wait clear", 1 * S, 2 * S, 0);
    say(run, BOOT UP);
    run->verdict.count = 0;
    judge_done(&run->record, &run->verdict);
    assert_int_equal(run->verdict.count, 0);
    assert_true(was_asked(run, "wait-true"));
}

static void a_wait_for_what_never_was_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl wait up --for 3", 1 * S, 2 * S, 0);
    say(run, BOOT);
    assert_breaks(run, "wait-true");
}

static void switch_off(struct run *run)
{
    (void)tool(run, "lumctl laser off", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "d");
    command(run, 0, 1450 * MS, 10, "");
}

static void an_off_that_looked_twice_is_fine(void **state)
{
    struct run *run = *state;
    switch_off(run);
    say(run,
        BOOT TLV("1.101000", "9", "d") TLV("1.451000", "10", "status poll"));
    assert_fine(run);
    assert_true(was_asked(run, "off-seen-twice"));
}

static void an_off_that_looked_once_is_found(void **state)
{
    struct run *run = *state;
    switch_off(run);
    say(run, BOOT TLV("1.101000", "9", "d"));
    assert_breaks(run, "off-seen-twice");
}

static void an_off_that_looked_at_once_is_found(void **state)
{
    struct run *run = *state;
    switch_off(run);
    say(run,
        BOOT TLV("1.200000", "9", "d") TLV("1.451000", "10", "status poll"));
    assert_breaks(run, "off-seen-twice");
}

static void an_off_whose_laser_is_on_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl heartbeat", 0, RECORD_NEVER, 0);
    switch_off(run);
    run->record.now_ns = 3 * S;
    run->record.datagrams[0].from = port_of(0);
    run->record.datagrams[0].sender = 1;
    run->record.datagrams[1].from = port_of(0);
    run->record.datagrams[1].sender = 1;
    say(run, BOOT BEAT("0.500000") TLV("0.600000", "1", "u")
                 LASER("0.600000", "true") TLV("1.101000", "9", "d")
                     TLV("1.451000", "10", "status poll"));
    assert_breaks(run, "off-true");
}

static void an_on_that_was_not_taken_back_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl laser on", 1 * S, 3 * S, 4);
    t->err = copy("lumctl: cancelled: it will not come up by itself\n");
    command(run, 0, 1100 * MS, 9, "u");
    command(run, 0, 1200 * MS, 10, "d");
    say(run, BOOT STATUS("0.500000", "576") TLV("1.101000", "9", "u")
                 STATUS("1.101000", "2112") TLV("1.201000", "10", "d"));
    assert_breaks(run, "taken-back");
}

static void a_sensor_that_did_not_move_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl set-ip 10.42.0.99", 1 * S, 2 * S, 0);
    say(run, BOOT);
    assert_breaks(run, "move-true");
}

static void a_sensor_that_moved_is_fine(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl set-ip 10.42.0.99", 1 * S, 2 * S, 0);
    say(run, BOOT "{\"t\": 1.2, \"event\": \"move\", \"address\": "
                  "\"10.42.0.99\", \"done\": true}\n");
    assert_fine(run);
}

/* Asked at 1.1 s, and answered at 1.2 s. */
static void assert_status(struct run *run, const char *log, bool is_true)
{
    record_tool *t = tool(run, "lumctl status --json", 1 * S, 2 * S, 0);
    t->out = copy("{\"status\": 2048}\n");
    command(run, 0, 1100 * MS, 7, "");
    record_datagram *answer = mail(run, 0, 1200 * MS, true);
    answer->packet = RECORD_IS_TLV;
    answer->sequence = 7;
    say(run, log);
    if (is_true) {
        assert_fine(run);
        assert_true(was_asked(run, "status-true"));
    } else {
        assert_breaks(run, "status-true");
    }
}

static void a_status_between_request_and_answer_is_true(void **state)
{
    assert_status(*state,
                  BOOT STATUS("0.500000", "512") STATUS("1.150000", "2048")
                      STATUS("1.180000", "512"),
                  true);
}

static void a_status_before_the_request_is_old(void **state)
{
    assert_status(*state,
                  BOOT STATUS("0.500000", "2048") STATUS("1.050000", "512"),
                  false);
}

static void a_status_behind_the_answer_is_invented(void **state)
{
    assert_status(*state,
                  BOOT STATUS("0.500000", "512") STATUS("1.300000", "2048"),
                  false);
}

static void a_status_that_nobody_had_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status --json", 1 * S, 2 * S, 0);
    t->out = copy("{\"status\": 528}\n");
    say(run, BOOT STATUS("0.500000", "2048"));
    assert_breaks(run, "status-true");
}

static void done_and_the_exit_status_agree(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl power 50 --json", 1 * S, 2 * S, 1);
    t->out = copy("{\"command\": \"50p\", \"done\": true}\n");
    assert_breaks(run, "done-as-status");
}

/* --- Limits --- */

static void a_request_ends_in_time(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status --timeout 100 --retries 1", 1 * S,
                          1900 * MS, 3);
    assert_fine(run);
    t->ended_ns = 1950 * MS;
    assert_breaks(run, "limit");
}

static void a_stopped_tool_has_its_time_later(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status", 1 * S, 30 * S, 3);
    record_signal_to(&run->record, t, 2 * S, SIGSTOP);
    record_signal_to(&run->record, t, 29 * S, SIGCONT);
    assert_fine(run);
}

static void a_tool_that_hangs_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl laser off", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 20 * S;
    assert_breaks(run, "limit");
}

static void a_watch_ends_soon_after_a_signal(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status --watch", 1 * S, 500 * S, 0);
    record_signal_to(&run->record, t, 499 * S, SIGINT);
    assert_fine(run);
    t->ended_ns = 503 * S;
    assert_breaks(run, "limit-after-signal");
}

static void a_recording_without_data_ends(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumdump udp://10.42.0.37", 1 * S, 6200 * MS, 3);
    assert_fine(run);
    t->ended_ns = 7 * S;
    assert_breaks(run, "limit");
}

/* --- Datagrams and counters --- */

static void a_datagram_has_one_fate(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 3);
    command(run, 0, 1100 * MS, 9, "");
    run->record.datagrams[0].fates = 2;
    assert_breaks(run, "one-fate");
}

static void a_datagram_that_vanished_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 3);
    command(run, 0, 1100 * MS, 9, "");
    run->record.datagrams[0].fates = 0;
    run->record.datagrams[0].fate = RECORD_UNDER_WAY;
    assert_breaks(run, "one-fate");
}

static record_tool *recorded(struct run *run, const char *json)
{
    record_tool *t = tool(run, "lumdump udp://10.42.0.37 --json --duration 2",
                          1 * S, 4 * S, 0);
    t->out = copy(json);
    beat(run, 0, 1100 * MS);
    data(run, 0, 1200 * MS, "one");
    data(run, 0, 1300 * MS, "two");
    data(run, 0, 1400 * MS, "three");
    run->record.datagrams[3].fate = RECORD_DROPPED;
    return t;
}

static void counters_that_agree_are_fine(void **state)
{
    struct run *run = *state;
    (void)recorded(run, "{\"received\": 2, \"kernel_drops\": 1, "
                        "\"foreign_source\": 0, \"heartbeats_sent\": 1, "
                        "\"outputs\": [{\"name\": \"a\", \"end\": \"done\", "
                        "\"datagrams\": 1, \"dropped\": 1}]}");
    assert_fine(run);
    assert_true(was_asked(run, "counts"));
    assert_true(was_asked(run, "counts-of-outputs"));
}

static void a_counter_that_misses_one_is_found(void **state)
{
    static const char *const wrong[] = {
        "{\"received\": 1, \"kernel_drops\": 1, \"heartbeats_sent\": 1}",
        "{\"received\": 2, \"kernel_drops\": 2, \"heartbeats_sent\": 1}",
        "{\"received\": 2, \"foreign_source\": 1, \"heartbeats_sent\": 1}",
        "{\"received\": 2, \"kernel_drops\": 1, \"heartbeats_sent\": 2}"};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        void *each = NULL;
        (void)setup(&each);
        (void)recorded(each, wrong[i]);
        assert_breaks(each, "counts");
        (void)teardown(&each);
    }
}

static void an_output_that_misses_one_is_found(void **state)
{
    struct run *run = *state;
    (void)recorded(run, "{\"received\": 2, \"outputs\": [{\"name\": \"a\", "
                        "\"end\": \"done\", \"datagrams\": 1, \"dropped\": "
                        "0}]}");
    assert_breaks(run, "counts-of-outputs");
}

static void heartbeats_of_lumctl_are_counted(void **state)
{
    struct run *run = *state;
    record_tool *t =
        tool(run, "lumctl heartbeat --json --duration 1", 1 * S, 2 * S, 0);
    t->out = copy("{\"duration_s\": 1.000, \"heartbeats\": 1, "
                  "\"packets\": 1, \"bytes\": 3, \"kernel_drops\": 0}");
    beat(run, 0, 1100 * MS);
    data(run, 0, 1200 * MS, "one");
    assert_fine(run);
    beat(run, 0, 1300 * MS);
    assert_breaks(run, "counts");
}

/* --- Exit statuses --- */

static void a_status_that_no_page_has_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumsim", 1 * S, 2 * S, 3);
    run->verdict.count = 0;
    judge_status(&run->record, &run->verdict);
    assert_true(verdict_has(&run->verdict, "status-known"));
}

static void a_crash_is_found(void **state)
{
    struct run *run = *state;
    tool(run, "lumctl status", 1 * S, 2 * S, 0)->status = SIGSEGV;
    assert_breaks(run, "ends-by-signal");
}

static void who_got_a_signal_may_end_by_it(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl status", 1 * S, 1200 * MS, 0);
    t->status = SIGINT;
    record_signal_to(&run->record, t, 1100 * MS, SIGINT);
    assert_fine(run);
}

static void bad_arguments_are_two_and_nothing_else_is(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl power 50", 1 * S, 2 * S, 2);
    t->is_wrong = true;
    assert_fine(run);
    t->is_wrong = false;
    assert_breaks(run, "status-2");
}

static void an_answer_that_was_read_is_no_silence(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 4 * S, 3);
    command(run, 0, 1100 * MS, 9, "");
    record_datagram *d = mail(run, 0, 1200 * MS, true);
    d->packet = RECORD_IS_TLV;
    d->sequence = 8;
    assert_fine(run);
    run->record.datagrams[1].sequence = 9;
    assert_breaks(run, "status-3");
}

/* An answer to the request with number 1 of lumctl send at 1.1 s, which has
 * five tries of 60 ms. */
static record_tool *answered(struct run *run, int64_t t_ns)
{
    record_tool *t = tool(run, "lumctl send u --timeout 60", 1 * S, 4 * S, 3);
    command(run, 0, 1100 * MS, 1, "u");
    record_datagram *d = mail(run, 0, t_ns - MS, true);
    d->packet = RECORD_IS_TLV;
    d->sequence = 1;
    return t;
}

static void an_answer_after_all_tries_is_silence(void **state)
{
    struct run *run = *state;
    record_tool *t = answered(run, 1500 * MS);
    command(run, 0, 2 * S, 2, "d");
    assert_fine(run);
    record_signal_to(&run->record, t, 1600 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 1900 * MS, SIGCONT);
    assert_fine(run);
    run->record.datagrams[1].fate_ns = 1390 * MS;
    assert_breaks(run, "status-3");
}

static void an_answer_after_a_stop_may_be_late(void **state)
{
    struct run *run = *state;
    record_tool *t = answered(run, 1390 * MS);
    record_signal_to(&run->record, t, 1200 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 1380 * MS, SIGCONT);
    assert_fine(run);
    run->record.datagrams[1].fate_ns = 1190 * MS;
    assert_breaks(run, "status-3");
}

static void data_that_was_read_is_no_silence(void **state)
{
    struct run *run = *state;
    tool(run, "lumdump udp://10.42.0.37", 1 * S, 6 * S, 3)->has_stalled = true;
    data(run, 0, 2 * S, "one");
    assert_breaks(run, "status-3");
}

static void four_needs_a_hazard(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 4);
    say(run, BOOT STATUS("0.500000", "2112"));
    assert_fine(run);
    say(run, STATUS("0.600000", "2048"));
    assert_breaks(run, "status-4");
}

static void a_hazard_needs_four(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 0);
    say(run, BOOT STATUS("0.500000", "2112"));
    assert_breaks(run, "status-0");
}

/* A sensor that is on, and answers. */
static void power_on(struct run *run, const char *lumsim)
{
    tool(run, lumsim, 0, RECORD_NEVER, 0)->host = 2;
    say(run, BOOT);
    run->record.now_ns = 10 * S;
}

static void silence_in_calm_is_found(void **state)
{
    struct run *run = *state;
    power_on(run, "lumsim");
    (void)tool(run, "lumctl status", 3 * S, 4 * S, 3);
    assert_breaks(run, "answers-in-calm");
}

static void silence_has_its_reasons(void **state)
{
    static const char *const sensors[] = {
        "lumsim --answer-loss 0.5", "lumsim --answer-delay 300", "lumsim"};
    (void)state;
    for (size_t i = 0; i < sizeof sensors / sizeof sensors[0]; i++) {
        void *each = NULL;
        (void)setup(&each);
        struct run *run = each;
        power_on(run, sensors[i]);
        (void)tool(run, "lumctl status", 3 * S, 4 * S, 3);
        if (i == 2) {
            (void)record_add_fault(&run->record, "cut", 3 * S, 4 * S);
        }
        assert_fine(run);
        (void)teardown(&each);
    }
}

/* Each takes the other's data away, and the protocol has no way to tell. */
static void an_owner_on_another_host_is_a_reason(void **state)
{
    struct run *run = *state;
    power_on(run, "lumsim");
    (void)tool(run, "lumctl status", 3 * S, 4 * S, 3);
    tool(run, "lumdump udp://10.42.0.37", 1 * S, 5 * S, 3)->host = 2;
    assert_fine(run);
}

static void a_failed_output_needs_a_status(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumdump udp://10.42.0.37 --json --duration 1",
                          1 * S, 3 * S, 0);
    t->out = copy("{\"outputs\": [{\"end\": \"failed\"}]}");
    assert_breaks(run, "status-of-outputs");
}

static void a_send_is_looked_at(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl send u", 1 * S, 2 * S, 0);
    command(run, 0, 1100 * MS, 9, "u");
    say(run, BOOT TLV("1.101000", "9", "u"));
    assert_breaks(run, "on-true");
}

/* --- Owners and requests --- */

static void a_second_owner_is_told(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl heartbeat", 1 * S, 8 * S, 0);
    record_signal_to(&run->record, &run->record.tools[0], 7900 * MS, SIGINT);
    record_tool *t = tool(run, "lumdump udp://10.42.0.37", 3 * S, 3100 * MS, 1);
    t->err = copy("lumdump: lumctl [101] has the session with 10.42.0.37\n");
    beats(run, 0, 1100 * MS, 7900 * MS);
    assert_fine(run);
    assert_true(was_asked(run, "owner-told"));
    run->record.tools[1].err[0] = '\0';
    assert_breaks(run, "owner-told");
}

static void two_owners_at_once_are_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl heartbeat", 1 * S, RECORD_NEVER, 0);
    (void)tool(run, "lumctl heartbeat", 2 * S, RECORD_NEVER, 0);
    run->record.now_ns = 4 * S;
    for (int64_t t_ns = 2100 * MS; t_ns < 4 * S; t_ns += 200 * MS) {
        beat(run, 0, t_ns);
        beat(run, 1, t_ns + MS);
    }
    assert_breaks(run, "one-owner");
}

static void an_owner_that_is_not_there_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumdump udp://10.42.0.37", 3 * S, 3100 * MS, 1);
    t->err = copy("lumdump: lumctl [101] has the session with 10.42.0.37\n");
    assert_breaks(run, "owner-invented");
}

static void a_repeat_keeps_its_number(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 3 * S, 3);
    command(run, 0, 1100 * MS, 9, "50p");
    command(run, 0, 1500 * MS, 9, "50p");
    assert_fine(run);
    command(run, 0, 1900 * MS, 10, "50p");
    assert_breaks(run, "one-number");
}

static void a_repeat_of_what_was_held_up_comes_when_it_is_due(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumctl power 50", 1 * S, 3 * S, 3);
    record_signal_to(&run->record, t, 1100 * MS, SIGSTOP);
    record_signal_to(&run->record, t, 1400 * MS, SIGCONT);
    command(run, 0, 1400 * MS, 9, "50p");
    command(run, 0, 1500 * MS, 9, "50p");
    assert_fine(run);
    command(run, 0, 1600 * MS, 9, "50p");
    assert_breaks(run, "pause-of-tries");
}

static void a_repeat_waits(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50", 1 * S, 3 * S, 3);
    command(run, 0, 1100 * MS, 9, "50p");
    command(run, 0, 1300 * MS, 9, "50p");
    assert_breaks(run, "pause-of-tries");
}

static void tries_are_counted(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl power 50 --retries 1", 1 * S, 2 * S, 3);
    command(run, 0, 1100 * MS, 9, "50p");
    command(run, 0, 1500 * MS, 9, "50p");
    assert_fine(run);
    command(run, 0, 1900 * MS, 9, "50p");
    assert_breaks(run, "tries");
}

static void heartbeats_have_no_gaps(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl heartbeat", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 4 * S;
    beat(run, 0, 1100 * MS);
    beat(run, 0, 2250 * MS);
    beat(run, 0, 3900 * MS);
    assert_breaks(run, "heartbeat-gap");
}

static void heartbeats_that_never_come_again_are_a_gap(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl heartbeat", 1 * S, RECORD_NEVER, 0);
    run->record.now_ns = 4 * S;
    beat(run, 0, 1100 * MS);
    assert_breaks(run, "heartbeat-gap");
}

/* --- Files --- */

static void look(struct run *run, const char *name, const void *bytes,
                 size_t size, bool is_final)
{
    const judge_file file = {name, bytes, size, S, is_final};
    judge_whole(&file, &run->verdict);
}

static void assert_whole(struct run *run, const char *name, const char *text,
                         bool is_whole)
{
    run->verdict.count = 0;
    look(run, name, text, strlen(text), true);
    assert_int_equal(verdict_has(&run->verdict, "file-whole"), !is_whole);
}

static void files_of_text_are_whole_or_not(void **state)
{
    struct run *run = *state;
    assert_whole(run, "a.csv", "x,y\n1,2\n3,4\n", true);
    assert_whole(run, "a.csv", "x,y\n1,2\n3,4", false);
    assert_whole(run, "a.csv", "x,y\n1,2\n3\n", false);
    assert_whole(run, "a.csv", "", false);
    assert_whole(run, "a.yaml", "version: 1\n", true);
    assert_whole(run, "a.yaml", "version: 1", false);
    assert_whole(run, "a.unknown", "version: 1", true);
}

#define PLY                                                                    \
    "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"                 \
    "property float x\nproperty uchar eye\nend_header\n"
#define PCD "VERSION 0.7\nFIELDS x eye\nSIZE 4 1\nPOINTS 2\nDATA binary\n"

static void files_of_points_are_whole_or_not(void **state)
{
    struct run *run = *state;
    assert_whole(run, "a.ply", PLY "1234567890", true);
    assert_whole(run, "a.ply", PLY "123456789", false);
    assert_whole(run, "a.ply", PLY "123456789012345", false);
    assert_whole(run, "a.ply", "ply\nformat binary", false);
    assert_whole(run, "a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 2\nend_header\n1\n2\n",
                 true);
    assert_whole(run, "a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 2\nend_header\n1\n",
                 false);
    assert_whole(run, "a.pcd", PCD "1234567890", true);
    assert_whole(run, "a.pcd", PCD "12345", false);
    assert_whole(run, "a.las", "LASF", false);
    assert_whole(run, "a.png", "PNG, and no end of it", false);
    assert_whole(run, "a.json", "{\"a\": [\"}\\\"\", 1]}\n", true);
    assert_whole(run, "a.json", "{\"a\": [1}\n", false);
    assert_whole(run, "a.json", "{\"a\": \"1}\n", false);
    assert_whole(run, "a.json", "{\"a\": 1}", false);
    assert_whole(run, "a.prom", "a 1\nb", false);
}

static void las_counts_its_points(void **state)
{
    struct run *run = *state;
    uint8_t bytes[375 + 2 * 30] = {'L', 'A', 'S', 'F'};
    bytes[96] = 375 & 0xff;
    bytes[97] = 375 >> 8;
    bytes[105] = 30;
    bytes[247] = 2;
    look(run, "a.las", bytes, sizeof bytes, true);
    assert_int_equal(run->verdict.count, 0);
    look(run, "a.las", bytes, sizeof bytes - 30, true);
    assert_int_equal(run->verdict.count, 1);
}

static void expect_left(struct run *run, const char *name, const char *rule)
{
    const char *const names[] = {"f1.csv", name, NULL};
    run->verdict.count = 0;
    judge_left(&run->record, 1, names, &run->verdict);
    assert_int_equal(run->verdict.count, rule != NULL ? 1 : 0);
    assert_true(rule == NULL || verdict_has(&run->verdict, rule));
}

static void what_is_left_is_found(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumdump udp://10.42.0.37 -o f1.csv", 0, S, 0);
    expect_left(run, "f2.csv.01.part", NULL);
    expect_left(run, "f1.csv.01.part", "file-left");
    expect_left(run, ".f1.csv.lumsdk", "file-left");
    expect_left(run, "f1-0001.csv.01.part", "file-left");
    t->was_cut = true;
    expect_left(run, "f1.csv.01.part", NULL);
}

static void what_was_given_up_may_be_left(void **state)
{
    struct run *run = *state;
    record_tool *t = tool(run, "lumdump udp://10.42.0.37 -o f1.csv", 0, S, 1);
    t->err = copy("lumdump: f1.csv was waited for and is given up\n");
    expect_left(run, ".f1.csv.lumsdk", NULL);
}

static void an_output_that_is_not_there_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37 -o f3.csv", 0, S, 0);
    expect_left(run, "f2.csv", "file-there");
    (void)tool(run, "lumdump udp://10.42.0.37 -o f1.csv -o -", 0, S, 0);
    expect_left(run, "f3.csv", NULL);
}

/* --- Manners --- */

static void nobody_switches_off_unasked(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumdump udp://10.42.0.37", 1 * S, 2 * S, 3);
    command(run, 0, 1100 * MS, 1, "d");
    assert_breaks(run, "off-asked");
}

static void nobody_moves_a_sensor_unasked(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl status", 1 * S, 2 * S, 3);
    mail(run, 0, 1100 * MS, false)->packet = RECORD_IS_SET_IP;
    assert_breaks(run, "move-asked");
}

static void a_flood_is_found(void **state)
{
    struct run *run = *state;
    (void)tool(run, "lumctl find --subnet 10.42.0.0/22", 1 * S, 2 * S, 3);
    for (unsigned i = 0; i < 301; i++) {
        mail(run, 0, 1100 * MS + 3 * MS * i, false)->packet =
            RECORD_IS_TIMESTAMP;
    }
    assert_breaks(run, "no-flood");
}

/* A pcap file of payloads. */
static size_t capture(uint8_t *out, const char *const *payloads)
{
    static const uint8_t magic[4] = {0x4d, 0x3c, 0xb2, 0xa1};
    size_t n = 24;
    memset(out, 0, LONGEST);
    memcpy(out, magic, sizeof magic);
    for (; *payloads != NULL; payloads++) {
        const size_t len = strlen(*payloads);
        out[n + 8] = (uint8_t)(42 + len);
        out[n + 12] = (uint8_t)(42 + len);
        out[n + 16 + 39] = (uint8_t)(8 + len);
        memcpy(out + n + 58, *payloads, len);
        n += 58 + len;
    }
    return n;
}

static const char *const one_two[] = {"one", "two", NULL};

static void captures_are_whole_or_not(void **state)
{
    struct run *run = *state;
    uint8_t bytes[LONGEST];
    const size_t size = capture(bytes, one_two);
    for (size_t n = 24; n <= size; n++) {
        const bool is_whole = n == 24 || n == 24 + 61 || n == size;
        run->verdict.count = 0;
        look(run, "a.pcap", bytes, n, true);
        assert_int_equal(run->verdict.count, is_whole ? 0 : 1);
        look(run, "a.pcap", bytes, n, false);
        assert_int_equal(run->verdict.count, is_whole ? 0 : 1);
    }
    bytes[24 + 8]++;
    run->verdict.count = 0;
    look(run, "a.pcap", bytes, size, false);
    assert_int_equal(run->verdict.count, 1);
    look(run, "a.pcap", bytes, 20, false);
    assert_int_equal(run->verdict.count, 2);
}

static void compare(struct run *run, const char *const *payloads)
{
    uint8_t bytes[LONGEST];
    const judge_file file = {"a.pcap", bytes, capture(bytes, payloads), 5 * S,
                             true};
    run->verdict.count = 0;
    judge_recording(&run->record, 0, &file, &run->verdict);
}

static void record_three(struct run *run)
{
    (void)tool(run, "lumdump udp://10.42.0.37 -o a.pcap", 1 * S, 4 * S, 0);
    beat(run, 0, 1100 * MS);
    data(run, 0, 1200 * MS, "one");
    data(run, 0, 1300 * MS, "two");
    beat(run, 0, 1350 * MS);
    data(run, 0, 1400 * MS, "end");
}

static void a_recording_holds_what_came(void **state)
{
    static const char *const all[] = {"one", "two", "end", NULL};
    struct run *run = *state;
    record_three(run);
    compare(run, all);
    assert_int_equal(run->verdict.count, 0);
    compare(run, one_two); /* what came behind the last heartbeat may lack */
    assert_int_equal(run->verdict.count, 0);
}

static void a_recording_has_as_many_as_its_summary_says(void **state)
{
    static const char *const all[] = {"one", "two", "end", NULL};
    struct run *run = *state;
    record_three(run);
    run->record.tools[0].out =
        copy("{\"outputs\": [{\"name\": \"a.pcap\", \"end\": \"done\", "
             "\"datagrams\": 4, \"dropped\": 0}]}\n");
    compare(run, all);
    assert_true(verdict_has(&run->verdict, "counts-of-recording"));
}

static void what_lacks_in_a_recording_is_found(void **state)
{
    static const char *const first[] = {"one", NULL};
    static const char *const gap[] = {"one", "end", NULL};
    static const char *const other[] = {"one", "two", "end", "fin", NULL};
    static const char *const twice[] = {"one", "one", "two", NULL};
    struct run *run = *state;
    record_three(run);
    compare(run, first);
    assert_true(verdict_has(&run->verdict, "recording-whole"));
    compare(run, gap);
    assert_true(verdict_has(&run->verdict, "recording-whole"));
    compare(run, other);
    assert_true(verdict_has(&run->verdict, "recording"));
    compare(run, twice);
    assert_true(verdict_has(&run->verdict, "recording"));
}

static void losses_that_are_told_may_lack(void **state)
{
    static const char *const gap[] = {"one", "end", NULL};
    struct run *run = *state;
    record_three(run);
    run->record.tools[0].out = copy("{\"recording_drops\": 1}");
    compare(run, gap);
    assert_int_equal(run->verdict.count, 0);
}

static const struct CMUnitTest tests[] = {
    FACT(lines_of_a_log_are_read_as_they_grow),
    FACT(a_refusal_is_not_done),
    FACT(datagrams_are_told_apart),
    FACT(a_recording_with_the_laser_is_fine),
    FACT(a_laser_without_heartbeats_is_late),
    FACT(a_laser_that_ends_in_time_is_not_late),
    FACT(a_laser_that_never_ends_is_late),
    FACT(power_off_ends_the_laser),
    FACT(a_heartbeat_that_comes_too_late_does_not_excuse),
    FACT(heartbeats_end_with_a_signal),
    FACT(a_stop_does_not_count_as_going_on),
    FACT(nobody_may_switch_it_on_unasked),
    FACT(an_on_that_nobody_sent_is_found),
    FACT(an_on_after_an_off_is_found),
    FACT(no_heartbeat_brings_a_laser_back),
    FACT(a_reboot_forgets_a_laser_on),
    FACT(a_session_does_not_switch_on_again),
    FACT(a_session_gives_up_in_time),
    FACT(who_was_held_up_does_not_switch_on),
    FACT(who_is_stopped_hears_later_that_it_is_to_end),
    FACT(who_was_stopped_before_a_send_cannot_know),
    FACT(a_hazard_that_was_seen_keeps_the_laser_down),
    FACT(a_laser_that_comes_back_is_found),
    FACT(a_network_that_was_down_excuses_it),
    FACT(a_setting_that_the_sensor_did_is_done),
    FACT(a_setting_that_the_sensor_refused_is_not_done),
    FACT(each_word_of_send_is_looked_for),
    FACT(what_another_tool_did_does_not_count),
    FACT(a_sensor_that_looked_before_a_command_was_sent_did_it),
    FACT(a_laser_that_never_came_up_is_not_on),
    FACT(an_off_that_looked_twice_is_fine),
    FACT(an_off_that_looked_once_is_found),
    FACT(an_off_that_looked_at_once_is_found),
    FACT(an_off_whose_laser_is_on_is_found),
    FACT(a_wait_for_what_was_so_is_fine),
    FACT(a_wait_for_what_never_was_is_found),
    FACT(an_on_that_was_not_taken_back_is_found),
    FACT(a_sensor_that_did_not_move_is_found),
    FACT(a_sensor_that_moved_is_fine),
    FACT(a_status_between_request_and_answer_is_true),
    FACT(a_status_before_the_request_is_old),
    FACT(a_status_behind_the_answer_is_invented),
    FACT(a_status_that_nobody_had_is_found),
    FACT(done_and_the_exit_status_agree),
    FACT(a_request_ends_in_time),
    FACT(a_stopped_tool_has_its_time_later),
    FACT(a_tool_that_hangs_is_found),
    FACT(a_watch_ends_soon_after_a_signal),
    FACT(a_recording_without_data_ends),
    FACT(a_datagram_has_one_fate),
    FACT(a_datagram_that_vanished_is_found),
    FACT(counters_that_agree_are_fine),
    FACT(a_counter_that_misses_one_is_found),
    FACT(an_output_that_misses_one_is_found),
    FACT(heartbeats_of_lumctl_are_counted),
    FACT(a_status_that_no_page_has_is_found),
    FACT(a_crash_is_found),
    FACT(who_got_a_signal_may_end_by_it),
    FACT(bad_arguments_are_two_and_nothing_else_is),
    FACT(an_answer_that_was_read_is_no_silence),
    FACT(an_answer_after_all_tries_is_silence),
    FACT(an_answer_after_a_stop_may_be_late),
    FACT(data_that_was_read_is_no_silence),
    FACT(four_needs_a_hazard),
    FACT(a_hazard_needs_four),
    FACT(silence_in_calm_is_found),
    FACT(an_owner_on_another_host_is_a_reason),
    FACT(silence_has_its_reasons),
    FACT(a_failed_output_needs_a_status),
    FACT(a_send_is_looked_at),
    FACT(a_second_owner_is_told),
    FACT(two_owners_at_once_are_found),
    FACT(an_owner_that_is_not_there_is_found),
    FACT(a_repeat_keeps_its_number),
    FACT(a_repeat_of_what_was_held_up_comes_when_it_is_due),
    FACT(a_repeat_waits),
    FACT(tries_are_counted),
    FACT(heartbeats_have_no_gaps),
    FACT(heartbeats_that_never_come_again_are_a_gap),
    FACT(files_of_text_are_whole_or_not),
    FACT(files_of_points_are_whole_or_not),
    FACT(las_counts_its_points),
    FACT(what_is_left_is_found),
    FACT(what_was_given_up_may_be_left),
    FACT(an_output_that_is_not_there_is_found),
    FACT(nobody_switches_off_unasked),
    FACT(nobody_moves_a_sensor_unasked),
    FACT(a_flood_is_found),
    FACT(captures_are_whole_or_not),
    FACT(a_recording_holds_what_came),
    FACT(a_recording_has_as_many_as_its_summary_says),
    FACT(what_lacks_in_a_recording_is_found),
    FACT(losses_that_are_told_may_lack)};
#undef FACT

int main(void)
{
    return cmocka_run_group_tests_name("judges", tests, NULL, NULL);
}
