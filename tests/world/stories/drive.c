/* A drive from the first look to the end, over a wire that is bad. */
#include "bench.h"

#include <string.h>

static const user_faults bad_wire = {
    .lose = 0.03, .repeat = 0.03, .reorder = 0.07, .reorder_ms = 20};
static const user_faults worse_wire = {
    .lose = 0.35, .repeat = 0.2, .reorder = 0.4, .reorder_ms = 150};

/* Datagrams that the wire brought a tool. */
static int64_t taken_by(const user_tool *tool)
{
    uint64_t count = 0;
    for (const world_socket_log *log = world_net_sockets(); log != NULL;
         log = log->next) {
        count += log->pid == tool->process->pid ? log->got[WORLD_RECEIVED] : 0;
    }
    return (int64_t)count;
}

STORY(a_drive_on_a_bad_wire, "a drive on a bad wire: each command that is "
                             "done was carried out, and the summary is the "
                             "capture's")
{
    static const char *const settings[][2] = {{"power 80", "80p"},
                                              {"threshold green 40", "40g"},
                                              {"holdoff 180", "180h"}};
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_fault(b.eth0, bad_wire);
    user_tool *status = user_run(b.host, "lumctl status --json");
    user_expect_status(status, 0);
    user_expect_same(user_value(user_out(status), "idle"), "true");
    user_expect_status(user_run(b.host, "lumctl time"), 0);
    user_tool *dump =
        user_start(b.host, LIVE " --json -o drive.pcap -o drive.csv");
    user_until(user_events(s, "stream") > 0);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    user_expect(user_laser_is_on(s));
    for (size_t i = 0; i < 3; i++) {
        user_expect_status(user_run(b.host, "lumctl %s", settings[i][0]), 0);
        user_expect_at_least(user_done(s, settings[i][1]), 1);
    }
    until_data(&b, "drive.pcap", 3000000);
    (void)user_end(s->tool, SIGTERM);
    user_pause_ms(500);
    user_expect_end(dump, SIGINT, 0);
    const char *live = user_out(dump);
    const char *recorded = summary_of(&b, "drive.pcap");
    user_expect(world_net_count(WORLD_LOST_LINK) > 0);
    user_expect_equal(user_number(live, "kernel_drops"), 0);
    user_expect_equal(user_number(live, "ring_drops"), 0);
    user_expect_equal(user_number(live, "received"), taken_by(dump));
    user_expect_equal(user_number(recorded, "records"), taken_by(dump));
    user_expect(user_number(live, "points") > 10000);
    expect_same_summary(live, recorded);
    user_expect_equal(rows_of(&b, "drive.csv"), user_number(live, "points"));
}

static user_tool *ok(const user_bench *b, const char *command)
{
    user_tool *tool = user_run(b->host, "%s", command);
    user_expect_status(tool, 0);
    return tool;
}

STORY(the_bench_guide, "the bench guide's commands work on a bad wire, from "
                       "the first look to the end")
{
    static const char *const commands[] = {
        "lumctl laser on",
        "lumctl power 60",
        "lumctl threshold green 40",
        "lumctl lines 64",
        "lumctl yscan 15",
        "lumctl yscan --shape gaussian:-3:4 --lines 64",
        "lumctl apply settings.yaml",
        "lumctl status --watch --duration 1"};
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_fault(b.eth0, bad_wire);
    user_write_file(b.host, "settings.yaml",
                    "version: 1\nlines: 64\nyscan: 20\npower: 70\n");
    (void)ok(&b, "lumctl status");
    (void)ok(&b, "lumctl time");
    (void)ok(&b, LIVE " --duration 2");
    (void)ok(&b, RECORD " --duration 4 -o cloud.ply");
    user_expect_at_least(user_size(b.host, "cloud.ply"), 100000);
    user_expect(!user_laser_is_on(s));
    user_tool *dump = user_start(b.host, LIVE " -o drive.pcap --rotate 2s");
    user_until(user_value(user_last(s, "stream")->line, "to")[0] == '1');
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        (void)ok(&b, commands[i]);
    }
    user_expect_at_least(user_done(s, "60p"), 1);
    user_expect_at_least(user_done(s, "40g"), 1);
    user_expect_at_least(user_done(s, "15y"), 1);
    user_until(user_files(b.host, "drive-", ".pcap") > 1);
    (void)ok(&b, "lumctl laser off");
    user_expect(!user_laser_is_on(s));
    user_expect_end(dump, SIGINT, 0);
    for (unsigned i = 1; i <= user_files(b.host, "drive-", ".pcap"); i++) {
        (void)summary_of(&b, user_format("drive-%04u.pcap", i));
    }
    user_with with = {0};
    world_writer *keys = world_writer_new(&with.input);
    user_tool *shell =
        user_start_with(b.host, with, "lumctl shell --heartbeat");
    user_type(shell, keys, "status\nlaser on\n50p\n");
    world_writer_close(keys);
    user_expect_status(shell, 0);
    user_expect_at_least(user_done(s, "50p"), 1);
    user_expect(!user_laser_is_on(s));
}

STORY(done_is_done, "a command is called done only if the sensor did it")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    user_fault(b.eth0, worse_wire);
    unsigned ends[4] = {0};
    for (int value = 20; value < 60; value++) {
        user_tool *power = user_run(
            b.host, "lumctl --timeout 200 --retries 1 power %d", value);
        const int status = user_wait(power);
        user_expect(status == 0 || status == 3);
        ends[status]++;
        if (status == 0) {
            user_expect_at_least(user_done(s, user_format("%dp", value)), 1);
        }
    }
    user_expect(ends[0] > 0 && ends[3] > 0);
}

STORY(off_never_leaves_it_on,
      "laser off on a bad wire is done, or says that it may not be")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    user_fault(b.eth0, worse_wire);
    user_tool *beat = user_start(b.host, "lumctl heartbeat --rate 10");
    user_until(user_events(s, "stream") > 0);
    for (int i = 0; i < 8; i++) {
        (void)user_run(b.host, "lumctl --timeout 150 laser on");
        user_tool *off = user_run(b.host, "lumctl --timeout 150 laser off");
        const size_t rises = user_laser_rises(s);
        if (user_wait(off) == 0) {
            user_pause_ms(400); /* what is still on its way */
            user_expect(!user_laser_is_on(s));
            user_expect_equal(user_laser_rises(s), rises);
        } else {
            user_expect(user_wait(off) == 1 || user_wait(off) == 3);
            user_expect_has(user_err(off), "laser");
        }
    }
    user_expect_end(beat, SIGINT, 0);
}

STORY(set_ip_proves_the_move, "set-ip on a bad wire moves the sensor, and "
                              "proves it")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    user_fault(b.eth0, bad_wire);
    user_tool *set = user_run(b.host, "lumctl set-ip 10.42.0.99");
    user_expect_status(set, 0);
    user_expect_at_least(user_events(s, "move"), 1);
    user_expect_has(user_format("%s%s", user_out(set), user_err(set)),
                    "10.42.0.37"); /* where it boots */
    user_expect_status(user_run(b.host, "lumctl --host 10.42.0.99 status"), 0);
}

STORY(an_idle_day, "a day of a shell that does nothing but keep its session")
{
    user_limit(90000, 100000000);
    const user_bench b = user_bench_new();
    user_expect_status(user_run(b.sensor, "lumsim -q -o tiny.pcap --frames 1"),
                       0);
    user_sensor *s = user_sensor_start(b.sensor, "--replay tiny.pcap");
    user_with with = {0};
    world_writer *keys = world_writer_new(&with.input);
    user_tool *shell =
        user_start_with(b.host, with, "lumctl shell --heartbeat");
    user_type(shell, keys, "laser on\n");
    user_until(user_laser_is_on(s));
    user_pause_ms(24 * 3600 * 1000);
    user_expect(user_laser_is_on(s));
    user_expect_equal(user_laser_rises(s), 1);
    world_writer_close(keys);
    user_expect_status(shell, 0);
    user_expect(!user_laser_is_on(s));
}

STORY(an_idle_hour, "an hour of heartbeats: the laser stays on, and goes off "
                    "at its end")
{
    user_limit(4000, 100000000);
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 0.2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat");
    user_until(user_events(s, "stream") > 0);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    user_pause_ms(3600 * 1000);
    user_expect(user_laser_is_on(s));
    user_expect_equal(user_laser_rises(s), 1);
    user_expect_end(beat, SIGINT, 0);
    user_until(!user_laser_is_on(s));
}
