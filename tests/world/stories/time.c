/* lumctl time against the clocks of the world: its offset is within the error
 * that it says. The judges ask the same of each line of it (time-true). */
#include "help.h"

#include <stdlib.h>
#include <string.h>

#define MS WORLD_MS

/* From a sensor's start until it has logged it and reads its clock. */
#define START_NS (2 * MS)

/* The line of a watch that was printed last. */
static const char *last_line(const char *text)
{
    const char *last = text;
    for (const char *at = text; (at = strchr(at, '\n')) != NULL;) {
        at++;
        last = *at != '\0' ? at : last;
    }
    return last;
}

/* What the host's calendar showed when the sensor's clock was 0. */
static int64_t offset_of(const user_bench *b, const user_sensor *s)
{
    return world_host_utc_ns(b->host) - world_now() +
           user_event_at(s, "start", 0)->t_ns;
}

static int64_t whole(const char *line, const char *key)
{
    const char *value = user_value(line, key);
    if (value == NULL) {
        user_fail(USER_HERE, "there is no %s in %s", key, line);
    }
    return strtoll(value, NULL, 10);
}

/* Of clocks that do not drift. */
static void expect_offset(const user_bench *b, const user_sensor *s,
                          const char *line)
{
    const int64_t away = whole(line, "offset_ns") - offset_of(b, s);
    const int64_t error = whole(line, "error_ns") + START_NS;
    user_expect_at_most(away, error);
    user_expect_at_least(away, -error);
}

STORY(time_on_a_quiet_wire, "time tells the offset of two clocks")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_pause_between_ms(0, 5000);
    user_tool *time = user_run(b.host, "lumctl time --json");
    user_expect_status(time, 0);
    expect_offset(&b, s, user_out(time));
    user_expect_at_most(whole(user_out(time), "error_ns"), 100 * WORLD_US);
}

STORY(time_on_a_lopsided_wire,
      "a way that is slower than the way back is within the error of time")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    const user_faults slow = {.delay_ms = (double)user_any(10, 150)};
    if (user_any(0, 1) == 0) {
        user_fault_out(b.eth0, slow);
    } else {
        user_fault_in(b.eth0, slow);
    }
    user_tool *time = user_run(b.host, "lumctl time --json");
    user_expect_status(time, 0);
    expect_offset(&b, s, user_out(time));
    user_expect_at_least(whole(user_out(time), "error_ns"),
                         (int64_t)(slow.delay_ms * 0.49e6));
}

STORY(time_on_a_bad_wire, "time tells the offset in spite of loss and disorder")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(user_run(b.host, "lumctl status"), 0); /* ARP is done */
    user_fault(b.eth0, (user_faults){.lose = 0.2,
                                     .repeat = 0.2,
                                     .reorder = 0.2,
                                     .reorder_ms = 60,
                                     .jitter_ms = 20});
    user_tool *time =
        user_run(b.host, "lumctl time --json --retries 30 --timeout 100");
    user_expect_status(time, 0);
    expect_offset(&b, s, user_out(time));
}

STORY(time_of_a_set_clock, "a calendar that is set moves the offset by as much")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *watch = user_start(b.host, "lumctl time --watch --json");
    user_until(user_count(user_out(watch), "\n") > 2);
    world_host_step_utc(b.host, user_any(-4000000, 4000000) * MS);
    user_pause_ms(2100);
    expect_offset(&b, s, last_line(user_out(watch)));
    user_expect_end(watch, SIGINT, 0);
}

STORY(time_of_a_fast_clock, "time measures the drift of this host's clock")
{
    const user_bench b = user_bench_new();
    const int64_t drift = user_any(-200000, 200000);
    world_host_set_drift(b.host, drift);
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *watch =
        user_run(b.host, "lumctl time --watch --json --duration 30");
    user_expect_status(watch, 0);
    const char *line = last_line(user_out(watch));
    const int64_t away = whole(line, "drift_ppb") - drift;
    user_expect_at_most(away, whole(line, "drift_error_ppb") + 100);
    user_expect_at_least(away, -whole(line, "drift_error_ppb") - 100);
    user_expect_at_most(whole(line, "drift_error_ppb"), 10000);
}

STORY(time_of_a_restart, "time begins anew when the sensor has restarted")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --fault reboot@%d",
                            (int)user_any(3, 6));
    user_tool *watch =
        user_run(b.host, "lumctl time --watch --json --duration 9");
    user_expect_status(watch, 0);
    const char *line = last_line(user_out(watch));
    user_expect_equal(whole(line, "resets"), 1);
    user_expect_at_most(whole(line, "clock_us"), 8000000);
}

STORY(time_at_a_wrap, "time goes on counting when the sensor's clock wraps")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --clock 4292000000");
    user_tool *watch =
        user_run(b.host, "lumctl time --watch --json --duration 8");
    user_expect_status(watch, 0);
    const char *line = last_line(user_out(watch));
    user_expect_equal(whole(line, "resets"), 0);
    user_expect_at_least(whole(line, "clock_us"), INT64_C(4297000000));
}
