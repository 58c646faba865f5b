/* The laser goes off when nobody listens any more. */
#include "bench.h"

#include <string.h>

#define HEARTBEATS_END_NS (2500 * WORLD_MS)
#define LASER_ENDS_NS     (3200 * WORLD_MS)

typedef struct scene {
    user_bench b;
    user_sensor *s;
    user_tool *dump;
} scene;

/* A sensor, and a recording with the laser on. */
static scene begin(const char *sensor, const char *outputs)
{
    scene now;
    now.b = user_bench_new();
    now.s = user_sensor_start(now.b.sensor, "--rate 2 %s", sensor);
    now.dump = user_start(now.b.host, RECORD " %s", outputs);
    return now;
}

static scene begin_on(void)
{
    const scene now = begin("", "-o a.pcap");
    user_until(user_laser_is_on(now.s));
    user_pause_between_ms(0, 1500);
    return now;
}

static void expect_dark_within(const user_sensor *s, int64_t since_ns)
{
    user_until(!user_laser_is_on(s));
    user_expect_at_most(user_last(s, "laser")->t_ns, since_ns + LASER_ENDS_NS);
}

STORY(heartbeats_in_time, "heartbeats come several times a second")
{
    const scene now = begin("", "-o a.pcap");
    user_until(user_events(now.s, "heartbeat") >= 30);
    for (size_t i = 1; i < 30; i++) {
        const int64_t apart_ns = user_event_at(now.s, "heartbeat", i)->t_ns -
                                 user_event_at(now.s, "heartbeat", i - 1)->t_ns;
        user_expect_at_most(apart_ns, WORLD_S);
    }
    user_expect_end(now.dump, SIGINT, 0);
    user_expect(!user_laser_is_on(now.s));
}

STORY(a_stopped_program, "a stopped program stops its heartbeats, and the "
                         "laser goes off")
{
    const scene now = begin_on();
    const int64_t stopped_ns = world_now();
    user_signal(now.dump, SIGSTOP);
    user_until(!user_laser_is_on(now.s));
    const int64_t last_ns = user_last(now.s, "heartbeat")->t_ns;
    user_expect_at_most(last_ns, stopped_ns + HEARTBEATS_END_NS);
    expect_dark_within(now.s, last_ns);
}

STORY(a_program_that_was_stopped_while_it_switched_on,
      "a program that was stopped while it switched the laser on switches it "
      "off when it goes on")
{
    const scene now = begin("--answer-loss 1", "-o a.pcap");
    user_until(user_heard(now.s, "u") > 0);
    user_pause_between_ms(0, 300);
    user_signal(now.dump, SIGSTOP);
    user_pause_between_ms(2300, 3500);
    const size_t asked = user_heard(now.s, "u");
    user_signal(now.dump, SIGCONT);
    user_until(user_heard(now.s, "d") > 0);
    user_expect_equal(user_heard(now.s, "u"), asked);
    user_expect_has(user_err(now.dump), "this program was held up for");
    user_expect_end(now.dump, SIGINT, 1);
}

STORY(a_killed_program, "a killed program leaves the laser off")
{
    const scene now = begin_on();
    user_signal(now.dump, SIGKILL);
    expect_dark_within(now.s, world_now());
}

STORY(a_killed_heartbeat, "a killed lumctl heartbeat leaves the laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat");
    user_until(user_events(s, "heartbeat") > 0);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    user_pause_between_ms(0, 1500);
    user_signal(beat, SIGKILL);
    expect_dark_within(s, world_now());
}

STORY(after_a_pause, "after a pause the laser stays off, and that is told")
{
    const scene now = begin_on();
    until_data(&now.b, "a.pcap", 1000);
    user_until_beats(now.s, 2);
    user_signal(now.dump, SIGSTOP);
    user_until(!user_laser_is_on(now.s));
    const size_t beats = user_events(now.s, "heartbeat");
    user_pause_between_ms(0, 20000);
    user_expect_at_most(user_events(now.s, "heartbeat"), beats);
    user_signal(now.dump, SIGCONT);
    user_until_beats(now.s, 12);
    user_expect_equal(user_heard(now.s, "u"), 1);
    user_expect(!user_laser_is_on(now.s));
    user_expect_end(now.dump, SIGINT, 0);
    user_expect_has(user_err(now.dump), "not switched on again");
    user_expect_has(user_err(now.dump), "laser on");
}

/* --- hazards --- */

static void cue(user_sensor *s, int number)
{
    const size_t enough = user_events(s, "fault") + 1;
    user_signal(s->tool, number);
    user_until(user_events(s, "fault") >= enough);
}

/* A sensor with a hazard, and a recording that wants the laser. */
static scene begin_with_hazard(const char *hazard, bool has_begun)
{
    scene now;
    now.b = user_bench_new();
    now.s = user_sensor_start(now.b.sensor, "--rate 2 --fault %s@USR1-USR2",
                              hazard);
    if (has_begun) {
        cue(now.s, SIGUSR1);
    }
    now.dump = user_start(now.b.host, RECORD " -o a.pcap");
    return now;
}

static void end_hazard_and_recording(const scene *now)
{
    cue(now->s, SIGUSR2);
    user_until_beats(now->s, 10);
    until_data(&now->b, "a.pcap", 1000);
    user_expect_end(now->dump, SIGINT, 0);
}

static void tell_hazard_that_ends(const char *hazard)
{
    const scene now = begin_with_hazard(hazard, false);
    user_until(user_laser_is_on(now.s));
    user_pause_between_ms(0, 1500);
    cue(now.s, SIGUSR1);
    user_until(user_heard(now.s, "d") > 0);
    end_hazard_and_recording(&now);
    user_expect_equal(user_heard(now.s, "u"), 1);
    user_expect_equal(user_laser_rises(now.s), 1);
    user_expect_equal(user_events(now.s, "laser"), 2);
}

STORY(a_fan_that_recovers, "the end of a hazard does not bring the laser back")
{
    tell_hazard_that_ends("fan");
}

STORY(an_interlock_that_closes,
      "nor does the end of an interlock's, which is no bit of the hardware")
{
    tell_hazard_that_ends("interlock");
}

STORY(a_laser_that_a_hazard_refused,
      "a laser that a hazard refused does not come up at its end")
{
    const scene now = begin_with_hazard("interlock", true);
    user_until(user_heard(now.s, "d") > 0);
    end_hazard_and_recording(&now);
    user_expect_equal(user_events(now.s, "laser"), 0);
}

STORY(on_again_after_a_hazard,
      "after a hazard a person can switch the laser on again")
{
    const scene now = begin_with_hazard("fan", true);
    user_until(user_heard(now.s, "d") > 0);
    cue(now.s, SIGUSR2);
    user_expect_status(user_run(now.b.host, "lumctl laser on"), 0);
    user_until_beats(now.s, 10);
    until_data(&now.b, "a.pcap", 1000);
    user_expect_equal(user_events(now.s, "laser"), 1);
    user_expect(user_laser_is_on(now.s));
    user_expect_end(now.dump, SIGINT, 0);
    user_expect_has(user_err(now.dump),
                    "another program switched the laser of 10.42.0.37 on");
    user_expect(!user_laser_is_on(now.s));
}

STORY(what_a_hazard_refused_to_another,
      "what a hazard refused to another program does not stand at its end")
{
    static const uint8_t up[] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34,
                                 0x12, 7,    0,    0,    0,    1,    0,
                                 0,    0,    1,    0,    1,    0,    'u'};
    const scene now = begin_with_hazard("fan", true);
    user_until(user_heard(now.s, "d") > 0);
    user_peer *other = user_peer_new(now.b.host, "10.42.0.1", 0, NULL, NULL);
    user_send(other, user_ip("10.42.0.37"), 5517, up, sizeof up);
    user_until(user_heard(now.s, "u") == 2 && user_heard(now.s, "d") == 2);
    end_hazard_and_recording(&now);
    user_expect_equal(user_events(now.s, "laser"), 0);
}

/* --- outputs that stall --- */

STORY(a_reader_that_stalls, "a reader that stalls costs data and not the "
                            "laser, and one that wakes up gets the end")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_with with = {0};
    world_reader *reader = world_reader_new("reader", &with.output);
    world_reader_pace(reader, 0);
    user_tool *dump =
        user_start_with(b.host, with, RECORD " --buffer 1MB -o - --format csv");
    user_until(user_laser_is_on(s));
    user_until_beats(s, 40);
    user_expect(user_laser_is_on(s));
    world_reader_pace(reader, WORLD_READER_FAST);
    user_expect_end(dump, SIGINT, 0);
    user_expect_has(user_err(dump), "standard output is too slow for the data");
    user_expect_like(user_err(dump), "outputs +done  standard output, [0-9]+ "
                                     "datagrams dropped");
    user_expect_lacks(user_err(dump), "recording_drops");
    expect_laser_on_and_off(s);
}

STORY(a_disk_that_stalls, "a disk that stalls does not turn the laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -o a.pcap");
    user_until(user_laser_is_on(s));
    world_disk_stall(world_disk_of(b.host), WORLD_DISK_ALL, WORLD_NEVER);
    user_until_beats(s, 40);
    user_expect(user_laser_is_on(s));
    user_signal(dump, SIGINT);
    user_until(!user_laser_is_on(s));
    user_expect_equal(user_heard(s, "d"), 1);
    world_disk_heal(world_disk_of(b.host));
    user_expect_status(dump, 0);
}

STORY(a_fifo_that_nobody_reads,
      "a fifo in a disk's place that nobody reads does not turn the laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    (void)user_fifo(b.host, "disk.pcap");
    user_tool *dump = user_start(b.host, RECORD " -o disk.pcap");
    user_until(user_laser_is_on(s));
    user_until_beats(s, 40);
    user_expect(user_laser_is_on(s));
    (void)user_end(dump, SIGINT);
    user_expect(!user_laser_is_on(s));
}

/* --- ends --- */

/* By a command, and not by the sensor's own timeout. */
static void expect_off_by_command(const user_sensor *s)
{
    user_expect(!user_laser_is_on(s));
    const int64_t off_ns = user_last(s, "laser")->t_ns;
    const user_event *status = NULL;
    for (const user_event *e = s->first; e != NULL; e = e->next) {
        if (strcmp(e->kind, "status") == 0 && e->t_ns <= off_ns + 10000) {
            status = e;
        }
    }
    user_expect(status != NULL);
    user_expect_lacks(status->line, "HEARTBEAT_TIMEOUT");
    user_expect_at_least(user_heard(s, "d"), 1);
}

static void tell_end(const char *arguments, int number)
{
    const scene now = begin("", arguments);
    user_until(user_laser_is_on(now.s));
    if (number != 0) {
        user_pause_between_ms(0, 1000);
        user_signal(now.dump, number);
    }
    user_expect_status(now.dump, 0);
    expect_off_by_command(now.s);
}

STORY(the_end_of_a_duration, "the end of --duration switches the laser off")
{
    tell_end("--duration 2 -o b.ply", 0);
}

STORY(a_termination, "SIGTERM switches the laser off")
{
    tell_end("-o c.csv", SIGTERM);
}

STORY(a_hang_up, "SIGHUP switches the laser off")
{
    tell_end("-o d.csv", SIGHUP);
}

STORY(a_signal_at_any_call,
      "a signal at any moment of a run ends it without the laser on")
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
    const scene now = begin("", "-o a.pcap");
    const unsigned call = (unsigned)user_any(1, 3000);
    user_signal_at(now.dump, NULL, call, numbers[user_any(0, 3)]);
    (void)user_wait(now.dump);
    user_until_beats(now.s, 0);
    user_pause_ms(200);
    user_expect(!user_laser_is_on(now.s));
}

/* --- signals that were ignored when it began --- */

STORY(deaf_heartbeats, "lumctl heartbeat ends by a SIGINT or SIGQUIT that it "
                       "was born deaf to, and the laser with it")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat = user_start_with(b.host, (user_with){.ignores_int = true},
                                      "lumctl heartbeat");
    user_until(user_events(s, "heartbeat") > 0);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    user_until(user_laser_is_on(s));
    user_expect_end(beat, user_any(0, 1) == 0 ? SIGINT : SIGQUIT, 0);
    user_until(!user_laser_is_on(s));
}

STORY(a_deaf_recording, "so does a recording whose laser another program "
                        "switched on")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start_with(b.host, (user_with){.ignores_int = true},
                                      LIVE " -q -o a.pcap");
    user_until(user_events(s, "heartbeat") > 0);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    until_data(&b, "a.pcap", 1000);
    user_expect_end(dump, SIGINT, 0);
    user_until(!user_laser_is_on(s));
}

STORY(a_shell_that_ends, "a shell that a signal ends which it was born deaf "
                         "to leaves the laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_with with = {.ignores_int = true, .ignores = SIGTERM};
    world_writer *keys = world_writer_new(&with.input);
    user_tool *shell =
        user_start_with(b.host, with, "lumctl --heartbeat shell");
    user_type(shell, keys, "laser on\n");
    user_until(user_laser_is_on(s));
    user_until_beats(s, 7);
    user_expect_end(shell, user_any(0, 1) == 0 ? SIGTERM : SIGQUIT, 0);
    expect_off_by_command(s);
}
