/* What a bench does by itself: wait for a sensor, keep its laser on, note how
 * it is. */
#include "bench.h"
#include "help.h"

#include <string.h>

#define LASER_ENDS_NS (3200 * WORLD_MS)

/* --- wait --- */

STORY(a_wait_for_a_sensor_that_boots,
      "wait ends with 0 once a sensor answers that was switched on later")
{
    const user_bench b = user_bench_new();
    user_tool *wait = user_start(b.host, "lumctl wait --for 60");
    user_pause_between_ms(0, 9000);
    user_expect(!user_ended(wait));
    const int64_t on_ns = world_now();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(wait, DONE);
    user_expect_at_least(user_events(s, "tlv"), 1);
    user_expect_at_most(world_now(), on_ns + 4 * WORLD_S);
    user_expect_same(user_out(wait), "");
}

STORY(a_wait_that_is_over, "a wait for a sensor that stays silent ends with 3")
{
    const user_bench b = user_bench_new();
    user_tool *wait = user_run(b.host, "lumctl wait answers --for 3");
    user_expect_status(wait, NO_ANSWER);
    user_expect_has(user_err(wait), "10.42.0.37");
}

STORY(a_wait_for_the_laser, "wait up and wait down end when the laser is so")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *up = user_start(b.host, "lumctl wait up");
    user_expect_status(user_run(b.host, "lumctl wait down --for 3"), DONE);
    (void)hold(&b);
    user_pause_between_ms(0, 2000);
    user_expect(!user_ended(up));
    user_expect_status(user_run(b.host, "lumctl laser on"), DONE);
    user_expect_status(up, DONE);
    user_tool *down = user_start(b.host, "lumctl wait down");
    user_pause_between_ms(600, 2000);
    user_expect(!user_ended(down));
    user_expect_status(user_run(b.host, "lumctl laser off"), DONE);
    user_expect_status(down, DONE);
    user_expect(!user_laser_is_on(s));
}

STORY(a_wait_for_a_hazard_to_end,
      "wait clear ends with the hazard, or names it and ends with 4")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_signal(s->tool, SIGUSR1);
    user_until(user_events(s, "fault") == 1);
    user_tool *late = user_run(b.host, "lumctl wait clear --for 2");
    user_expect_status(late, HAZARD);
    user_expect_has(user_err(late), "FAN_PWM_BAD");
    user_tool *up = user_run(b.host, "lumctl wait up --for 2");
    user_expect_status(up, HAZARD);
    user_tool *clear = user_start(b.host, "lumctl wait clear");
    user_pause_between_ms(600, 2000);
    user_expect(!user_ended(clear));
    user_signal(s->tool, SIGUSR2);
    user_expect_status(clear, DONE);
}

STORY(a_wait_that_is_interrupted, "a wait that is interrupted ends by the "
                                  "signal")
{
    const user_bench b = user_bench_new();
    user_tool *wait = user_start(b.host, "lumctl wait");
    user_pause_between_ms(100, 3000);
    user_expect_end(wait, SIGINT, -SIGINT);
    user_expect_has(user_err(wait), "interrupted");
}

STORY(a_wait_in_words, "wait refuses what it cannot wait for")
{
    const user_bench b = user_bench_new();
    user_leave("status-2", "the words are wrong on purpose");
    user_expect_status(user_run(b.host, "lumctl wait on"), BAD);
    user_expect_status(user_run(b.host, "lumctl wait up down"), BAD);
    user_expect_status(user_run(b.host, "lumctl wait --for 0"), BAD);
}

/* --- heartbeat --laser --- */

static void expect_dark_within(const user_sensor *s, int64_t since_ns)
{
    user_until(!user_laser_is_on(s));
    user_expect_at_most(user_last(s, "laser")->t_ns, since_ns + LASER_ENDS_NS);
}

STORY(a_heartbeat_with_the_laser,
      "heartbeat --laser has the laser on, and off at its end")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat --laser");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(0, 6000);
    user_expect(user_laser_is_on(s));
    user_expect_end(beat, SIGINT, DONE);
    user_expect_has(user_err(beat), "the laser is off");
    expect_laser_on_and_off(s);
    user_tool *again =
        user_run(b.host, "lumctl heartbeat --laser --duration 3 --json");
    user_expect_status(again, DONE);
    user_expect_equal(user_laser_rises(s), 2);
    user_expect(!user_laser_is_on(s));
}

STORY(a_heartbeat_that_meets_a_hazard,
      "heartbeat --laser goes on in a hazard, without the laser, and ends "
      "with 4")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat --laser");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(0, 2000);
    user_signal(s->tool, SIGUSR1);
    user_until(user_heard(s, "d") > 0);
    user_expect_has(user_out(beat), "FAN_PWM_BAD");
    user_signal(s->tool, SIGUSR2);
    user_until_beats(s, 10);
    user_expect_equal(user_laser_rises(s), 1);
    user_expect_end(beat, SIGINT, HAZARD);
}

STORY(a_killed_heartbeat_with_the_laser,
      "a killed heartbeat --laser leaves the laser off")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat = user_start(b.host, "lumctl heartbeat --laser");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(0, 1500);
    user_signal(beat, SIGKILL);
    expect_dark_within(s, world_now());
}

/* --- status --every --- */

STORY(a_status_again_and_again,
      "status --every writes a row each time, also while the sensor is silent")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *status =
        user_start(b.host, "lumctl status --every 1 --csv a.csv --json");
    user_until(user_count(user_out(status), "\n") >= 3);
    user_expect_lacks(user_out(status), "\"answers\": false");
    (void)user_end(s->tool, SIGKILL);
    user_until(user_count(user_out(status), "\"answers\": false") >= 5);
    (void)user_sensor_start(b.sensor, "--rate 2");
    const size_t silent = user_count(user_out(status), "\"answers\": false");
    const size_t rows = user_count(user_out(status), "\n");
    user_until(user_count(user_out(status), "\n") >= rows + 4);
    user_expect_at_most(user_count(user_out(status), "\"answers\": false"),
                        silent + 2);
    user_expect_end(status, SIGINT, DONE);
    user_expect_equal(rows_of(&b, "a.csv"), user_count(user_out(status), "\n"));
}

STORY(a_hazard_that_came_and_went,
      "status --every ends with 4 after a hazard that came and went between "
      "two rows")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_tool *status = user_start(b.host, "lumctl status --every 10 --json "
                                           "--prometheus page.prom");
    user_until(user_count(user_out(status), "\n") >= 1);
    user_pause_ms(1000);
    user_signal(s->tool, SIGUSR1);
    user_pause_ms(1500);
    user_signal(s->tool, SIGUSR2);
    user_until(user_count(user_out(status), "\n") >= 2);
    user_expect_has(user_out(status), "FAN_PWM_BAD");
    user_until(user_has(user_file(b.host, "page.prom"), "FAN"));
    user_expect_end(status, SIGINT, HAZARD);
    user_expect_like(user_err(status), "came and went: .*FAN_PWM_BAD");
}

STORY(a_status_until,
      "status --every --until ends when it is so: 0, or 4 for a hazard")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_tool *up = user_start(b.host, "lumctl status --every 1 --until up");
    user_tool *hazard =
        user_start(b.host, "lumctl status --every 1 --until hazard");
    user_tool *beat = user_start(b.host, "lumctl heartbeat --laser");
    user_expect_status(up, DONE);
    user_expect(user_laser_is_on(s));
    user_tool *down =
        user_start(b.host, "lumctl status --every 1 --until down");
    user_pause_between_ms(500, 3000);
    user_expect(!user_ended(down));
    user_expect_end(beat, SIGINT, DONE);
    user_expect_status(down, DONE);
    user_expect(!user_ended(hazard));
    user_signal(s->tool, SIGUSR1);
    user_expect_status(hazard, HAZARD);
}

STORY(a_status_and_a_full_disk,
      "rows that a full disk does not take are told, and none is cut short")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    world_disk *disk = world_disk_of(b.host);
    user_tool *status = user_start(b.host, "lumctl status --every 0.5 --csv "
                                           "a.csv");
    user_until(user_size(b.host, "a.csv") > 0 && rows_of(&b, "a.csv") >= 2);
    user_pause_between_ms(0, 700);
    world_disk_fill(disk, (uint64_t)user_any(0, 600));
    user_until(user_has(user_err(status), "a.csv"));
    world_disk_heal(disk);
    user_pause_ms(1600);
    user_expect_end(status, SIGINT, FAILED);
    user_expect_has(user_err(status), "missing lines");
    const char *text = user_file(b.host, "a.csv");
    user_expect_equal(text[strlen(text) - 1], '\n');
    user_expect_equal(user_count(text, ",") % user_count(text, "\n"), 0);
}
