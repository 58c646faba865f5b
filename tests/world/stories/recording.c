/* A recording: what it holds is what came. */
#include "bench.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>

/* A run that a signal ends once there are so many finished files. */
static user_tool *run_until_files(const user_bench *b, size_t count,
                                  const char *begin, const char *end,
                                  const char *arguments)
{
    user_tool *dump = user_start(b->host, RECORD " --json %s", arguments);
    user_until(user_files(b->host, begin, end) >= count);
    user_expect_end(dump, SIGINT, 0);
    return dump;
}

STORY(the_line_of_the_readme, "the README's line gives a cloud of points")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_run(b.host, RECORD " --duration 4 -o cloud.ply");
    user_expect_status(dump, 0);
    const char *header = user_file(b.host, "cloud.ply");
    const char *count = strstr(header, "element vertex ");
    user_expect(count != NULL);
    user_expect_at_least(strtol(count + 15, NULL, 10), 10000);
    user_expect_has(user_err(dump), "points");
    user_expect_lacks(user_err(dump), "warning");
    expect_laser_on_and_off(s);
    expect_no_parts(&b);
}

STORY(the_summary_of_a_recording,
      "the summary of a run is that of the capture that it recorded")
{
    static const char *const live_keys[] = {
        "received", "kernel_drops",    "ring_drops", "foreign_source",
        "seconds",  "heartbeats_sent", "laser"};
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4 --loss 0.01 --duplicate 0.01 "
                                      "--reorder 0.01 --corrupt 0.01");
    user_fault(b.eth0, (user_faults){.lose = 0.01,
                                     .repeat = 0.01,
                                     .reorder = 0.02,
                                     .jitter_ms = 2});
    user_tool *dump =
        user_run(b.host, RECORD " --duration 5 --json -o raw.pcap");
    user_expect_status(dump, 0);
    const char *live = user_out(dump);
    for (size_t i = 0; i < sizeof live_keys / sizeof *live_keys; i++) {
        user_expect(user_value(live, live_keys[i]) != NULL);
    }
    expect_same_summary(live, summary_of(&b, "raw.pcap"));
    user_expect_equal(user_number(live, "records") +
                          user_number(live, "ring_drops"),
                      user_number(live, "received"));
    user_expect_same(user_value(live, "laser"), "off");
    user_expect(user_number(live, "lost_words") > 0);
    user_expect(user_number(live, "points") > 10000);
    user_expect(user_number(live, "heartbeats_sent") >= 5);
    user_expect(user_number(live, "tlv") > 0);
    user_expect(user_number(live, "seconds") >= 5);
}

STORY(no_output, "without an output it sums up, and touches no laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_run(b.host, LIVE " --duration 2");
    user_expect_status(dump, 0);
    user_expect_has(user_out(dump), "heartbeats sent");
    user_expect_has(user_out(dump), "untouched");
    user_expect_has(user_out(dump), "lines");
    user_expect_equal(user_heard(s, "u") + user_heard(s, "d"), 0);
}

STORY(several_outputs, "several outputs are filled by one run")
{
    static const char names[] =
        "out.csv out.las out.pcap out.pcd out.ply out.png out.xyz ";
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD
                                 " -o out.csv -o out.ply -o out.pcd -o out.las "
                                 "-o out.xyz -o out.pcap -o - --format xyz");
    until_data(&b, "out.csv", 100000);
    until_data(&b, "out.xyz", 100000);
    until_data(&b, "out.pcap", 100000);
    user_expect_end(dump, SIGINT, 0);
    const char *got = summary_of(&b, "out.pcap");
    user_expect_equal(rows_of(&b, "out.csv"), user_number(got, "points"));
    user_expect(user_number(got, "points") > 1000);
    user_expect(strcmp(user_file(b.host, "out.xyz"), user_out(dump)) == 0);
    const char *left = user_names(b.host);
    user_expect_same(left, user_has(left, "png")
                               ? names
                               : "out.csv out.las out.pcap out.pcd out.ply "
                                 "out.xyz ");
}

STORY(the_last_of_the_frames,
      "a run ends after the last frame that it was asked for, with the laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump =
        user_run(b.host, RECORD
                 " --frames 2:3 --json -o a.csv -o f-%%04d.ply -o a.pcap");
    user_expect_status(dump, 0);
    expect_laser_on_and_off(s);
    user_expect_same(user_value(user_out(dump), "laser"), "off");
    user_expect_same(user_value(user_out(dump), "frames_selected"), "2");
    user_expect_at_most(user_number(user_out(dump), "frames"), 5);
    user_expect_equal(rows_of(&b, "a.csv"),
                      user_number(user_out(dump), "points"));
    user_expect_equal(user_files(b.host, "f-", ".ply"), 2);
    expect_same_summary(user_out(dump), summary_of(&b, "a.pcap --frames 2:3"));
    user_expect_status(user_run(b.host, LIVE " --frames :1 --quiet"), 0);
    dump =
        user_run(b.host, RECORD " --frames whole:2 --json -o w.csv -o w.pcap");
    user_expect_status(dump, 0);
    user_expect_same(user_value(user_out(dump), "frames_selected"), "2");
    user_expect_equal(rows_of(&b, "w.csv"),
                      user_number(user_out(dump), "points"));
    user_expect(user_number(user_out(dump), "points") > 1000);
    user_expect(!user_laser_is_on(s));
    dump = user_run(b.host, LIVE " --frames 2: --duration 3 --json");
    user_expect_status(dump, 0);
    user_expect_at_least(user_number(user_out(dump), "seconds"), 3);
}

STORY(one_file_a_frame, "a file of each frame, and none is left half done")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    (void)run_until_files(&b, 5, "f-", ".csv", "-o f-%04d.csv");
    expect_no_parts(&b);
}

STORY(another_port, "another port is shown as the sensor's")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4 --port 5600");
    user_tool *dump =
        user_run(b.host, LIVE ":5600 --duration 2 --json -o raw.pcap");
    user_expect_status(dump, 0);
    expect_same_summary(user_out(dump), summary_of(&b, "raw.pcap"));
}

STORY(quiet_says_nothing, "with -q nothing is said")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_run(b.host, LIVE " --duration 2 -q -o raw.pcap");
    user_expect_status(dump, 0);
    user_expect_same(user_out(dump), "");
    user_expect_same(user_err(dump), "");
}

/* --- rotation --- */

STORY(rotation_by_time,
      "files that rotate by time hold together what was recorded")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump =
        run_until_files(&b, 3, "c-", ".csv", "--rotate 2s -o r.pcap -o c.csv");
    const char *got = user_out(dump);
    const size_t files = user_files(b.host, "r-", ".pcap");
    double records = 0;
    user_expect_at_least(files, 3);
    for (unsigned i = 1; i <= files; i++) {
        const char *part = summary_of(&b, user_format("r-%04u.pcap", i));
        records += user_number(part, "records");
        user_expect(i == files || user_number(part, "duration_s") > 1.5);
    }
    user_expect_equal(records, user_number(got, "outputs.0.datagrams"));
    user_expect_at_most(files, user_number(got, "seconds") / 2 + 2);
    int64_t rows = 0;
    for (unsigned i = 1; i <= user_files(b.host, "c-", ".csv"); i++) {
        rows += rows_of(&b, user_format("c-%04u.csv", i));
    }
    user_expect_equal(rows, user_number(got, "points"));
    expect_no_parts(&b);
}

STORY(rotation_by_size, "files that rotate by size are as large as was said")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump =
        run_until_files(&b, 3, "r-", ".pcap", "--rotate 1MB -o r.pcap");
    const size_t files = user_files(b.host, "r-", ".pcap");
    double records = 0;
    for (unsigned i = 1; i <= files; i++) {
        const char *name = user_format("r-%04u.pcap", i);
        records += user_number(summary_of(&b, name), "records");
        user_expect(i == files || user_size(b.host, name) >= 1000000);
    }
    user_expect_equal(records, user_number(user_out(dump), "received"));
}

/* --- ends --- */

STORY(a_signal_in_good_order,
      "a signal ends a recording in good order: its summary is the capture's")
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, RECORD " --json -o raw.pcap -o c.las");
    until_data(&b, "c.las", 100000);
    user_pause_between_ms(0, 1000);
    user_expect_end(dump, numbers[user_any(0, 2)], 0);
    user_expect(!user_laser_is_on(s));
    expect_same_summary(user_out(dump), summary_of(&b, "raw.pcap"));
    user_expect_at_least(user_size(b.host, "c.las"), 10000);
    expect_no_parts(&b);
}

STORY(signals_again_and_again,
      "signals that come again do not leave the laser on")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2 --answer-delay 150");
    user_tool *dump = user_start(b.host, RECORD " -o raw.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.pcap", 100000);
    user_until_beats(s, 6);
    for (int i = 0; i < 5 && !user_ended(dump); i++) {
        user_signal(dump, SIGTERM);
        user_pause_ms(1);
    }
    user_expect_status(dump, 0);
    expect_laser_on_and_off(s);
}

/* `| head -n LINES`. */
static user_tool *start_with_head(const user_bench *b, const char *command,
                                  size_t lines)
{
    user_with with = {0};
    world_reader *reader = world_reader_new("head", &with.output);
    user_tool *dump = user_start_with(b->host, with, "%s", command);
    user_until(user_count(user_taken(reader), "\n") >= lines);
    world_reader_close(reader);
    return dump;
}

STORY(a_reader_that_leaves, "a reader that leaves ends the run quietly")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = start_with_head(&b, RECORD " -o - --format csv", 5);
    user_expect_status(dump, 0);
    user_expect_same(user_err(dump), "");
    expect_laser_on_and_off(s);
}

STORY(a_reader_that_leaves_early,
      "a reader that leaves is noticed though there are no points")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = start_with_head(&b, LIVE " -o - --format csv", 1);
    user_expect_status(dump, 0);
    user_expect_same(user_err(dump), "");
}

STORY(a_reader_that_leaves_others, "a reader that leaves ends its output alone")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = start_with_head(
        &b, RECORD " --duration 6 -o - --format csv -o raw.pcap", 5);
    user_expect_status(dump, 0);
    user_expect_equal(user_count(user_err(dump), "warning"), 1);
    user_expect_has(user_err(dump), "the reader of standard output has left");
    user_expect(user_number(summary_of(&b, "raw.pcap"), "duration_s") > 3);
    expect_laser_on_and_off(s);
}

STORY(the_last_reader_that_leaves, "the last reader that leaves ends it")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_with with = {0};
    world_reader *first = user_fifo(b.host, "points.xyz");
    world_reader_pace(first, WORLD_READER_FAST);
    world_reader *last = world_reader_new("reader", &with.output);
    user_tool *dump = user_start_with(
        b.host, with, RECORD " -o - --format csv -o points.xyz");
    user_until(strlen(user_taken(first)) >= 100);
    world_reader_close(first);
    user_until(user_has(user_err(dump), "the reader of points.xyz has left"));
    user_expect(!user_ended(dump));
    world_reader_close(last);
    user_expect_status(dump, 0);
    user_expect_equal(user_count(user_err(dump), "\n"), 1);
    expect_laser_on_and_off(s);
}

STORY(points_while_they_are_measured, "points come while they are measured")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = start_with_head(&b, RECORD " -o - --format csv", 1000);
    user_expect_status(dump, 0);
}

STORY(a_capture_on_standard_output, "a capture on standard output is one")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_with with = {0};
    world_disk *disk = world_disk_of(b.host);
    with.output = world_disk_open(disk, "/home/raw.pcap", O_WRONLY | O_CREAT);
    user_tool *dump =
        user_start_with(b.host, with, LIVE " --duration 2 -o - --format pcap");
    user_expect_status(dump, 0);
    user_expect(user_number(summary_of(&b, "raw.pcap"), "data") > 10);
}

STORY(killed_it_leaves_what_was_recorded,
      "a killed recording leaves what was recorded")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -o raw.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.pcap", 1000000);
    user_pause_between_ms(700, 1500);
    (void)user_end(dump, SIGKILL);
    user_expect(user_number(summary_of(&b, "raw.pcap"), "duration_s") > 0.5);
    user_until(!user_laser_is_on(s));
    const int64_t late_ns =
        user_last(s, "laser")->t_ns - user_last(s, "heartbeat")->t_ns;
    user_expect_at_most(late_ns, 3200 * WORLD_MS);
}

STORY(killed_it_leaves_its_messages,
      "a killed recording of messages leaves what was recorded")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(
        b.host, RECORD " --mcap packets --compression none -o raw.mcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.mcap", 1000000);
    user_pause_between_ms(2000, 2800);
    (void)user_end(dump, SIGKILL);
    user_expect(user_number(summary_of(&b, "raw.mcap"), "duration_s") > 1.0);
}

STORY(killed_while_the_laser_goes_off,
      "a recording that is killed while it waits for the laser to go off lacks "
      "nothing of what came before")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -o raw.pcap");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(150, 300);
    user_signal(dump, SIGTERM);
    world_interface_set_up(world_interface_find(b.sensor, "eth0"), false);
    user_pause_between_ms(1500, 1900);
    (void)user_end(dump, SIGKILL);
}

/* --- what a recording says of itself --- */

/* Addresses of the first frame of a capture, at their place behind its headers.
 */
STORY(who_sent_and_who_received, "a recording tells who sent and who received")
{
    static const char addresses[] = "\x0a\x2a\x00\x25\x0a\x2a\x00\x01";
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    for (int i = 0; i < 2; i++) {
        size_t size = 0;
        user_expect_status(user_run(b.host, LIVE " --duration 1 -o raw.pcap %s",
                                    i == 0 ? "" : "--interface eth0"),
                           0);
        char *bytes =
            world_disk_read(world_disk_of(b.host), "/home/raw.pcap", &size);
        user_expect(bytes != NULL && size > 24 + 16 + 34);
        user_expect(memcmp(bytes + 24 + 16 + 26, addresses, 8) == 0);
        free(bytes);
    }
}

STORY(a_pcapng_knows_its_calibration,
      "a recording as pcapng knows its calibration and its source")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_write_file(b.host, "front.yaml",
                    "version: 1\neyes: {blue: {mount: {x_m: 10.0}}}\n");
    user_tool *dump = user_start(
        b.host, RECORD " --calibration front.yaml -q -o a.pcap -o a.pcapng");
    until_data(&b, "a.pcap", 3000000);
    user_expect_end(dump, SIGINT, 0);
    user_expect_same(user_err(dump), "");
    user_expect_status(
        user_run(b.host, "lumdump a.pcap --calibration front.yaml -q -o a.csv"),
        0);
    user_expect_status(user_run(b.host, "lumdump a.pcapng -q -o b.csv"), 0);
    user_expect_at_least(rows_of(&b, "a.csv"), 1000);
    user_expect(
        strcmp(user_file(b.host, "a.csv"), user_file(b.host, "b.csv")) == 0);
}

STORY(older_files, "older files behind the last one of a recording are told")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    for (unsigned i = 2; i < 10; i++) {
        user_write_file(b.host, user_format("r-%04u.pcap", i), "old");
    }
    user_tool *dump =
        user_run(b.host, LIVE " --duration 1 --rotate 1h -o r.pcap");
    user_expect_status(dump, 0);
    user_expect_has(user_err(dump),
                    "r-0002.pcap and what follows are of an earlier run");
}
