/* lumctl's words, against a sensor that behaves. */
#include "help.h"

#include <stdlib.h>
#include <string.h>

STORY(a_status_that_nobody_wants,
      "the status of a sensor that nobody uses is idle and well")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *json =
        ask_until(b.host, "lumctl status --json", "\"idle\": true");
    user_expect_status(json, DONE);
    expect_value(json, "laser", "down");
    expect_value(json, "hazards", "[]");
    expect_value(json, "sensor", "10.42.0.37");
    user_expect_has(user_value(user_out(json), "bits"), "HEARTBEAT_TIMEOUT");
    const char *hex = user_value(user_out(json), "status_hex");
    user_expect_equal(strtol(hex, NULL, 16),
                      (int64_t)user_number(user_out(json), "status"));
    user_expect(user_number(user_out(json), "round_trip_ms") > 0);
    user_tool *plain = user_run(b.host, "lumctl status");
    user_expect_status(plain, DONE);
    user_expect_has(user_out(plain), "idle");
    user_expect_lacks(user_out(plain), "HAZARD");
    user_expect_lacks(user_out(plain), "\033");
}

STORY(a_hazard_comes_first, "a hazard comes first and is exit status 4")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --fault fan@0");
    user_tool *status = ask_until(b.host, "lumctl status", "FAN");
    user_expect_status(status, HAZARD);
    /* From the second line on, no hazard below anything else. */
    user_expect(
        user_like(user_out(status), "^[^\n]*\n +HAZARD|^[^\n]*\nHAZARD"));
    user_expect(
        !user_like(user_out(status), "\n *[a-zA-GI-Z][^\n]*\n(.*\n)* *HAZARD"));
    user_tool *json = user_run(b.host, "lumctl status --json");
    user_expect_status(json, HAZARD);
    user_expect_has(user_value(user_out(json), "hazards"), "FAN_PWM_BAD");
    user_tool *on = user_run(b.host, "lumctl laser on");
    user_expect_status(on, HAZARD);
    user_expect_has(user_err(on), "FAN_PWM_BAD");
    user_tool *power = user_run(b.host, "lumctl power 40");
    user_expect_status(power, DONE);
    user_expect_same(user_err(power), "");
}

/* The hazard ends, the heartbeats go on, and the laser never came up. */
static void expect_no_laser_after_the_hazard(const user_sensor *s)
{
    user_signal(s->tool, SIGUSR2);
    user_until(user_events(s, "fault") == 2);
    user_until_beats(s, 6);
    user_expect_equal(user_events(s, "laser"), 0);
    user_expect_same(user_value(user_last(s, "status")->line, "bits.0"),
                     "TLV_CMD_OFF");
    user_expect_equal(user_length(user_last(s, "status")->line, "bits"), 1);
}

STORY(a_laser_on_that_a_hazard_defeats,
      "a laser on that a hazard defeats is taken back")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault interlock@USR1-USR2");
    user_signal(s->tool, SIGUSR1);
    user_until(user_events(s, "fault") == 1);
    (void)hold(&b);
    user_tool *on = user_run(b.host, "lumctl laser on");
    user_expect_status(on, HAZARD);
    user_expect_has(user_err(on), "HW_SAFETY_BAD");
    user_expect_has(user_err(on), "cancelled: it will not come up by itself");
    user_tool *json = user_run(b.host, "lumctl laser on --json");
    user_expect_status(json, HAZARD);
    expect_value(json, "taken_back", "true");
    user_expect_equal(user_heard(s, "u"), 2);
    expect_no_laser_after_the_hazard(s);
    user_tool *again = user_run(b.host, "lumctl laser on --json");
    user_expect_status(again, DONE);
    user_expect(user_value(user_out(again), "taken_back") == NULL);
}

STORY(a_raw_u_that_a_hazard_defeats,
      "a raw u that a hazard defeats is taken back, from a shell too")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1-USR2");
    user_signal(s->tool, SIGUSR1);
    user_until(user_events(s, "fault") == 1);
    (void)hold(&b);
    user_tool *raw = user_run(b.host, "lumctl send '50p u'");
    user_expect_status(raw, HAZARD);
    user_expect_has(user_err(raw), "cancelled");
    user_tool *shell = run_fed(b.host, "lumctl shell", "u\n");
    user_expect_status(shell, HAZARD);
    user_expect_has(user_err(shell), "cancelled");
    expect_no_laser_after_the_hazard(s);
}

STORY(every_setting_is_carried_out,
      "every setting is carried out before it is called done")
{
    static const struct {
        const char *words, *text;
    } settings[] = {
        {"power 40", "40p"},          {"threshold green 41", "41g"},
        {"threshold blue 42", "42b"}, {"lines 64", "1f"},
        {"yscan 15", "15y"},          {"holdoff 170", "170h"},
        {"offset green 3", "3G"},     {"offset blue 4", "4B"},
    };
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        user_tool *plain = user_run(b.host, "lumctl %s", settings[i].words);
        user_expect_status(plain, DONE);
        user_expect_has(user_out(plain), user_format("10.42.0.37: %s done; ",
                                                     settings[i].words));
        user_expect_at_least(user_done(s, settings[i].text), 1);
        user_tool *json =
            user_run(b.host, "lumctl %s --json", settings[i].words);
        user_expect_status(json, DONE);
        expect_value(json, "command", settings[i].text);
        expect_value(json, "done", "true");
        expect_value(json, "refused", "");
    }
    user_expect_status(user_run(b.host, "lumctl send '51p 52g'"), DONE);
    user_expect_at_least(user_done(s, "52g"), 1);
}

STORY(a_raw_tlv_shows_what_came_back, "a raw TLV shows what came back")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *json = user_run(b.host, "lumctl tlv 1:3530 9:dead --json");
    user_expect_status(json, DONE);
    user_expect_has(user_value(user_out(json), "debug"), "50");
    user_tool *plain = user_run(b.host, "lumctl tlv 1:3530");
    user_expect_status(plain, DONE);
    user_expect_has(user_out(plain), "it says: ");
}

STORY(time_is_the_sensors, "time is the sensor's, with its error bound")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --clock 4200000000");
    user_tool *json = user_run(b.host, "lumctl time --json");
    user_expect_status(json, DONE);
    expect_value(json, "exchanges", "8");
    user_expect(user_number(user_out(json), "error_ns") >=
                user_number(user_out(json), "round_trip_min_ms") * 5e5 - 1000);
    user_expect(user_number(user_out(json), "clock_us") > 4199999999.0);
    user_tool *watch = user_run(b.host, "lumctl time --watch --duration 2.5");
    user_expect_status(watch, DONE);
    user_expect_like(user_out(watch),
                     "Z  clock 1:1[0-9]:[0-9][0-9]\\.[0-9]{6}  offset "
                     "[0-9]+\\.[0-9]{6} s \\+-[0-9.]+ [mun]s  round trip"
                     "[^\n]*\n$");
    user_tool *lines =
        user_run(b.host, "lumctl time --watch --duration 1.5 --json");
    user_expect_status(lines, DONE);
    user_expect_like(user_out(lines), "\"resets\": 0[,}][^\n]*\n$");
    user_tool *plain = user_run(b.host, "lumctl time");
    user_expect_status(plain, DONE);
    user_expect_has(user_out(plain), "+-");
}

STORY(the_laser_goes_on_and_off,
      "the laser goes on and off, and each is seen before it is said")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *alone = user_run(b.host, "lumctl laser on");
    user_expect_status(alone, FAILED);
    user_expect_has(user_err(alone), "heartbeat");
    user_expect(!user_laser_is_on(s));
    user_tool *session = hold(&b);
    user_tool *on = user_run(b.host, "lumctl laser on");
    user_expect_status(on, DONE);
    user_expect_has(user_out(on), "laser up");
    user_expect_has(user_err(on), "3 s after the last heartbeat");
    user_expect(user_laser_is_on(s));
    user_tool *again = user_run(b.host, "lumctl laser on --json");
    user_expect_status(again, DONE);
    expect_value(again, "laser", "up");
    user_tool *status = user_run(b.host, "lumctl status --json");
    user_expect_status(status, DONE);
    expect_value(status, "laser", "up");
    user_until(user_has(user_out(session), "laser up: TLV_CMD_ON"));
    user_tool *off = user_run(b.host, "lumctl laser off --json");
    user_expect_status(off, DONE);
    expect_value(off, "done", "true");
    user_expect(!user_laser_is_on(s));
    user_expect_status(user_run(b.host, "lumctl laser off"), DONE);
    user_expect_end(session, SIGINT, DONE);
}

STORY(one_program_is_the_session,
      "one program is the session, and a second is told so")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *first = hold(&b);
    user_tool *second = user_run(b.host, "lumctl heartbeat --duration 1");
    user_expect_status(second, FAILED);
    user_expect_has(user_err(second), "lumctl");
    user_expect_has(user_err(second), user_format("%ld", first->process->pid));
    user_expect_status(user_run(b.host, "lumctl power 40"), DONE);
    user_expect_end(first, SIGINT, DONE);
}

STORY(heartbeats_come_at_the_rate,
      "heartbeats come at the rate that was asked for, and for the duration")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *beat =
        user_run(b.host, "lumctl heartbeat --rate 10 --duration 2 --json");
    user_expect_status(beat, DONE);
    const char *last =
        strrchr(user_format("\n%.*s", (int)strlen(user_out(beat)) - 1,
                            user_out(beat)),
                '\n') +
        1;
    const double count = user_number(last, "heartbeats");
    user_until(user_events(s, "heartbeat") == (size_t)count);
    user_expect_at_least(count, 20);
    user_expect_at_most(count, 21);
    user_expect(user_number(last, "packets") > 0);
}

STORY(a_watch_logs_changes, "a watch logs changes alone, with their time")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *watch = user_start(b.host, "lumctl status --watch");
    user_until(*user_out(watch) != '\0' && user_events(s, "tlv") >= 4);
    (void)hold(&b);
    user_expect_status(user_run(b.host, "lumctl laser on"), DONE);
    user_until(user_has(user_out(watch), "laser up"));
    user_expect_end(watch, SIGINT, DONE);
    user_expect_like(user_out(watch),
                     "^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}"
                     "\\.[0-9]{3}Z 10\\.42\\.0\\.37: laser down");
    user_expect(tells_changes_alone(user_out(watch)));
}

STORY(a_watch_ends_with_4_on_a_hazard,
      "a watch ends with 4 on a hazard, by a signal and by its duration")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --fault fan@0");
    (void)ask_until(b.host, "lumctl status", "FAN");
    user_tool *watch = user_start(b.host, "lumctl status --watch --json");
    user_until(user_has(user_out(watch), "\n"));
    user_expect_end(watch, SIGINT, HAZARD);
    user_expect_has(user_value(user_out(watch), "hazards"), "FAN_PWM_BAD");
    user_expect_status(user_run(b.host, "lumctl status --watch --duration 3"),
                       HAZARD);
}

STORY(a_reader_that_leaves_ends_a_watch,
      "a reader that leaves ends a watch quietly")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --fault fan@3");
    world_file *end = NULL;
    world_reader *reader = world_reader_new("reader", &end);
    user_tool *watch = user_start_with(b.host, (user_with){.output = end},
                                       "lumctl time --watch");
    user_until(user_has(user_taken(reader), "clock"));
    world_reader_close(reader);
    user_expect_status(watch, DONE);
    user_expect_same(user_err(watch), "");
}

#define PICTURE "\033[H\033[J"
#define RED     "\033[1;31m"

STORY(a_terminal_gets_colour,
      "a terminal gets colour, and a picture that is redrawn")
{
    static const char *const plain[] = {"TERM=xterm", "NO_COLOR=1", NULL};
    static const char *const xterm[] = {"TERM=xterm", NULL};
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2 --fault fan@0");
    (void)ask_until(b.host, "lumctl status", "FAN");
    world_terminal *coloured = world_terminal_new("xterm");
    user_expect_status(
        user_start_with(b.host,
                        (user_with){.terminal = coloured, .environment = xterm},
                        "lumctl status"),
        HAZARD);
    user_expect_has(user_shown(coloured), RED);
    world_terminal *sober = world_terminal_new("xterm");
    user_expect_status(
        user_start_with(b.host,
                        (user_with){.terminal = sober, .environment = plain},
                        "lumctl status"),
        HAZARD);
    user_expect_lacks(user_shown(sober), RED);
    user_expect_has(user_shown(sober), "FAN_PWM_BAD");
    world_terminal *redrawn = world_terminal_new("xterm");
    user_tool *watch = user_start_with(
        b.host, (user_with){.terminal = redrawn, .environment = xterm},
        "lumctl status --watch");
    user_until(user_count(user_shown(redrawn), PICTURE) >= 2);
    user_expect_end(watch, SIGINT, HAZARD);
}
