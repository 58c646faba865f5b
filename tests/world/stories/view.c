/* lumview's feed of a live sensor, by what it would tell its page. */
#include "help.h"

#include <stdlib.h>
#include <string.h>

#define VIEW "lumview --no-open udp://10.42.0.37"

/* A number behind a word of the last line that it says. */
static double last_number(const user_tool *view, const char *word)
{
    const char *at = NULL;
    const char *next = user_out(view);
    while ((next = strstr(next, word)) != NULL) {
        next += strlen(word);
        at = next;
    }
    return at == NULL ? -1 : strtod(at, NULL);
}

STORY(view_a_sensor_without_laser,
      "a sensor whose laser is off is shown, and that is said")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 10");
    user_tool *view = user_start(b.host, VIEW);
    user_until(user_has(user_out(view),
                        "the laser of 10.42.0.37 is not confirmed on"));
    user_expect_like(
        user_out(view),
        "the laser of 10\\.42\\.0\\.37 is not confirmed on[^\n]*laser on");
    user_until(user_has(user_out(view), "playing"));
    user_until(user_like(user_out(view), "laser 0x0000"));
    user_pause_ms(1000);
    user_expect_end(view, SIGINT, DONE);
    user_expect(last_number(view, "frames ") >= 5);
    user_expect_equal(last_number(view, "points "), 0);
    user_expect_equal(user_heard(s, "u"), 0);
}

STORY(view_with_laser, "a laser that was asked for is on until the feed ends")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 10");
    user_tool *view = user_start(b.host, VIEW " --laser");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(2000, 3000);
    user_expect(user_laser_is_on(s));
    user_expect_end(view, SIGINT, DONE);
    user_expect(!user_laser_is_on(s));
    user_expect_equal(user_laser_rises(s), 1);
    user_expect(last_number(view, "points ") > 100000);
    user_expect_equal(last_number(view, "by the system "), 0);
}

STORY(view_after_a_hazard,
      "a laser that a hazard took down stays off in a view")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--fault fan@USR1-USR2");
    user_tool *view = user_start(b.host, VIEW " --laser");
    user_until(user_laser_is_on(s));
    user_until(user_has(user_out(view), "laser 0x0800"));
    user_signal(s->tool, SIGUSR1);
    user_until(user_like(user_out(view), "laser 0x0240"));
    user_signal(s->tool, SIGUSR2);
    user_until(user_like(user_out(view), "laser 0x0240.*laser 0x0200"));
    user_until_beats(s, 6);
    user_expect_has(user_out(view), "FAN_PWM_BAD");
    user_expect_has(user_out(view), "lumctl --host 10.42.0.37 laser on");
    user_expect(!user_laser_is_on(s));
    user_expect_equal(user_laser_rises(s), 1);
    user_expect_end(view, SIGINT, DONE);
}

STORY(view_a_silent_sensor, "a sensor that falls silent is waited for")
{
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--fault silence@USR1-USR2");
    user_tool *view = user_start(b.host, VIEW);
    user_until(user_has(user_out(view), "playing"));
    user_signal(s->tool, SIGUSR1);
    user_until(user_like(user_out(view),
                         "silent[^\n]*: [^\n]*no data from 10\\.42\\.0\\.37"));
    user_until(user_like(user_out(view), "silent[^\n]*laser unknown"));
    const size_t from = strlen(user_out(view));
    user_signal(s->tool, SIGUSR2);
    user_until(user_has(user_out(view) + from, "playing"));
    user_until(user_like(user_out(view) + from, "playing[^\n]*laser 0x"));
    user_expect_end(view, SIGINT, DONE);
}

STORY(view_a_sensor_that_comes, "a sensor that is not there is waited for")
{
    const user_bench b = user_bench_new();
    user_tool *view = user_start(b.host, VIEW);
    user_until(
        user_like(user_out(view),
                  "waiting[^\n]*no data from 10\\.42\\.0\\.37[^\n]*nor any "
                  "answer"));
    (void)user_sensor_start(b.sensor, "--rate 10");
    user_until(user_has(user_out(view), "playing"));
    user_pause_ms(1000);
    user_expect_end(view, SIGINT, DONE);
    user_expect(last_number(view, "frames ") >= 2);
}

STORY(view_a_laser_that_nobody_answers_for,
      "a laser that nobody answers for is told at a view's end")
{
    const user_bench b = user_bench_new();
    user_tool *view = user_start(b.host, VIEW " --laser");
    user_until(user_has(user_out(view), "nor any answer"));
    user_expect_end(view, SIGINT, FAILED);
    user_expect_has(user_err(view), "laser off was not answered");
}

STORY(view_has_one_owner, "a sensor that is viewed has one owner")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 10");
    user_tool *first = user_start(b.host, VIEW);
    user_until(user_has(user_out(first), "playing"));
    user_tool *second = user_run(b.host, VIEW " --laser");
    user_expect_status(second, FAILED);
    user_expect_has(user_err(second), "10.42.0.37");
    user_expect_end(first, SIGINT, DONE);
}
