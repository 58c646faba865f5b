/* Sensors that misbehave, and a network that does. */
#include "bench.h"

#include <string.h>

STORY(nobody_there, "a sensor that is not there is told, and nothing is left")
{
    const user_bench b = user_bench_new();
    user_tool *dump =
        user_run(b.host, RECORD " --duration 1 -o c.csv -o r.pcap");
    user_expect_status(dump, 3);
    user_expect_has(user_err(dump), "no data from 10.42.0.37");
    user_expect_has(user_err(dump), "doctor");
    user_expect_same(user_names(b.host), "");
}

STORY(a_sensor_that_comes_back,
      "a sensor that dies and comes back with its clock reset goes on")
{
    const user_bench b = user_bench_new();
    user_sensor *first =
        user_sensor_start(b.sensor, "--rate 4 --clock 900000000");
    user_tool *dump = user_start(b.host, LIVE " --json -o a.pcap");
    until_data(&b, "a.pcap", 500000);
    (void)user_end(first->tool, SIGKILL);
    user_pause_between_ms(10, 5000);
    user_sensor *second = user_sensor_start(b.sensor, "--rate 4");
    until_more(&b, "a.pcap", 500000);
    (void)user_end(second->tool, SIGTERM);
    user_pause_ms(300);
    user_expect_end(dump, SIGINT, 0);
    user_expect(user_number(user_out(dump), "lines") > 64);
    /* The clock's jump costs the packets that could have been strays. */
    user_expect(user_number(user_out(dump), "stray") <= 4);
    user_expect_equal(user_number(user_out(dump), "malformed"), 0);
}

STORY(a_second_session, "a second session is refused, told who has the "
                        "first, and harms nothing")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *first = user_start(b.host, LIVE " -o raw.pcap");
    until_data(&b, "raw.pcap", 1000);
    user_write_file(b.host, "old.csv", "old");
    user_tool *second = user_run(b.host, RECORD " -o old.csv");
    user_expect_status(second, 1);
    user_expect_has(user_err(second),
                    user_format("lumdump (process %ld) has the session",
                                first->process->pid));
    user_expect_has(user_err(second), "must end");
    user_expect_lacks(user_err(second), "does not own");
    user_expect_same(user_file(b.host, "old.csv"), "old");
    user_tool *beat = user_run(b.host, "lumctl heartbeat");
    user_expect_status(beat, 1);
    user_expect_has(user_err(beat), user_format("%ld", first->process->pid));
    user_expect_status(user_run(b.host, "lumctl status"), 0);
    user_expect_equal(user_events(s, "laser"), 0);
    user_expect_end(first, SIGINT, 0);
}

STORY(no_points_and_why, "that there are no points is told with its reason")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault interlock@USR1");
    user_tool *dump = user_run(b.host, LIVE " --duration 2");
    user_expect_has(user_err(dump), "no point is left of them: the laser of "
                                    "10.42.0.37 is not confirmed on; lumctl "
                                    "--host");
    user_signal(s->tool, SIGUSR1);
    user_until(user_events(s, "fault") > 0);
    for (int i = 0; i < 2; i++) {
        dump = user_run(b.host, "%s --duration 2", i == 0 ? LIVE : RECORD);
        user_expect_status(dump, 0);
        user_expect_has(user_err(dump), "no point is left of them: 10.42.0.37 "
                                        "reports a hazard: HW_SAFETY_BAD");
    }
    user_expect_equal(user_events(s, "laser"), 0);
}

STORY(a_hazard_at_the_start, "a hazard at the start is told and recorded")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4 --fault fan@0");
    user_tool *dump = user_run(b.host, RECORD " --duration 3 -o raw.pcap");
    user_expect_status(dump, 0);
    user_expect_has(user_err(dump), "stays down");
    user_expect_equal(user_count(user_err(dump), "hazard: FAN_PWM_BAD"),
                      2); /* at once, and in the summary */
    user_expect_like(user_err(dump),
                     "2\\.[0-9]+  seconds of data without the laser");
    user_expect_equal(user_events(s, "laser"), 0);
    user_expect_at_least(user_heard(s, "d"), 1);
    user_expect(user_number(summary_of(&b, "raw.pcap"), "lines") > 10);
}

STORY(a_laser_that_is_lost, "a laser that is lost is not switched on again")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_tool *dump = user_start(b.host, RECORD " -o raw.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.pcap", 100000);
    user_until_beats(s, 6);
    user_signal(s->tool, SIGUSR1);
    user_until(user_heard(s, "d") > 0);
    user_signal(s->tool, SIGUSR2);
    user_until(user_events(s, "fault") == 2);
    user_until_beats(s, 6);
    user_expect_end(dump, SIGINT, 0);
    user_expect_has(user_err(dump), "went off");
    user_expect_has(user_err(dump), "lumctl --host 10.42.0.37 laser on");
    user_expect_equal(user_heard(s, "u"), 1);
    user_expect_equal(user_events(s, "laser"), 2);
}

STORY(a_reboot, "a reboot is told and the recording goes on")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 4 --fault reboot@USR1");
    user_tool *dump = user_start(b.host, RECORD " --json -o raw.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.pcap", 100000);
    user_until_beats(s, 20);
    user_pause_between_ms(0, 1000);
    user_signal(s->tool, SIGUSR1);
    user_until(user_events(s, "fault") > 0);
    user_until_beats(s, 6);
    until_more(&b, "raw.pcap", 200000);
    user_expect_end(dump, SIGINT, 0);
    user_expect_has(user_err(dump), "went off (TLV_CMD_ON");
    user_expect_has(user_err(dump), "10.42.0.37 was restarted");
    user_expect_lacks(user_err(dump), "another program");
    user_expect_equal(user_heard(s, "u"), 1);
    expect_same_summary(user_out(dump), summary_of(&b, "raw.pcap"));
}

STORY(silence, "silence is told and waited for")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 4 --fault silence@USR1-USR2");
    user_tool *dump = user_start(b.host, LIVE " -o raw.pcap");
    until_data(&b, "raw.pcap", 100000);
    user_signal(s->tool, SIGUSR1);
    user_until(user_like(user_err(dump), "[0-9:]{8}: no data from 10.42.0.37 "
                                         "for 3 s"));
    user_pause_between_ms(0, 60000);
    user_signal(s->tool, SIGUSR2);
    user_until(user_like(user_err(dump),
                         "data from 10.42.0.37 again, after [0-9.]+ s"));
    user_expect_end(dump, SIGINT, 0);
}

STORY(another_address, "a sensor at another address is told from a silent one")
{
    const user_bench b = user_bench_new();
    world_host *other = user_sensor_host("other", b.wire, "10.42.0.99/24");
    user_sensor *s = user_sensor_start(other, "--rate 4");
    user_tool *dump = user_start(b.host, "lumdump udp://10.42.0.99 -o a.pcap");
    until_data(&b, "a.pcap", 100000);
    (void)user_end(s->tool, SIGTERM);
    user_until(user_has(user_err(dump), "no data"));
    user_expect_has(user_err(dump), "10.42.0.37");
    user_expect_end(dump, SIGINT, 0);
}

STORY(an_end_that_nobody_confirms,
      "a laser whose end nobody confirms is an error")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4 --answer-loss 1");
    user_tool *dump = user_run(b.host, RECORD " --duration 2 -o raw.pcap");
    user_expect_status(dump, 1);
    user_expect_has(user_err(dump), "laser off was not answered");
    user_expect(user_number(summary_of(&b, "raw.pcap"), "data") > 10);
    user_expect(!user_laser_is_on(s));
}

STORY(another_layout, "another layout is diagnosed, and its recording kept")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_write_file(b.host, "p.yaml", "version: 1\ndata_packet_type: 9\n");
    user_tool *look = user_run(b.host, LIVE " --profile p.yaml -o c.csv");
    user_expect_status(look, 1);
    user_expect_has(user_err(look), "none of them is a data packet");
    user_expect_has(user_err(look),
                    "  lumdump udp://10.42.0.37 --laser --duration 3 -o "
                    "look.pcap\n  lumdump look.pcap --infer -o profile.yaml\n");
    user_expect_same(user_names(b.host), "p.yaml ");
    look = user_run(b.host, LIVE " --profile p.yaml -o raw.pcap");
    user_expect_status(look, 1);
    user_expect_has(user_err(look),
                    "  lumdump raw.pcap --infer -o profile.yaml\n");
    user_expect_lacks(user_err(look), "look.pcap");
    user_expect(user_number(summary_of(&b, "raw.pcap"), "data") > 50);
}

STORY(a_sensor_that_is_moved,
      "a sensor that is moved is named with its new address")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, LIVE " -o raw.pcap");
    until_data(&b, "raw.pcap", 100000);
    user_expect_status(user_run(b.host, "lumctl set-ip 10.42.0.99"), 0);
    user_until(user_has(user_err(dump), "the data comes from 10.42.0.99 now, "
                                        "not from 10.42.0.37"));
    user_expect_has(user_err(dump), "begin one with 10.42.0.99");
    (void)user_end(dump, SIGINT);
}

STORY(laser_off_of_a_moved_sensor,
      "laser off that a moved sensor does not answer is advised where it is")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, RECORD " -o raw.pcap");
    user_until(user_laser_is_on(s));
    user_expect_status(user_run(b.host, "lumctl set-ip 10.42.0.99"), 0);
    user_until(user_has(user_err(dump), "begin one with 10.42.0.99"));
    user_signal(dump, SIGINT);
    user_until(user_has(user_err(dump), "laser off is repeated for"));
    user_signal(dump, SIGINT);
    user_expect_status(dump, 1);
    user_expect_has(user_err(dump), "lumdump: 10.42.0.37: laser off was not "
                                    "answered");
    user_expect_has(user_err(dump),
                    "make sure by lumctl --host 10.42.0.99 laser off");
    user_expect_status(user_run(b.host, "lumctl --host 10.42.0.99 laser off"),
                       0);
    user_expect(!user_laser_is_on(s));
}

/* --- the network --- */

STORY(a_cable_that_comes_back,
      "a network that goes and comes back is waited for, without the laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, RECORD " --json -o a.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "a.pcap", 1000);
    world_interface_set_up(b.eth0, false);
    user_until(!user_laser_is_on(s));
    user_pause_between_ms(0, 30000);
    world_interface_set_up(b.eth0, true);
    until_more(&b, "a.pcap", 200000);
    user_expect(!user_laser_is_on(s));
    user_until(user_has(user_err(dump), "laser"));
    user_expect_end(dump, SIGINT, 0);
}

STORY(two_sensors_and_a_pulled_cable,
      "of two sensors at two interfaces, both recordings have what came, and "
      "the one whose cable was pulled says how long nothing did")
{
    const user_bench b = user_bench_new();
    world_segment *other = world_segment_new("other");
    (void)user_interface(b.host, "eth1", other, "10.42.1.1/24");
    world_host *far = user_sensor_host("far", other, "10.42.1.37/24");
    user_sensor *left = user_sensor_start(b.sensor, "--rate 2");
    user_sensor *right = user_sensor_start(far, "--rate 2 --seed 2");
    user_tool *cut = user_start(b.host, RECORD " --json -o left.pcap");
    user_tool *good = user_start(
        b.host, "lumdump udp://10.42.1.37 --laser --json -o right.pcap");
    user_until(user_laser_is_on(left) && user_laser_is_on(right));
    until_data(&b, "left.pcap", 100000);
    until_data(&b, "right.pcap", 100000);
    user_pause_between_ms(0, 1000);
    user_cable(b.eth0, false);
    user_pause_ms(5000);
    user_expect(!user_laser_is_on(left));
    user_expect(user_laser_is_on(right));
    user_cable(b.eth0, true);
    until_more(&b, "left.pcap", 100000);
    user_expect_end(cut, SIGINT, 0);
    user_expect_end(good, SIGINT, 0);
    expect_whole(&b, user_out(cut), 0, "left.pcap");
    expect_whole(&b, user_out(good), 0, "right.pcap");
    user_expect_like(user_err(cut), "no data from 10\\.42\\.0\\.37 for 3 s");
    user_expect_like(user_err(cut), "data from 10\\.42\\.0\\.37 again, "
                                    "after 5(\\.[0-9])? s without");
    user_expect_lacks(user_err(good), "warning");
    expect_laser_on_and_off(left);
    expect_laser_on_and_off(right);
}

STORY(no_route, "a host without a route says so")
{
    const user_bench b = user_bench_new();
    world_interface_remove(b.eth0, user_ip("10.42.0.1"));
    user_tool *status =
        user_run(b.host, "lumctl --timeout 100 --retries 1 status");
    const int got = user_wait(status);
    user_expect(got == 1 || got == 3);
    user_expect_has(user_err(status), "no route");
}

STORY(a_taken_port, "a port that is taken is named")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *second =
        user_run(b.sensor, "lumsim --address 10.42.0.37 --frames 1");
    user_expect_status(second, 1);
    user_expect_has(user_err(second), "5517");
}
