/* That what comes of a live run is the scene. */
#include "bench.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WARM_UP_FRAMES 50
#define FRAMES         10 /* that the sensor plays */
#define LONGEST        200

/* Rows of a frame, without frame and time: how many, and a sum that does not
 * depend on their order. */
typedef struct frame_sum {
    uint64_t rows, sum;
} frame_sum;

static uint64_t hash(const char *bytes, size_t size)
{
    uint64_t value = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; i++) {
        value = (value ^ (uint8_t)bytes[i]) * UINT64_C(0x100000001b3);
    }
    return value;
}

/* Where field n of a row begins. */
static const char *field(const char *row, unsigned n)
{
    for (; n > 0; n--) {
        row += strcspn(row, ",") + 1;
    }
    return row;
}

/* timestamp and frame are the fields 7 and 8. */
static void add_row(const char *row, size_t size, frame_sum *frames,
                    size_t room)
{
    const char *time = field(row, 7);
    const char *eye = field(row, 9);
    const size_t number = strtoul(field(row, 8), NULL, 10);
    user_expect(number < room);
    frames[number].rows++;
    frames[number].sum += hash(row, (size_t)(time - row)) * 31 +
                          hash(eye, size - (size_t)(eye - row));
}

static void sum_frames(const user_bench *b, const char *name, frame_sum *frames,
                       size_t room)
{
    const char *row = user_file(b->host, name);
    memset(frames, 0, room * sizeof *frames);
    for (row += strcspn(row, "\n") + 1; *row != '\0';) {
        const size_t size = strcspn(row, "\n");
        add_row(row, size, frames, room);
        row += size + 1;
    }
}

static size_t find_frame(const frame_sum *wanted, const frame_sum *frames,
                         size_t room)
{
    size_t i = 0;
    while (i < room &&
           (frames[i].rows != wanted->rows || frames[i].sum != wanted->sum)) {
        i++;
    }
    return i;
}

STORY(a_live_cloud_is_the_scene,
      "the points of a warm laser are those of the scene, frame by frame")
{
    static frame_sum live[LONGEST];
    static frame_sum drive[FRAMES + 2];
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--frames 10 --seed 4 --returns-max 2");
    user_tool *dump =
        user_run(b.host,
                 RECORD " --duration 8 --eye green --return first "
                        "--frames %d: -o live.csv --json",
                 WARM_UP_FRAMES);
    user_expect_status(dump, 0);
    user_expect_equal(user_number(user_out(dump), "kernel_drops"), 0);
    user_expect_status(user_run(b.host, "lumsim -q -o drive.pcap --frames 10 "
                                        "--seed 4 --returns-max 2"),
                       0);
    user_expect_status(user_run(b.host, "lumdump drive.pcap -q --eye green "
                                        "--return first -o drive.csv"),
                       0);
    sum_frames(&b, "live.csv", live, LONGEST);
    sum_frames(&b, "drive.csv", drive, FRAMES + 2);
    size_t last = LONGEST - 1;
    while (last > 0 && live[last].rows == 0) {
        last--;
    }
    size_t first = 0;
    while (live[first].rows == 0) {
        first++;
    }
    user_expect_at_least(last - first, 9);
    /* The last may be cut. They come in their order, again and again. */
    const size_t begin = find_frame(&live[first], drive, FRAMES + 2);
    user_expect(drive[begin % (FRAMES + 2)].rows > 1000);
    for (size_t i = first; i < last; i++) {
        const size_t at = find_frame(&live[i], drive, FRAMES + 2);
        user_expect(at < FRAMES + 2);
        user_expect_equal((at + FRAMES - begin) % FRAMES, (i - first) % FRAMES);
    }
}

STORY(frames_as_from_the_capture,
      "a live run gives the frames that its recording gives")
{
    static const char what[] =
        "--columns frame,eye,line,pixel,x,time --organized --return last";
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(
        b.host, RECORD " -q -o raw.pcap %s -o live.csv -o live-%%d.pcd", what);
    user_until(user_files(b.host, "live-", ".pcd") >= 5);
    user_expect_end(dump, SIGINT, 0);
    user_expect_status(
        user_run(b.host, "lumdump raw.pcap -q %s -o again.csv -o again-%%d.pcd",
                 what),
        0);
    user_expect_at_least(rows_of(&b, "live.csv"), 10000);
    user_expect(strcmp(user_file(b.host, "live.csv"),
                       user_file(b.host, "again.csv")) == 0);
    const size_t files = user_files(b.host, "live-", ".pcd");
    user_expect_equal(user_files(b.host, "again-", ".pcd"), files);
    for (size_t i = 1; i <= files; i++) {
        size_t size[2];
        char *bytes[2];
        for (int k = 0; k < 2; k++) {
            bytes[k] = world_disk_read(
                world_disk_of(b.host),
                user_path(
                    user_format("%s-%zu.pcd", k == 0 ? "live" : "again", i)),
                &size[k]);
            user_expect(bytes[k] != NULL);
        }
        /* But for the source, which is told above it. */
        const char *live = strstr(bytes[0], "VERSION 0.7");
        const char *again = strstr(bytes[1], "VERSION 0.7");
        user_expect(live != NULL && again != NULL);
        const size_t left = size[0] - (size_t)(live - bytes[0]);
        user_expect_equal(left, size[1] - (size_t)(again - bytes[1]));
        user_expect(memcmp(live, again, left) == 0);
        free(bytes[0]);
        free(bytes[1]);
    }
}

/* All timestamps of a run are between its begin and its end, by the calendar.
 */
static void tell_times(const char *clock)
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_host_step_utc(b.host, user_any(-1000, 1000000) * WORLD_S);
    const int64_t before_us = world_host_utc_ns(b.host) / 1000;
    user_tool *dump =
        user_start(b.host, RECORD " --time %s --eye blue -o f-%%d.csv", clock);
    user_until(user_files(b.host, "f-", ".csv") >= 2);
    user_expect_end(dump, SIGINT, 0);
    const int64_t after_us = world_host_utc_ns(b.host) / 1000;
    for (size_t i = 1; i <= user_files(b.host, "f-", ".csv"); i++) {
        const char *row = user_file(b.host, user_format("f-%zu.csv", i));
        for (row += strcspn(row, "\n") + 1; *row != '\0';
             row += strcspn(row, "\n") + 1) {
            const int64_t at_us = strtoll(field(row, 7), NULL, 10);
            user_expect(before_us <= at_us && at_us <= after_us);
        }
    }
}

STORY(times_of_arrival, "times of arrival are those of the calendar's clock")
{
    tell_times("arrival");
}

STORY(times_of_utc, "so are times of UTC")
{
    tell_times("utc");
}

STORY(a_calendar_that_steps, "a calendar's clock that is set in the midst of a "
                             "recording harms neither data nor laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    user_tool *dump = user_start(b.host, RECORD " --json -o raw.pcap");
    user_until(user_laser_is_on(s));
    until_data(&b, "raw.pcap", 100000);
    world_host_step_utc(b.host, user_any(-4000, 4000) * WORLD_S);
    user_until_beats(s, 12);
    user_expect(user_laser_is_on(s));
    user_expect_end(dump, SIGINT, 0);
    expect_laser_on_and_off(s);
    expect_same_summary(user_out(dump), summary_of(&b, "raw.pcap"));
}
