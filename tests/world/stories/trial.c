/* What a stranger met in a day with the tools. */
#include "bench.h"

STORY(off_at_half_loss,
      "laser off succeeds though half of all datagrams are lost")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    user_fault(b.eth0, (user_faults){.lose = 0.5});
    user_tool *beat = user_start(b.host, "lumctl heartbeat --rate 20");
    user_until(user_events(s, "stream") > 0);
    for (int i = 0; i < 12; i++) {
        (void)user_run(b.host, "lumctl --timeout 100 --retries 30 send u");
        user_tool *off = user_run(b.host, "lumctl laser off");
        user_expect_status(off, 0);
        user_expect(!user_laser_is_on(s));
    }
    user_expect_end(beat, SIGINT, 0);
    for (int i = 0; i < 3; i++) {
        user_tool *dump = user_run(b.host, RECORD " --duration 1 --json");
        user_expect_same(user_value(user_out(dump), "laser"), "off");
        user_expect(!user_laser_is_on(s));
    }
}

STORY(two_interfaces, "one address at two interfaces: each is found, and "
                      "--interface says which is meant")
{
    const user_bench b = user_bench_new();
    world_segment *other = world_segment_new("other");
    (void)user_interface(b.host, "eth1", other, "10.42.0.2/24");
    world_host *far = user_sensor_host("far", other, "10.42.0.37/24");
    user_sensor *near_one = user_sensor_start(b.sensor, "--rate 2");
    user_sensor *far_one = user_sensor_start(far, "--rate 2 --seed 2");
    user_tool *find = user_run(b.host, "lumctl find --json");
    user_expect_status(find, 0);
    user_expect_equal(user_length(user_out(find), "sensors"), 2);
    find = user_run(b.host, "lumctl find");
    user_expect_like(user_err(find), "10.42.0.37 is on eth[01] and on eth[01]: "
                                     "the routes choose one");
    user_tool *on =
        user_run(b.host, "lumctl --interface eth1 send '33p' --json");
    user_expect_status(on, 0);
    user_expect_equal(user_done(far_one, "33p"), 1);
    user_expect_equal(user_done(near_one, "33p"), 0);
    user_tool *dump = user_start(b.host, RECORD " --interface eth1 -o a.pcap");
    user_until(user_laser_is_on(far_one));
    until_data(&b, "a.pcap", 1000);
    user_expect_end(dump, SIGINT, 0);
    user_expect(!user_laser_is_on(far_one));
    user_expect_equal(user_events(near_one, "laser"), 0);
    user_expect_equal(user_events(near_one, "heartbeat"), 0);
}

STORY(set_ip_that_strands, "a sensor that was stranded by force is told as "
                           "lost, and boots where it was")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    user_tool *set =
        user_run(b.host, "lumctl set-ip 10.42.9.9 --force --timeout 50");
    user_expect_status(set, 3);
    user_expect_equal(user_events(s, "set_ip"), 1);
    user_expect_status(user_run(b.host, "lumctl --timeout 50 status"), 3);
    user_signal(s->tool, SIGKILL);
    (void)user_wait(s->tool);
    (void)user_sensor_start(b.sensor, "--rate 0.5");
    user_expect_status(user_run(b.host, "lumctl status"), 0);
}

STORY(a_fifo_that_stalls, "outputs that stall are given up alone: the "
                          "recording beside them is whole, the laser stays on")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    (void)user_fifo(b.host, "before.csv");
    (void)user_fifo(b.host, "after.xyz");
    user_tool *dump = user_start(
        b.host, RECORD " --json --buffer 32MiB -o before.csv -o raw.pcap "
                       "-o after.xyz");
    user_until(user_count(user_err(dump), "makes no progress") == 2);
    user_expect(user_laser_is_on(s));
    user_until_beats(s, 6);
    user_expect_end(dump, SIGINT, 1);
    user_expect(!user_laser_is_on(s));
    const char *got = user_out(dump);
    expect_whole(&b, got, 1, "raw.pcap");
    for (int i = 0; i < 3; i += 2) {
        user_expect_same(user_value(got, user_format("outputs.%d.end", i)),
                         "stalled");
        user_expect(user_number(got, user_format("outputs.%d.dropped", i)) > 0);
        user_expect(user_number(got, user_format("outputs.%d.ended_s", i)) <
                    user_number(got, "seconds"));
    }
    user_expect_equal(user_count(user_err(dump), "before.csv makes no progress "
                                                 "and is given up"),
                      1);
    user_expect_equal(user_count(user_err(dump), "after.xyz makes no progress "
                                                 "and is given up"),
                      1);
    user_expect_equal(user_count(user_err(dump), "the others go on"), 2);
}

STORY(ctrl_c_in_the_background, "Ctrl-C ends a recording that a script's sh "
                                "made deaf to it, and its laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_terminal *terminal = world_terminal_new("terminal");
    user_tool *dump = user_start_with(
        b.host, (user_with){.terminal = terminal, .ignores_int = true},
        RECORD " -q -o night.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "night.pcap", 1000);
    world_terminal_type(terminal, "\003");
    user_expect_status(dump, 0);
    user_expect(!user_laser_is_on(s));
    user_expect_equal(user_heard(s, "d"), 1);
}
