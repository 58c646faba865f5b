/* lumctl doctor without rights: what it finds, and what it says of it. */
#include "look.h"
#include "made_up.h"

#include <stdlib.h>
#include <string.h>

STORY(doctor_all_fine, "doctor finds nothing wrong with a good bench, and only "
                       "looks")
{
    static const char *const looks[] = {"start",     "frames", "heartbeat",
                                        "reply",     "status", "stream",
                                        "timestamp", "tlv"};
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *doctor = examine(&b);
    expect_fine(doctor);
    expect_text(doctor, "interface", "eth0 is up and has 10.42.0.1/24");
    expect_text(doctor, "route", SENSOR);
    expect_text(doctor, "arp", SENSOR " is at ");
    expect_text(doctor, "clock", "host's rate");
    expect_text(doctor, "status", "laser may be up: no bit set");
    size_t known = 0;
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        known += user_events(s, looks[i]);
    }
    size_t all = 0;
    for (const user_event *e = s->first; e != NULL; e = e->next) {
        all++;
    }
    user_expect_equal(known, all);
    for (size_t i = 0; i < user_events(s, "tlv"); i++) {
        user_expect_same(user_value(user_event_at(s, "tlv", i)->line, "note"),
                         "status poll");
    }
    user_expect(!user_laser_is_on(s));
    user_expect_at_most(user_last(s, "heartbeat")->t_ns -
                            user_event_at(s, "heartbeat", 0)->t_ns,
                        20 * WORLD_S);
}

STORY(doctor_for_people, "people get a line for each check, and a verdict")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *doctor = user_run(b.host, "lumctl doctor");
    user_expect_status(doctor, DONE);
    user_expect_same(user_err(doctor), "");
    const char *at = user_out(doctor);
    for (size_t i = 0; i < LOOK_NAMES; i++) {
        at = strstr(at, user_format("  %s ", look_names[i]));
        user_expect(at != NULL);
    }
    user_expect_like(user_out(doctor),
                     "\n10\\.42\\.0\\.37: nothing is wrong\n$");
    user_expect_lacks(user_out(doctor), "\033");
}

STORY(doctor_beside_a_session, "a session of this host keeps its data")
{
    static const char *const left[] = {"data", "layout", "loss", "strangers"};
    static const char *const fine[] = {"answer", "clock", "status"};
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    (void)hold(&b);
    const char *from = user_value(user_last(s, "heartbeat")->line, "from");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, DONE);
    expect_check(doctor, "session", "note");
    expect_text(doctor, "session", "lumctl (process");
    for (size_t i = 0; i < 4; i++) {
        expect_check(doctor, left[i], "not looked at");
        expect_text(doctor, left[i], "another session");
    }
    for (size_t i = 0; i < 3; i++) {
        expect_check(doctor, fine[i], "fine");
    }
    for (size_t i = 0; i < user_events(s, "heartbeat"); i++) {
        user_expect_same(
            user_value(user_event_at(s, "heartbeat", i)->line, "from"), from);
    }
}

STORY(doctor_beside_another_host,
      "a laser that another host drives is left alone")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_host *other = user_host_new("other");
    (void)user_interface(other, "eth0", b.wire, "10.42.0.2/24");
    (void)user_start(other, "lumctl heartbeat");
    user_until(user_events(s, "heartbeat") > 0);
    user_expect_status(user_run(other, "lumctl laser on"), DONE);
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, DONE);
    expect_check(doctor, "answer", "note");
    expect_check(doctor, "data", "not looked at");
    expect_text(doctor, "data", "another host");
    user_expect(user_laser_is_on(s));
    for (size_t i = 0; i < user_events(s, "heartbeat"); i++) {
        user_expect_has(user_event_at(s, "heartbeat", i)->line, "10.42.0.2:");
    }
}

/* A sensor that shows nothing after a heartbeat. */
static user_sensor *blank_sensor(const user_bench *b)
{
    return user_sensor_start(b->sensor, "--rate 4 --boot-status 0x0000");
}

STORY(doctor_twice, "a doctor that ran a moment ago hides no data from the "
                    "next, though the laser may be on")
{
    const user_bench b = tuned_bench();
    user_sensor *s = blank_sensor(&b);
    expect_fine(examine(&b));
    user_expect_has(user_out(user_run(b.host, "lumctl status")),
                    "laser may be up");
    user_tool *again = examine(&b);
    expect_fine(again);
    expect_text(again, "answer", "laser may have been up until 3 s after");
    user_expect_status(user_run(b.host, "lumctl heartbeat --duration 1"), DONE);
    expect_fine(examine(&b));
    user_expect(!user_laser_is_on(s));
}

STORY(doctor_beside_another_host_that_may_have_the_laser_on,
      "a laser that may be on, as another host's heartbeats go on, is left "
      "alone")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = blank_sensor(&b);
    world_host *other = user_host_new("other");
    (void)user_interface(other, "eth0", b.wire, "10.42.0.2/24");
    (void)user_start(other, "lumctl heartbeat");
    user_until(user_events(s, "heartbeat") > 0);
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, DONE);
    expect_check(doctor, "answer", "note");
    expect_text(doctor, "answer", "its laser may be up, still after 3 s");
    expect_check(doctor, "data", "not looked at");
    for (size_t i = 0; i < user_events(s, "heartbeat"); i++) {
        user_expect_has(user_event_at(s, "heartbeat", i)->line, "10.42.0.2:");
    }
}

STORY(doctor_and_a_hazard, "a hazard has its exit status, its name and its fix")
{
    const user_bench b = tuned_bench();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--rate 4 --fault fan@0");
    user_until(user_events(s, "status") > 0);
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, HAZARD);
    expect_value(doctor, "overall", "hazard");
    expect_check(doctor, "status", "wrong");
    expect_text(doctor, "status", "FAN_PWM_BAD");
    user_expect_has(look_of(doctor, "status", "fix"), "fan");
}

STORY(doctor_and_another_layout,
      "another layout is told from a sensor without data, and its fix fixes it")
{
    const user_bench b = tuned_bench();
    user_leave("status-in-calm", "no packet fits the layout of a recording");
    user_write_file(b.sensor, "other.yaml",
                    "version: 1\ndata_packet_type: 9\n");
    (void)user_sensor_start(b.sensor, "--rate 4 --profile other.yaml");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "data", "fine");
    expect_check(doctor, "layout", "wrong");
    expect_text(doctor, "layout", "type 9");
    expect_check(doctor, "loss", "not looked at");
    user_expect_has(look_of(doctor, "layout", "fix"),
                    "lumdump udp://" SENSOR
                    " --laser --duration 3 -o look.pcap; "
                    "lumdump look.pcap --infer -o profile.yaml");
    /* A recording of another layout is kept, and named as such. */
    user_expect_status(user_run(b.host, "lumdump udp://" SENSOR
                                        " --laser --duration 3 -o look.pcap"),
                       FAILED);
    user_expect_status(
        user_run(b.host, "lumdump look.pcap --infer -o profile.yaml"), DONE);
    expect_fine(
        user_run(b.host, "lumctl --profile profile.yaml doctor --json"));
}

STORY(doctor_and_a_layout_that_decodes,
      "what another layout makes of data that decodes, in part or wholly, is "
      "not blamed on the cable")
{
    const bool in_part = user_any(0, 1) == 0;
    const user_bench b = tuned_bench();
    (void)user_sensor_start(
        b.sensor, "--rate 4 %s",
        in_part ? "--set group.line=16 --set group.num_samples=14"
                : "--set group.line=18 --set group.first_sample_index=14");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "layout", in_part ? "wrong" : "fine");
    expect_check(doctor, "loss", in_part ? "not looked at" : "wrong");
    expect_text(doctor, "loss", "wire profile");
    user_expect_lacks(look_of(doctor, "loss", "text"), "cable");
    user_expect_has(look_of(doctor, in_part ? "layout" : "loss", "fix"),
                    "--infer");
    expect_check(doctor, "clock", "fine");
}

STORY(doctor_and_a_clock_elsewhere,
      "a clock at another place of the packet shows")
{
    const user_bench b = tuned_bench();
    user_write_file(b.sensor, "other.yaml",
                    "version: 1\ngroup: {timestamp: 24, samples: 28, line: 20, "
                    "num_samples: 16, first_sample_index: 18}\n");
    user_write_file(b.host, "mine.yaml",
                    "version: 1\ngroup: {timestamp: 20, samples: 28, line: "
                    "14}\n");
    (void)user_sensor_start(b.sensor, "--rate 4 --profile other.yaml");
    user_tool *doctor =
        user_run(b.host, "lumctl --profile mine.yaml doctor --json");
    user_expect_status(doctor, FAILED);
    user_expect(strcmp(look_of(doctor, "clock", "result"), "wrong") == 0 ||
                strcmp(look_of(doctor, "layout", "result"), "wrong") == 0);
}

STORY(doctor_and_loss, "loss on the wire is the cable's, or the simulator's")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_fault_in(b.eth0, (user_faults){.lose = 0.05});
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "loss", "wrong");
    expect_text(doctor, "loss", "lost on the wire");
    expect_text(doctor, "loss", "the kernel dropped none");
    expect_text(doctor, "loss", "cable");
    user_expect_has(look_of(doctor, "loss", "fix"), "ethtool -S eth0");
}

STORY(doctor_and_a_simulators_loss,
      "loss of a simulator on this host is the simulator's")
{
    const user_bench b = tuned_bench();
    (void)user_start(b.host, "lumsim --address 127.0.0.2 --rate 4 --frames 1 "
                             "--loss 0.05");
    user_pause_ms(100);
    user_tool *doctor =
        user_run(b.host, "lumctl --host 127.0.0.2 doctor --json");
    user_expect_status(doctor, FAILED);
    expect_text(doctor, "port", "lumsim");
    expect_check(doctor, "loss", "wrong");
    expect_text(doctor, "loss", "lost by the simulator");
    expect_text(doctor, "loss", "the kernel dropped none");
    user_expect_lacks(look_of(doctor, "loss", "text"), "cable");
    user_expect_like(look_of(doctor, "loss", "fix"),
                     "^lumsim --address 127\\.0\\.0\\.2 &.*--loss");
}

STORY(doctor_and_corruption, "corruption is no other layout")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4 --corrupt 0.1");
    user_tool *doctor = examine(&b);
    expect_check(doctor, "layout", "note");
    expect_text(doctor, "layout", "corrupted");
}

STORY(doctor_and_silence, "a silent sensor is told in time")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4 --fault silence@0");
    const int64_t begin = world_now();
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, NO_ANSWER);
    expect_check(doctor, "answer", "wrong");
    user_expect_has(look_of(doctor, "answer", "fix"), "tcpdump");
    expect_check(doctor, "firewall", "not looked at");
    user_expect_at_most(world_now() - begin, 30 * WORLD_S);
}

STORY(doctor_and_late_answers,
      "answers that come late are told from none, with the --timeout that "
      "takes them")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4 --answer-delay 1500");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, DONE);
    expect_check(doctor, "answer", "note");
    expect_text(doctor, "answer", "but late");
    doctor = user_run(b.host, "lumctl --timeout 200 doctor --json");
    user_expect_status(doctor, FAILED);
    user_expect_like(look_of(doctor, "answer", "text"),
                     "answers late, 1[5-7][0-9]{2} ms after the first of 5 "
                     "requests, each of which is given up after 200 ms");
    user_expect_like(look_of(doctor, "answer", "fix"),
                     "^lumctl --host 10\\.42\\.0\\.37 --timeout 3[0-9]00 "
                     "doctor ");
    doctor = user_run(b.host, "lumctl --timeout 3200 --retries 0 doctor "
                              "--json");
    user_expect_status(doctor, DONE);
    expect_text(doctor, "answer", "but late");
}

static void answer_others(made_up *self, const made_up_packet *packet)
{
    made_up_packet other = *packet;
    other.sequence += 7u;
    made_up_plain(self, &other);
}

STORY(doctor_and_another_sequence,
      "answers with another sequence number are told from none")
{
    const user_bench b = tuned_bench();
    const made_up *m = made_up_new(b.sensor, SENSOR, answer_others);
    user_tool *doctor = user_run(b.host, "lumctl --retries 2 doctor --json");
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "answer", "wrong");
    expect_text(doctor, "answer", "answers with another sequence number");
    expect_text(doctor, "data", "answers have another sequence number");
    user_expect(made_up_heard(m, MADE_UP_TIME) >= 3);
}

STORY(doctor_without_data, "a sensor without data is told")
{
    const user_bench b = tuned_bench();
    const made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "answer", "fine");
    expect_check(doctor, "data", "wrong");
    expect_text(doctor, "data", "no data came");
    expect_check(doctor, "layout", "not looked at");
    expect_check(doctor, "status", "fine");
    for (size_t i = 0; i < m->count; i++) {
        user_expect(m->packets[i].kind >= 6 && m->packets[i].kind <= 8);
    }
}

/* --- Clocks --- */

static const char faster[] = "(4[5-9]|5[0-5])[0-9][0-9][0-9] ppm faster";

STORY(doctor_and_a_fast_clock, "a clock that runs at another rate is told")
{
    const user_bench b = tuned_bench();
    world_host_set_drift(b.sensor, 50000000); /* 5 % */
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "clock", "wrong");
    user_expect_like(look_of(doctor, "clock", "text"), faster);
}

/* Two of four answers are under way for long, or all of them; its clock runs 5
 * % fast in the first case. */
static void answer_slowly(made_up *self, const made_up_packet *packet)
{
    const bool is_time = packet->kind == MADE_UP_TIME;
    const bool some = self->state == 2;
    self->delay_ns = is_time && (!some || packet->before % 4 >= 2)
                         ? (some ? 120 : 50) * WORLD_MS
                         : 0;
    if (is_time) {
        const int64_t us = world_now() / 1000;
        made_up_send_time(self, packet, (uint32_t)(some ? us * 105 / 100 : us));
    } else {
        made_up_plain(self, packet);
    }
}

STORY(doctor_and_some_slow_answers,
      "a rate is told by the answers that came at once")
{
    const user_bench b = tuned_bench();
    made_up *m = made_up_new(b.sensor, SENSOR, answer_slowly);
    m->state = 2;
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "clock", "wrong");
    user_expect_like(look_of(doctor, "clock", "text"), faster);
}

STORY(doctor_and_slow_answers_alone,
      "a rate by slow answers alone is told as such")
{
    const user_bench b = tuned_bench();
    made_up *m = made_up_new(b.sensor, SENSOR, answer_slowly);
    m->state = 4;
    user_tool *doctor = examine(&b);
    expect_check(doctor, "clock", "fine");
    expect_text(doctor, "clock", "as far as such slow answers show");
}

STORY(doctor_held_up, "a doctor that was held up finds no wrong clock in the "
                      "data")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *doctor = user_start(b.host, "lumctl doctor --json");
    user_until(user_events(s, "heartbeat") > 0);
    user_pause_between_ms(300, 700);
    user_signal(doctor, SIGSTOP);
    user_pause_ms(2200);
    user_signal(doctor, SIGCONT);
    (void)user_wait(doctor);
    expect_check(doctor, "data", "fine");
    expect_check(doctor, "clock", "fine");
}

/* --- Data by hand --- */

/* The three angle packets of a line that looks straight ahead. */
static void send_angles(made_up *self, const user_mail *to, unsigned eye,
                        unsigned line, uint32_t clock, unsigned part)
{
    static const unsigned firsts[] = {0, 334, 668};
    const unsigned count = part < 2 ? 334 : 332;
    uint8_t bytes[24 + 4 * 334] = {0xed, 0xfe, 0xf3, 0xa1,        0xef,
                                   0xbe, 0x34, 0x12, 8,           0,
                                   0,    0,    2,    (uint8_t)eye};
    const uint32_t fields[] = {line, count, firsts[part], clock & 0xffffu,
                               clock >> 16};
    for (size_t i = 0; i < 5; i++) {
        bytes[14 + 2 * i] = (uint8_t)fields[i];
        bytes[15 + 2 * i] = (uint8_t)(fields[i] >> 8);
    }
    user_send(self->peer, to->from, to->port, bytes, 24 + 4 * (size_t)count);
}

/* What a sensor sends when its first heartbeat comes. */
typedef struct stream {
    unsigned line;      /* the next */
    unsigned jump_at;   /* from this line on, the clock is 10 s later */
    unsigned missing;   /* of this line, the second packet of the second eye */
    unsigned cut_below; /* of lines below it, only the last packets */
    made_up *sensor;
    user_mail to;
} stream;

static void send_line(void *argument)
{
    stream *s = argument;
    const uint32_t clock =
        1000000u + 500u * s->line + (s->line >= s->jump_at ? 10000000u : 0u);
    for (unsigned part = s->line < s->cut_below ? 2 : 0; part < 3; part++) {
        for (unsigned eye = 0; eye < 2; eye++) {
            if (s->line != s->missing || eye != 1 || part != 1) {
                send_angles(s->sensor, &s->to, eye, s->line, clock, part);
            }
        }
    }
    if (++s->line < 80) {
        (void)world_at(world_now() + 10 * WORLD_MS, send_line, s);
    }
}

static void answer_heartbeats(user_peer *peer, const user_mail *mail,
                              void *argument)
{
    stream *s = argument;
    (void)peer;
    if (mail->size == 12 && mail->bytes[8] == 8 && s->to.port == 0) {
        s->to = *mail;
        send_line(s);
    }
}

/* A doctor's look at such a stream. */
static user_tool *examine_stream(stream *s)
{
    const user_bench b = tuned_bench();
    s->sensor = made_up_new(b.sensor, SENSOR, NULL);
    made_up_hears(s->sensor, answer_heartbeats, s);
    return examine(&b);
}

STORY(doctor_and_a_beginning, "what was under way at the beginning is no loss")
{
    static stream s;
    s = (stream){.line = 5, .cut_below = 7, .jump_at = 1000, .missing = 1000};
    user_tool *doctor = examine_stream(&s);
    expect_check(doctor, "loss", "fine");
    user_expect(strtol(look_of(doctor, "loss", "text"), NULL, 10) > 80);
}

STORY(doctor_and_a_jump, "what a jump of the clock costs is no loss")
{
    static stream s;
    s = (stream){.jump_at = 40, .missing = 1000};
    user_tool *doctor = examine_stream(&s);
    expect_check(doctor, "loss", "fine");
    user_expect(strtol(look_of(doctor, "loss", "text"), NULL, 10) > 100);
}

STORY(doctor_and_a_gap, "one packet that is missing in between is a loss")
{
    static stream s;
    s = (stream){.jump_at = 1000, .missing = 30};
    user_tool *doctor = examine_stream(&s);
    expect_check(doctor, "loss", "wrong");
    expect_text(doctor, "loss", "1 without all angles, 0 more whole");
}

/* --- Others, ends, shells --- */

STORY(doctor_and_strangers, "datagrams of others are noted")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_peer *stranger =
        user_peer_new(b.sensor, "10.42.0.200", 7000, NULL, NULL);
    user_tool *doctor = user_start(b.host, "lumctl doctor --json");
    user_until(user_events(s, "heartbeat") > 0);
    const char *from = user_value(user_last(s, "heartbeat")->line, "from");
    const uint16_t port = (uint16_t)strtoul(strchr(from, ':') + 1, NULL, 10);
    for (unsigned i = 0; i < 20; i++) {
        user_send(stranger, user_ip("10.42.0.1"), port, "hello", 5);
    }
    user_expect_status(doctor, DONE);
    expect_check(doctor, "strangers", "note");
    expect_text(doctor, "strangers", "20 datagrams");
}

STORY(doctor_and_another_port,
      "answers from another port are told from silence")
{
    const user_bench b = tuned_bench();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->answers_by = user_peer_new(b.sensor, SENSOR, 6000, NULL, NULL);
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED);
    expect_check(doctor, "answer", "wrong");
    expect_text(doctor, "answer",
                "answers from port 6000 to what is sent to its port 5517");
    user_expect_has(look_of(doctor, "answer", "fix"), "tcpdump");
}

STORY(doctor_and_a_signal, "a signal ends a doctor, and the session is free")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *doctor = user_start(b.host, "lumctl doctor");
    user_until(user_events(s, "heartbeat") > 0);
    user_pause_between_ms(0, 1500);
    user_expect_end(doctor, SIGINT, -SIGINT);
    user_expect_lacks(user_out(doctor), " is wrong");
    expect_check(examine(&b), "session", "fine");
}

STORY(doctor_and_a_reader_that_leaves, "a reader that leaves ends a doctor "
                                       "quietly")
{
    const user_bench b = tuned_bench();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_file *end = NULL;
    world_reader *reader = world_reader_new("reader", &end);
    user_tool *doctor =
        user_start_with(b.host, (user_with){.output = end}, "lumctl doctor");
    user_until(user_has(user_taken(reader), "\n"));
    world_reader_close(reader);
    user_expect_status(doctor, DONE);
    user_expect_same(user_err(doctor), "");
}

STORY(doctor_in_a_shell, "a shell that owns the sensor keeps it meanwhile")
{
    const user_bench b = tuned_bench();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *shell = run_fed(b.host, "lumctl shell --heartbeat",
                               "laser on\ndoctor\ndoctor\nlaser off\nquit\n");
    user_expect_equal(
        user_count(user_out(shell), "another session of this host"), 8);
    user_expect_equal(user_laser_rises(s), 1);
    const size_t count = user_events(s, "heartbeat");
    for (size_t i = 1; i < count; i++) {
        user_expect_at_most(user_event_at(s, "heartbeat", i)->t_ns -
                                user_event_at(s, "heartbeat", i - 1)->t_ns,
                            3 * WORLD_S - 1);
    }
}

STORY(doctor_without_rights,
      "without rights a doctor says what it could not look at")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *doctor = examine(&b);
    user_expect_status(doctor, FAILED); /* by a small buffer */
    expect_text(doctor, "arp",
                "only root can see whether another device answers");
    for (size_t i = 0; i < LOOK_NAMES; i++) {
        expect_check(doctor, look_names[i],
                     strcmp(look_names[i], "buffer") == 0 ? "wrong" : "fine");
    }
    user_expect_has(look_of(doctor, "buffer", "fix"),
                    "sudo sysctl -w net.core.rmem_max=33554432");
}
