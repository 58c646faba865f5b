/* An output that stalls or fails does so alone. */
#include "bench.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* What the judges of files can read. */
#define PCAP_HEADER 24
#define PACKETS     "--mcap packets --compression none -o p.mcap"

/* A recording beside others, ended when it has said something; its JSON. */
static const char *record_until(const user_bench *b, user_sensor *s,
                                const char *arguments, const char *pattern)
{
    user_tool *dump = user_start(b->host, RECORD " --json %s", arguments);
    user_until(user_ended(dump) || user_like(user_err(dump), pattern));
    user_expect(!user_ended(dump));
    user_until_beats(s, 6);
    user_expect_end(dump, SIGINT, 1);
    user_expect(!user_laser_is_on(s));
    return user_out(dump);
}

STORY(a_reader_that_never_comes_back,
      "a reader that never comes back is not waited for")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_with with = {0};
    world_reader *reader = world_reader_new("reader", &with.output);
    world_reader_pace(reader, 0);
    user_tool *dump =
        user_start_with(b.host, with, RECORD " -o - --format csv");
    user_until(user_laser_is_on(s));
    user_pause_ms(3000);
    user_expect_end(dump, SIGINT, 1);
    expect_laser_on_and_off(s);
    user_expect_has(user_err(dump),
                    "standard output makes no progress and is given up");
    user_expect_like(user_err(dump), "outputs +stalled  standard output");
}

static void remove_file(const user_bench *b, const char *name)
{
    world_disk_remove(world_disk_of(b->host), user_path(name));
}

static double records_of(const user_bench *b, const char *name)
{
    return user_number(summary_of(b, name), "records");
}

/* Output number i, whose file was lost, has all that came in a file. */
static void expect_put_back(const user_bench *b, const char *json, unsigned i,
                            const char *name)
{
    user_expect_same(user_value(json, user_format("outputs.%u.end", i)),
                     "failed");
    user_expect_has(user_value(json, user_format("outputs.%u.error", i)),
                    user_format("put back as %s", name));
    user_expect_equal(records_of(b, name), user_number(json, "received"));
}

STORY(a_recording_that_is_removed,
      "a recording that is removed is told at once, and put back at the end")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(
        b.host, RECORD " --json -q -o raw.pcap -o other.pcap " PACKETS);
    until_data(&b, "raw.pcap", 100000);
    until_data(&b, "other.pcap", 100000);
    until_data(&b, "p.mcap", 100000);
    remove_file(&b, "raw.pcap");
    user_until(user_has(user_err(dump), "raw.pcap: was removed"));
    user_pause_between_ms(0, 3000);
    remove_file(&b, "p.mcap");
    user_until(user_has(user_err(dump), "p.mcap: was removed"));
    user_expect(user_laser_is_on(s));
    user_expect_end(dump, SIGINT, 1);
    const char *got = user_out(dump);
    expect_put_back(&b, got, 0, "raw.pcap");
    expect_whole(&b, got, 1, "other.pcap");
    expect_put_back(&b, got, 2, "p.mcap");
    user_expect_equal(user_count(user_err(dump), "raw.pcap: was removed"), 2);
    user_expect_equal(user_count(user_err(dump), "p.mcap: was removed"), 2);
    expect_no_parts(&b);
}

STORY(a_recording_that_is_replaced,
      "a recording that is replaced is saved beside the other file")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    world_disk *disk = world_disk_of(b.host);
    user_tool *dump = user_start(b.host, RECORD " --json -q -o raw.pcap");
    until_data(&b, "raw.pcap", 100000);
    char *header = world_disk_read(disk, user_path("raw.pcap"), NULL);
    remove_file(&b, "raw.pcap");
    world_disk_put(disk, user_path("raw.pcap"), header, PCAP_HEADER);
    free(header);
    user_until(user_has(user_err(dump), "raw.pcap: was removed"));
    user_expect_end(dump, SIGINT, 1);
    expect_put_back(&b, user_out(dump), 0, "raw.pcap.recovered");
    user_expect_equal(user_size(b.host, "raw.pcap"), PCAP_HEADER);
}

STORY(a_folder_that_is_removed,
      "a recording whose folder is removed is lost alone, and told")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    world_disk_make_folder(world_disk_of(b.host), user_path("day"));
    user_tool *dump =
        user_start(b.host, RECORD " --json -q -o day/raw.pcap -o other.pcap");
    user_until(user_size(b.host, "day/raw.pcap") > 100000);
    remove_file(&b, "day/raw.pcap");
    remove_file(&b, "day");
    user_until(user_has(user_err(dump), "day/raw.pcap: was removed"));
    user_expect_end(dump, SIGINT, 1);
    user_expect_has(user_value(user_out(dump), "outputs.0.error"),
                    "its data is lost, as it could not be put back: No such "
                    "file or directory");
    expect_whole(&b, user_out(dump), 1, "other.pcap");
}

STORY(a_copy_that_does_not_fit,
      "a removed recording is lost if the disk has no room, and told")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -q -o raw.pcap");
    until_data(&b, "raw.pcap", 200000);
    remove_file(&b, "raw.pcap");
    user_until(user_has(user_err(dump), "raw.pcap: was removed"));
    user_signal(dump, SIGINT);
    world_disk_fill(world_disk_of(b.host), 100000);
    user_expect_status(dump, 1);
    user_expect_like(user_err(dump), "its data is lost.*No space left");
    user_expect(user_size(b.host, "raw.pcap") < 0);
    expect_no_parts(&b);
}

STORY(a_copy_that_is_given_up, "a signal gives up a copy, whose rest the next "
                               "run removes")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " --json -o raw.pcap");
    until_data(&b, "raw.pcap", 200000);
    remove_file(&b, "raw.pcap");
    user_until(user_has(user_err(dump), "raw.pcap: was removed"));
    world_disk_stall(world_disk_of(b.host), WORLD_DISK_RENAME, WORLD_NEVER);
    user_signal(dump, SIGINT);
    user_until(user_files(b.host, "raw.pcap.", ".part") > 0);
    user_until(user_has(user_err(dump), "to be written; Ctrl-C gives it up"));
    user_signal(dump, SIGINT);
    user_until(*user_out(dump) != '\0');
    world_disk_heal(world_disk_of(b.host));
    user_expect_status(dump, 1);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "stalled");
    user_expect(!user_laser_is_on(s));
    dump = user_run(b.host, RECORD " -q --duration 1 -o raw.pcap");
    user_expect_status(dump, 0);
    expect_no_parts(&b);
}

STORY(a_copy_that_is_removed, "who removes the copy, too, is told that the "
                              "data is lost")
{
    const user_bench b = user_bench_new();
    world_disk *disk = world_disk_of(b.host);
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *dump = user_start(b.host, RECORD " -q -o raw.pcap");
    until_data(&b, "raw.pcap", 200000);
    remove_file(&b, "raw.pcap");
    user_until(user_has(user_err(dump), "raw.pcap: was removed"));
    world_disk_stall(disk, WORLD_DISK_RENAME, WORLD_NEVER);
    user_signal(dump, SIGINT);
    user_until(user_files(b.host, "raw.pcap.", ".part") > 0);
    unsigned i = 0;
    while (!user_has(world_disk_name(disk, "/home", i), ".part")) {
        i++;
    }
    remove_file(&b, world_disk_name(disk, "/home", i));
    expect_no_parts(&b);
    world_disk_heal(disk);
    user_expect_status(dump, 1);
    user_expect_has(user_err(dump), "its data is lost");
    user_expect(user_size(b.host, "raw.pcap") < 0);
}

STORY(files_that_are_removed_in_turn,
      "each file of a recording that is removed is told, and it goes on")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump =
        user_start(b.host, RECORD " --json -q --rotate 200kB -o r.pcap");
    until_data(&b, "r-0001.pcap", 50000);
    remove_file(&b, "r-0001.pcap");
    user_until(user_has(user_err(dump), "put back as r-0001.pcap"));
    until_data(&b, "r-0003.pcap", 50000);
    remove_file(&b, "r-0003.pcap");
    user_until(user_has(user_err(dump), "put back as r-0003.pcap"));
    until_data(&b, "r-0005.pcap", 50000);
    user_expect_end(dump, SIGINT, 1);
    double records = 0;
    for (unsigned i = 1; i <= user_files(b.host, "r-", ".pcap"); i++) {
        records += records_of(&b, user_format("r-%04u.pcap", i));
    }
    user_expect_equal(records, user_number(user_out(dump), "received"));
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "failed");
    expect_no_parts(&b);
}

STORY(a_busy_table_that_is_removed,
      "a file that is removed is told though its disk is always busy")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    user_tool *dump = user_start(b.host, RECORD " --json -q " PACKETS);
    until_data(&b, "p.mcap", 1000000);
    world_disk_slow(disk, WORLD_DISK_WRITE, 2 * WORLD_S, 3 * WORLD_S);
    user_until(user_has(user_err(dump), "p.mcap is too slow"));
    remove_file(&b, "p.mcap");
    user_until(user_has(user_err(dump), "p.mcap: was removed"));
    world_disk_heal(disk);
    user_expect_end(dump, SIGINT, 1);
    user_expect_has(user_err(dump), "put back as p.mcap");
}

STORY(a_second_signal, "a second signal does not wait for an output")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    (void)user_fifo(b.host, "stalls.csv");
    user_tool *dump = user_start(b.host, RECORD " -o stalls.csv");
    user_until(user_laser_is_on(s));
    user_pause_ms(3000);
    user_signal(dump, SIGINT);
    user_until(!user_laser_is_on(s));
    while (!user_ended(dump)) {
        user_signal(dump, SIGINT);
        user_pause_ms(20);
    }
    const int status = user_wait(dump);
    user_expect(status == 1 || status == -SIGINT);
}

STORY(a_terminal_that_stalls,
      "a terminal that stalls costs neither data nor the laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_terminal *terminal = world_terminal_new("terminal");
    world_terminal_stop(terminal, true);
    user_with with = {.terminal = terminal};
    world_reader *reader = world_reader_new("reader", &with.output);
    world_reader_pace(reader, 0);
    user_tool *dump = user_start_with(
        b.host, with, RECORD " --buffer 128KiB -o - --format csv");
    user_until(user_laser_is_on(s));
    user_until_beats(s, 40);
    user_expect(user_laser_is_on(s));
    world_reader_close(reader);
    world_terminal_stop(terminal, false);
    user_until(!user_laser_is_on(s));
    user_until(user_ended(dump));
}

STORY(a_pipe_without_a_reader,
      "a pipe without a reader keeps nothing from beginning")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_make_fifo(world_disk_of(b.host), "/home/nobody.csv");
    user_tool *dump =
        user_start(b.host, RECORD " --json -o nobody.csv -o raw.pcap");
    until_data(&b, "raw.pcap", 1000000);
    user_expect_end(dump, SIGINT, 1);
    expect_whole(&b, user_out(dump), 1, "raw.pcap");
    expect_laser_on_and_off(s);
    user_expect_has(user_err(dump),
                    "nobody.csv makes no progress and is given up");
}

STORY(a_reader_that_comes_late, "a reader that comes late gets all")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    world_disk_make_fifo(disk, "/home/late.csv");
    user_tool *dump = user_start(b.host, RECORD " -o late.csv -o raw.pcap");
    until_data(&b, "raw.pcap", 1000000);
    world_reader *reader = world_reader_of_fifo(disk, "/home/late.csv");
    user_until_beats(s, 6);
    user_expect_end(dump, SIGINT, 0);
    user_until(world_reader_has_ended(reader));
    user_expect_equal(user_count(user_taken(reader), "\n") - 1,
                      user_number(summary_of(&b, "raw.pcap"), "points"));
}

STORY(one_that_fails, "an output that fails ends alone")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    for (unsigned i = 2; i < 40; i++) {
        world_disk_make_folder(disk, user_format("/home/f-%04u.ply", i));
    }
    const char *got = record_until(
        &b, s, "-o raw.pcap -o f-%04d.ply -o c.csv",
        "f-[0-9]{4}.ply: is a directory.*: that output has ended, the others "
        "go on");
    expect_whole(&b, got, 0, "raw.pcap");
    user_expect_same(user_value(got, "outputs.1.end"), "failed");
    user_expect_like(user_value(got, "outputs.1.error"),
                     "f-[0-9]{4}.ply: is a directory");
    user_expect_same(user_value(got, "outputs.2.end"), "done");
    user_expect_equal(rows_of(&b, "c.csv"), user_number(got, "points"));
    expect_no_parts(&b);
}

STORY(a_table_that_fails, "a table on a full device ends alone")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_make_link(world_disk_of(b.host), "/home/full.csv", "/dev/full");
    const char *got = record_until(
        &b, s, "-o raw.pcap -o full.csv",
        "No space left on device.*: that output has ended, the others go on");
    expect_whole(&b, got, 0, "raw.pcap");
    user_expect_same(user_value(got, "outputs.1.end"), "failed");
    user_expect_has(user_value(got, "outputs.1.error"),
                    "No space left on device");
}

STORY(a_recording_that_fails, "a recording that fails leaves the other")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_make_folder(world_disk_of(b.host), "/home/a-0002.pcap");
    const char *got =
        record_until(&b, s, "-q --rotate 1MB -o a.pcap -o b.pcap",
                     "a-0002.pcap.*: that output has ended, the others go on");
    user_expect_same(user_value(got, "outputs.0.end"), "failed");
    double records = 0;
    for (unsigned i = 1; i <= user_files(b.host, "b-", ".pcap"); i++) {
        records += user_number(summary_of(&b, user_format("b-%04u.pcap", i)),
                               "records");
    }
    user_expect_equal(records, user_number(got, "received"));
    user_expect(user_number(summary_of(&b, "a-0001.pcap"), "records") > 100);
}

STORY(what_a_recording_lost, "what a recording lost is told though it is quiet")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    (void)user_fifo(b.host, "slow.pcap");
    user_tool *dump =
        user_start(b.host, RECORD " -q --buffer 128KiB -o slow.pcap");
    user_until(user_like(user_err(dump),
                         "slow.pcap is too slow for the data: [0-9]+ datagrams "
                         "are missing from this recording"));
    user_until(user_laser_is_on(s));
    user_expect_end(dump, SIGINT, 1);
    user_expect_like(user_err(dump),
                     "slow.pcap: datagrams are missing from this recording: "
                     "[0-9]+ dropped by its buffer");
    expect_laser_on_and_off(s);
}

/* In the JSON of a run, of its first output. */
static void expect_all_counted(const user_tool *dump)
{
    const char *json = user_out(dump);
    const long received = strtol(user_value(json, "received"), NULL, 10);
    const long taken =
        strtol(user_value(json, "outputs.0.datagrams"), NULL, 10);
    const long lost = strtol(user_value(json, "outputs.0.dropped"), NULL, 10);
    user_expect_at_least(taken, 1);
    user_expect_equal(taken + lost, received);
}

static void go_round(const char *output)
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    user_tool *dump =
        user_start(b.host, RECORD " --json --buffer 128KiB -o %s", output);
    user_until(user_laser_is_on(s));
    for (unsigned i = 0; i < 100; i++) {
        world_disk_stall(disk, WORLD_DISK_WRITE, WORLD_NEVER);
        user_pause_between_ms(20, 120);
        world_disk_heal(disk);
        user_pause_between_ms(0, 3);
    }
    user_expect_end(dump, SIGINT, 0);
    expect_all_counted(dump);
}

STORY(a_buffer_that_goes_round,
      "all that comes is in a recording, or counted, while its buffer goes "
      "round")
{
    go_round("a.pcap");
}

STORY(a_table_whose_buffer_goes_round,
      "all that comes is in a table, or counted, while its buffer goes round")
{
    go_round("a.csv");
}

STORY(what_has_ended_is_not_slow,
      "what has ended is not told to be too slow afterwards")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_reader *reader = user_fifo(b.host, "slow.pcap");
    user_tool *dump =
        user_start(b.host, RECORD " --buffer 128KiB -o slow.pcap -o c.csv");
    user_until(user_has(user_err(dump), "slow.pcap is too slow"));
    user_until_beats(s, 2);
    world_reader_close(reader);
    user_until(user_has(user_err(dump), "the reader of slow.pcap has left"));
    user_pause_ms(11000);
    user_expect_end(dump, SIGINT, 0);
    user_expect_lacks(strstr(user_err(dump), "has left"),
                      "slow.pcap is too slow");
}

/* --- disks --- */

static void tell_full_disk(const char *output)
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_fill(world_disk_of(b.host), (uint64_t)user_any(1, 3000000));
    user_tool *dump = user_run(b.host, RECORD " -o %s", output);
    user_expect_status(dump, 1);
    user_expect_has(user_err(dump), "No space left on device");
    user_expect(!user_laser_is_on(s));
    user_expect_at_least(user_heard(s, "d"), user_heard(s, "u") > 0 ? 1 : 0);
    expect_no_parts(&b);
    world_disk_heal(world_disk_of(b.host));
    if (user_size(b.host, output) > 0 && user_has(output, "pcap")) {
        (void)summary_of(&b, output);
    }
}

STORY(a_full_disk_and_a_table, "a full disk ends a table and the laser")
{
    tell_full_disk("c.csv");
}

STORY(a_full_disk_and_a_cloud, "a full disk ends a cloud and the laser")
{
    tell_full_disk("o.ply");
}

STORY(a_full_disk_and_a_capture,
      "a full disk ends a capture and the laser, and leaves what was before")
{
    tell_full_disk("raw.pcap");
}

STORY(a_slow_fsync, "a disk that takes longer than half a minute loses nothing")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    world_disk_stall(disk, WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump =
        user_start(b.host, RECORD " --json --duration 3 -o c.csv -o raw.pcap");
    user_until(user_has(user_err(dump), "to be written; Ctrl-C gives it up"));
    user_pause_ms(60000);
    user_expect(!user_ended(dump));
    world_disk_heal(disk);
    user_expect_status(dump, 0);
    const char *got = user_out(dump);
    user_expect_equal(user_number(summary_of(&b, "raw.pcap"), "records"),
                      user_number(got, "received"));
    user_expect_equal(rows_of(&b, "c.csv"), user_number(got, "points"));
    expect_no_parts(&b);
}

STORY(a_disk_that_stands_still,
      "a disk that stands still at the end is given up after half a minute")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, RECORD " --json -o raw.pcap");
    user_until(user_laser_is_on(s));
    world_disk_stall(world_disk_of(b.host), WORLD_DISK_WRITE, WORLD_NEVER);
    user_pause_between_ms(500, 3000);
    user_signal(dump, SIGINT);
    user_until(*user_out(dump) != '\0');
    world_disk_heal(world_disk_of(b.host));
    user_expect_status(dump, 1);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "stalled");
    user_expect_has(user_err(dump),
                    "raw.pcap makes no progress and is given up");
    user_expect(!user_laser_is_on(s));
}

STORY(a_signal_gives_up_a_disk,
      "a signal gives up what the disk does not finish")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_stall(world_disk_of(b.host), WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump =
        user_start(b.host, RECORD " --json --duration 3 -o c.csv");
    user_until(user_has(user_err(dump), "to be written; Ctrl-C gives it up"));
    user_signal(dump, SIGINT);
    user_until(*user_out(dump) != '\0');
    world_disk_heal(world_disk_of(b.host));
    user_expect_status(dump, 1);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "stalled");
    user_expect_has(user_err(dump), "c.csv was waited for and is given up");
    user_expect(!user_laser_is_on(s));
}

STORY(the_next_signal_gives_up_a_disk,
      "so does the next signal of a run that one ended")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_disk_stall(world_disk_of(b.host), WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump = user_start(b.host, RECORD " --json -o c.csv");
    until_data(&b, "c.csv", 100000);
    user_signal(dump, SIGTERM);
    user_until(!user_laser_is_on(s));
    user_pause_between_ms(1000, 9000); /* a signal before is for laser off */
    user_signal(dump, SIGINT);
    user_until(*user_out(dump) != '\0');
    world_disk_heal(world_disk_of(b.host));
    user_expect_status(dump, 1);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "stalled");
}

STORY(files_that_wait_for_the_disk,
      "files of a frame that wait for the disk are not given up")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    world_disk_stall(disk, WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump = user_start(
        b.host, RECORD " --json --buffer 1MB -o f-%%04d.csv -o raw.pcap");
    /* Told every 10 s; what stands still is given up after 5 s. */
    user_until(user_count(user_err(dump), "f-%04d.csv is too slow") >= 2);
    user_expect_lacks(user_err(dump), "given up");
    world_disk_heal(disk);
    user_expect_end(dump, SIGINT, 0);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "done");
    user_expect_same(user_value(user_out(dump), "outputs.1.end"), "done");
    expect_no_parts(&b);
}

STORY(a_cloud_that_rotates, "a cloud that rotates waits for no disk")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    world_disk_stall(disk, WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump =
        user_start(b.host, RECORD " --json --rotate 100kB -o r.csv");
    until_data(&b, "r-0005.csv", 2000000);
    world_disk_heal(disk);
    user_expect_end(dump, SIGINT, 0);
    int64_t rows = 0;
    for (unsigned i = 1; i <= user_files(b.host, "r-", ".csv"); i++) {
        rows += rows_of(&b, user_format("r-%04u.csv", i));
    }
    user_expect_equal(rows, user_number(user_out(dump), "points"));
    expect_no_parts(&b);
}

STORY(rotation_waits_for_no_disk, "rotation waits for no disk")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk *disk = world_disk_of(b.host);
    world_disk_stall(disk, WORLD_DISK_SYNC, WORLD_NEVER);
    user_tool *dump =
        user_start(b.host, RECORD " --json --rotate 200kB -o r.pcap");
    /* Sixteen wait for the disk; the next goes on for as long. */
    until_data(&b, "r-0017.pcap", 1000000);
    world_disk_heal(disk);
    until_data(&b, "r-0018.pcap", 0);
    user_expect_end(dump, SIGINT, 0);
    double records = 0;
    for (unsigned i = 1; i <= user_files(b.host, "r-", ".pcap"); i++) {
        records += user_number(summary_of(&b, user_format("r-%04u.pcap", i)),
                               "records");
    }
    user_expect_equal(records, user_number(user_out(dump), "received"));
    user_expect_equal(user_number(user_out(dump), "recording_drops"), 0);
    expect_no_parts(&b);
}

STORY(a_disk_that_refuses, "what the disk refuses of a rotated file is told")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_disk_fail(world_disk_of(b.host), WORLD_DISK_SYNC, 1, EIO);
    user_tool *dump = user_run(b.host, LIVE " --json --rotate 200kB -o r.pcap");
    user_expect_status(dump, 1);
    user_expect_same(user_value(user_out(dump), "outputs.0.end"), "failed");
    user_expect_has(
        user_err(dump),
        "r-0001.pcap: cannot write it to the disk: Input/output error");
}

STORY(a_power_cut, "after a power cut the laser goes off, and what has its "
                   "name is whole")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    (void)user_start(b.host, RECORD " -o f-%%04d.csv");
    until_data(&b, "f-0003.csv", 0);
    user_pause_between_ms(0, 2000);
    const int64_t cut_ns = world_now();
    world_host_power_cut(b.host, 0.5);
    user_until(!user_laser_is_on(s));
    user_expect_at_most(user_last(s, "laser")->t_ns, cut_ns + 3200 * WORLD_MS);
    for (unsigned i = 1; i < 40; i++) {
        const char *name = user_format("f-%04u.csv", i);
        if (user_size(b.host, name) >= 0) {
            const char *rows = user_file(b.host, name);
            user_expect_equal(strlen(rows), user_size(b.host, name));
            user_expect(rows[0] != '\0' && rows[strlen(rows) - 1] == '\n');
        }
    }
}
