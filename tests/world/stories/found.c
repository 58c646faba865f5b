/* What the dice found: each was a session that broke a rule of the judges. */
#include "bench.h"
#include "made_up.h"

#include <string.h>

enum {
    DONE = 0,
    FAILED = 1,
    NO_ANSWER = 3
};

/* --- laser off --- */

/* What a made-up sensor does while somebody else sends `u`. */
typedef struct rival {
    unsigned times; /* so many `u` come, each behind a `d` */
    int then;       /* the status after them */
} rival;

static void obey_a_rival(made_up *self, const made_up_packet *packet)
{
    const rival *r = self->facts;
    if (packet->text[0] == 'd') {
        self->status = MADE_UP_FAN | MADE_UP_OFF;
    } else if (made_up_sequences(self, MADE_UP_TLV) <= 2u * r->times) {
        self->status = MADE_UP_FAN | MADE_UP_ON;
    } else {
        self->status = MADE_UP_FAN | r->then;
    }
    made_up_plain(self, packet);
}

STORY(laser_off_against_a_rival,
      "laser off is not done while another's laser on waits behind a hazard, "
      "however few retries it has")
{
    const rival twice = {2, MADE_UP_OFF};
    const rival always = {10000, MADE_UP_ON};
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", obey_a_rival);
    m->facts = &twice;
    user_tool *off = user_run(b.host, "lumctl laser off --retries 0");
    user_expect_status(off, DONE);
    user_expect_same(made_up_commands(m), "d,d,d,");
    user_expect_equal(m->status, MADE_UP_FAN | MADE_UP_OFF);
    m->facts = &always;
    user_tool *vain = user_run(b.host, "lumctl laser off --retries 0");
    user_expect_status(vain, FAILED);
    user_expect_has(user_err(vain), "laser on is still in effect");
    user_expect_has(user_err(vain), "IS STILL IN EFFECT");
    user_expect_lacks(user_out(vain), "laser off");
}

/* --- a laser on that was held up --- */

static void keep_silent_for(made_up *self, const made_up_packet *packet)
{
    const char *mute = self->facts;
    if (strcmp(packet->text, mute) != 0) {
        made_up_plain(self, packet);
    }
}

/* Its timeout does not matter: what counts is how long it was stopped. */
static void tell_held_up(const char *timeout, int64_t after_ms, int64_t for_ms)
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", keep_silent_for);
    m->facts = "u";
    user_tool *on = user_start(b.host, "lumctl laser on --timeout %s", timeout);
    user_until(made_up_tries(m, "u") > 0);
    user_pause_between_ms(1, after_ms);
    user_signal(on, SIGSTOP);
    const size_t tries = made_up_tries(m, "u");
    user_pause_between_ms(2000, for_ms);
    user_signal(on, SIGCONT);
    user_expect_status(on, NO_ANSWER);
    user_expect_equal(made_up_tries(m, "u"), tries);
    user_expect_has(user_err(on), "cancelled");
}

STORY(a_laser_on_that_was_stopped,
      "a laser on that was stopped for two seconds is not sent again")
{
    tell_held_up("400", 390, 2200);
}

STORY(a_patient_laser_on_that_was_stopped,
      "nor one that waits longer for its answer than it was stopped")
{
    tell_held_up("12000", 2500, 9000);
}

/* Its sends: a heartbeat, `u`, two heartbeats, `u`, two heartbeats, `u`. The
 * one that was under way goes out late, and nobody can help it. */
STORY(a_laser_on_that_was_stopped_and_told_to_end,
      "a program that was stopped right before it sent laser on, and told to "
      "end meanwhile, does not send it once more")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", keep_silent_for);
    m->facts = "u";
    user_tool *dump = user_start(b.host, RECORD);
    user_signal_at(dump, "sendmmsg", user_any(0, 1) == 0 ? 5 : 8, SIGSTOP);
    user_pause_ms(2000);
    const size_t tries = made_up_tries(m, "u");
    user_signal(dump, SIGINT);
    user_signal(dump, SIGCONT);
    user_expect_status(dump, NO_ANSWER);
    user_expect_equal(made_up_tries(m, "u"), tries + 1);
}

/* --- A shell that is told to end --- */

static user_tool *shell_at_laser_off(const user_bench *b, made_up *m)
{
    user_with with = {0};
    world_writer *keys = world_writer_new(&with.input);
    user_tool *shell =
        user_start_with(b->host, with, "lumctl shell --heartbeat");
    user_pause_ms(700);
    user_type(shell, keys, "laser off\n");
    user_until(made_up_tries(m, "d") > 0);
    return shell;
}

STORY(a_shell_told_to_end_and_ctrl_c,
      "a Ctrl-C during a typed laser off does not hide that the shell was told "
      "to end")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", NULL);
    user_tool *shell = shell_at_laser_off(&b, m);
    user_signal(shell, SIGTERM);
    user_pause_between_ms(0, 200);
    user_signal(shell, SIGINT);
    user_expect_status(shell, DONE);
}

STORY(a_shell_told_to_end_during_laser_off,
      "a shell that is told to end during a typed laser off without an answer "
      "sends no heartbeat any more")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", keep_silent_for);
    m->facts = "d";
    user_tool *shell = shell_at_laser_off(&b, m);
    const size_t beats = made_up_heard(m, MADE_UP_HEARTBEAT);
    user_signal(shell, SIGTERM);
    (void)user_wait(shell);
    user_expect_equal(made_up_heard(m, MADE_UP_HEARTBEAT), beats);
}

/* --- Who owns a sensor --- */

STORY(a_look_for_an_owner,
      "a program that looks for the owner of a sensor, and is stopped just "
      "then, keeps nobody from owning it")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *status = user_start(b.host, "lumctl status");
    user_signal_at(status, "close", (unsigned)user_any(1, 4), SIGSTOP);
    user_pause_ms(1000);
    user_expect(!user_ended(status));
    user_expect_status(user_run(b.host, "lumctl heartbeat --duration 1"), DONE);
    user_signal(status, SIGCONT);
    user_expect_status(status, DONE);
}

/* --- The begin of a recording --- */

static void stall_for_a_while(void *argument)
{
    const user_bench *b = argument;
    world_disk_stall(world_disk_of(b->host), WORLD_DISK_ALL,
                     world_now() + 4 * WORLD_S);
}

STORY(a_recording_told_to_end_before_it_began,
      "a recording that is told to end while the disk stalls at the opening of "
      "its outputs, or at their first write, does not begin, and ends by the "
      "signal")
{
    user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -o a.csv -o b.pcap");
    const unsigned n = (unsigned)user_any(0, 4);
    user_at_call(dump, n == 0 ? "write" : "open", n == 0 ? 1 : n,
                 stall_for_a_while, &b);
    user_pause_between_ms(100, 2500);
    user_signal(dump, SIGINT);
    user_expect_status(dump, -SIGINT);
    user_expect_lacks(user_err(dump), "no data");
    user_expect_same(user_names(b.host), "");
    user_expect_equal(user_events(s, "heartbeat"), 0);
}

/* --- The end of a recording --- */

STORY(a_signal_beside_the_last_rename,
      "a signal while a file gets its name does not give it up")
{
    static const char *const calls[] = {"fsync", "rename", "close", "unlink"};
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, LIVE " -o a.csv --duration 2 --json");
    user_until(user_files(b.host, "a.csv.", ".part") > 0);
    user_pause_ms(1500);
    user_signal_at(dump, calls[user_any(0, 3)], (unsigned)user_any(1, 2),
                   SIGHUP);
    user_expect_status(dump, DONE);
    user_expect_lacks(user_err(dump), "given up");
    user_expect_same(user_names(b.host), "a.csv ");
}

STORY(a_recording_and_a_power_cut,
      "a recording that the power cut short can be read from its beginning")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    (void)user_start(b.host, LIVE " -o a.pcap --rotate 300kB");
    until_data(&b, "a-0002.pcap", 1000);
    user_pause_between_ms(100, 2000);
    world_host_power_cut(b.host, 0.3);
    for (unsigned i = 1; i < 20; i++) {
        const char *name = user_format("a-%04u.pcap", i);
        if (user_size(b.host, name) >= 0) {
            user_expect_at_least(user_size(b.host, name), 24);
            user_expect(user_number(summary_of(&b, name), "records") > 0);
        }
    }
}

STORY(a_hole_in_a_recording,
      "a hole of a second or more is in the summary, and no jump of a clock")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, LIVE " --json -o a.pcap");
    until_data(&b, "a.pcap", 100000);
    user_pause_between_ms(0, 1000);
    const int64_t hole_ms = user_any(1200, 9000);
    user_cable(b.eth0, false);
    user_pause_ms(hole_ms);
    user_cable(b.eth0, true);
    until_more(&b, "a.pcap", 300000);
    user_expect_end(dump, SIGINT, 0);
    const char *json = user_out(dump);
    user_expect_equal(user_number(json, "pauses"), 1);
    user_expect_at_least(1000 * user_number(json, "paused_s"), hole_ms - 100);
    user_expect_at_most(1000 * user_number(json, "paused_s"), hole_ms + 400);
    user_expect_equal(user_number(json, "sensors.0.clock.sensor_breaks"), 0);
    user_expect_equal(user_number(json, "sensors.0.clock.host_steps"), 0);
    user_expect_at_least(user_events(s, "stream"), 1);
}

STORY(data_that_comes_damaged,
      "datagrams that the system drops for their checksums are not all put "
      "down to a slow program")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, LIVE " -o a.pcap");
    until_data(&b, "a.pcap", 100000);
    user_fault_in(b.eth0, (user_faults){.corrupt = 0.05});
    until_more(&b, "a.pcap", 500000);
    user_expect_end(dump, SIGINT, 0);
    user_expect_has(user_err(dump), "the system dropped");
    user_expect_has(user_err(dump), "damaged, with wrong checksums");
    user_expect_has(user_err(dump), "too slow, or they came damaged");
}

/* --- Why the laser is off --- */

#define CAUSE "TLV_CMD_OFF: switched off by another program's command"

STORY(a_laser_that_another_switched_off,
      "whoever sees that another program has switched the laser off says so")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat");
    user_tool *watch = user_start(b.host, "lumctl status --watch");
    user_until(user_has(user_out(beat), "laser may be up: no bit set"));
    user_expect_status(user_run(b.host, "lumctl laser on"), DONE);
    user_until(user_has(user_out(beat), "laser up"));
    user_until(user_has(user_out(watch), "laser up"));
    user_expect_lacks(user_out(beat), CAUSE);
    user_expect_lacks(user_out(watch), CAUSE);
    user_expect_status(user_run(b.host, "lumctl laser off"), DONE);
    user_until(user_has(user_out(beat), CAUSE));
    user_until(user_has(user_out(watch), CAUSE));
    user_expect_end(beat, SIGINT, DONE);
    user_expect_end(watch, SIGINT, DONE);
    user_expect(!user_laser_is_on(s));
}

STORY(a_recording_that_another_switched_off,
      "a recording says that another program has switched its laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD);
    user_until(user_laser_is_on(s));
    user_pause_ms(1500);
    user_expect_status(user_run(b.host, "lumctl laser off"), DONE);
    user_until(user_has(user_err(dump), CAUSE));
    user_expect_end(dump, SIGINT, DONE);
}
