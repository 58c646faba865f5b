/* A sweep, step by step; what chance may do to it is in sweep_seeds.c. */
#include "help.h"
#include "sweep_judge.h"

#include <string.h>

#define PLAN                                                                   \
    "version: 1\nsteps:\n"                                                     \
    "  - lines: 64\n    power: 40\n    record: 1\n"                            \
    "  - power: 50\n"                                                          \
    "  - holdoff: 200\n    record: {frames: 2}\n"                              \
    "  - yscan: {shape: uniform, min_deg: -10, max_deg: 2}\n    record: 1\n"
#define SWEEP "lumctl sweep plan.yaml -o s"

/* As sweep_letters: f, y, p, g, b, h, G, B, and a table. */
static const sweep_plan plan = {
    4,
    {{{"1f", "", "40p", "", "", "", "", "", ""}, true},
     {{"1f", "", "50p", "", "", "", "", "", ""}, false},
     {{"1f", "", "50p", "", "", "200h", "", "", ""}, true},
     {{"1f", "", "50p", "", "", "200h", "", "", "T"}, true}}};

typedef struct scene {
    user_bench b;
    user_sensor *s;
    user_tool *sweep;
} scene;

static user_tool *start(const scene *now, const char *options)
{
    sweep_judge_start();
    return user_start(now->b.host, SWEEP "%s", options);
}

static scene begin(const char *faults, const char *options)
{
    scene now = {.b = user_bench_new()};
    user_write_file(now.b.host, "plan.yaml", PLAN);
    sweep_judge_begin(&now.b, "s", &plan, user_has(options, "--laser"));
    now.s = user_sensor_start(now.b.sensor, "--rate 2%s", faults);
    sweep_judge_sensor(now.s);
    now.sweep = start(&now, options);
    return now;
}

static const char *manifest(const scene *now)
{
    return user_file(now->b.host, "s/manifest.json");
}

static void until_recording(const scene *now, unsigned step)
{
    user_until(user_has(user_out(now->sweep),
                        user_format("step %u of 4: done", step - 1)) ||
               step == 1);
    const size_t beats = user_events(now->s, "heartbeat");
    user_until(user_events(now->s, "heartbeat") > beats + 2);
}

/* It ends so, and what is missing is done by a second run. */
static void expect_end(scene *now, int status, const char *why)
{
    user_expect_status(now->sweep, status);
    user_expect_has(user_err(now->sweep), "not all steps are done");
    user_expect_has(user_err(now->sweep), "--continue does what is missing");
    user_expect_has(user_value(manifest(now), "why"), why);
    sweep_judge_run(now->sweep, false);
    user_expect(sweep_judge_done() < plan.count);
}

static void expect_rest(scene *now, const char *options)
{
    now->sweep = start(now, user_format("%s --continue", options));
    user_expect_status(now->sweep, DONE);
    sweep_judge_run(now->sweep, false);
    user_expect_equal(sweep_judge_done(), plan.count);
}

STORY(a_whole_sweep, "a sweep sets and records each step of its plan")
{
    scene now = begin("", " --laser");
    user_expect_status(now.sweep, DONE);
    sweep_judge_run(now.sweep, false);
    user_expect_equal(sweep_judge_done(), plan.count);
    user_expect_equal(user_laser_rises(now.s), 1);
    sweep_judge_dark(world_now());
    const char *json = manifest(&now);
    user_expect_same(user_value(json, "steps.3.settings.power"), "50");
    user_expect_same(user_value(json, "steps.3.settings.holdoff"), "200");
    user_expect_same(user_value(json, "exit_status"), "0");
    user_expect(user_value(json, "steps.1.file") == NULL);
    user_expect_equal(user_number(json, "steps.2.lines_missing"), 0);
    user_tool *look = user_run(now.b.host, "lumdump s/step-0003.pcapng --json");
    user_expect_status(look, DONE);
    user_expect_equal(user_number(user_out(look), "frames"), 2);
}

STORY(a_sweep_that_is_there, "a sweep does not begin again by itself, and "
                             "--continue of a whole one does nothing")
{
    scene now = begin("", "");
    user_expect_status(now.sweep, DONE);
    const size_t heard = user_done(now.s, "40p");
    user_tool *again = start(&now, "");
    user_expect_status(again, BAD);
    user_expect_has(user_err(again), "--continue");
    const size_t streams = user_events(now.s, "stream");
    expect_rest(&now, "");
    user_expect_equal(user_events(now.s, "stream"), streams);
    user_expect_equal(user_done(now.s, "40p"), heard);
}

STORY(a_sweep_without_an_answer,
      "a sweep of a sensor that is not there says so, and is continued once "
      "it is")
{
    scene now = {.b = user_bench_new()};
    user_write_file(now.b.host, "plan.yaml", PLAN);
    sweep_judge_begin(&now.b, "s", &plan, false);
    now.sweep = start(&now, "");
    user_expect_status(now.sweep, NO_ANSWER);
    user_expect_has(user_value(manifest(&now), "why"), "answer");
    sweep_judge_run(now.sweep, false);
    now.s = user_sensor_start(now.b.sensor, "--rate 2");
    sweep_judge_sensor(now.s);
    expect_rest(&now, "");
}

STORY(a_setting_that_is_refused,
      "a sweep ends at the setting that its sensor refuses, and names it")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_write_file(b.host, "plan.yaml",
                    "version: 1\nsteps:\n"
                    "  - power: 40\n"
                    "  - lines: 64\n    record: 0.5\n"
                    "  - yscan: {shape: uniform, min_deg: -9, max_deg: 2}\n"
                    "    lines: 640\n"
                    "  - power: 50\n");
    user_tool *sweep = user_run(b.host, SWEEP);
    const int status = user_wait(sweep);
    const char *json = user_file(b.host, "s/manifest.json");
    user_expect_same(user_value(json, "steps.1.done"), "true");
    if (status != DONE) {
        user_expect_equal(status, FAILED);
        user_expect_has(user_value(json, "steps.2.why"), "refused");
        user_expect_has(user_err(sweep), "refused");
        user_expect_same(user_value(json, "steps.3.done"), "false");
    }
}

STORY(a_hazard_in_a_sweep,
      "a hazard ends a sweep with 4 and the laser off; its step is not done")
{
    scene now = begin(" --fault fan@USR1-USR2", " --laser");
    until_recording(&now, (unsigned)user_any(1, 4) == 1 ? 1 : 3);
    user_pause_between_ms(0, 800);
    user_signal(now.s->tool, SIGUSR1);
    expect_end(&now, HAZARD, "FAN_PWM_BAD");
    sweep_judge_dark(world_now());
    user_signal(now.s->tool, SIGUSR2);
    user_until(user_events(now.s, "fault") == 2);
    user_pause_ms(3500);
    expect_rest(&now, " --laser");
}

STORY(a_reboot_in_a_sweep,
      "no step is done that a restart of its sensor was in")
{
    scene now = begin(" --fault reboot@USR1", "");
    user_pause_between_ms(0, 4500);
    user_signal(now.s->tool, SIGUSR1);
    const int status = user_wait(now.sweep);
    sweep_judge_run(now.sweep, false);
    user_expect(status == DONE || sweep_judge_done() < plan.count);
    expect_rest(&now, "");
}

STORY(a_second_owner_on_a_sweeps_host,
      "a second owner on the host of a sweep is refused, and harms nothing")
{
    scene now = begin("", "");
    until_recording(&now, 1);
    user_tool *second = user_run(now.b.host, "lumctl heartbeat --duration 1");
    user_expect_status(second, FAILED);
    user_expect_has(user_err(second), "has the session");
    user_expect_status(now.sweep, DONE);
    sweep_judge_run(now.sweep, false);
}

STORY(a_second_sweep_of_a_folder,
      "a second sweep of a folder waits a moment for the first, or is refused")
{
    const bool hangs = user_any(0, 1) == 1;
    scene now = begin("", "");
    until_recording(&now, 1);
    if (hangs) {
        user_signal(now.sweep, SIGSTOP);
    }
    user_tool *second = user_run(now.b.host, SWEEP " --continue");
    user_expect_status(second, hangs ? FAILED : DONE);
    user_expect_has(user_err(second), hangs ? "another run is writing it"
                                            : "steps were done before");
    if (hangs) {
        user_signal(now.sweep, SIGKILL);
    }
    user_expect_status(now.sweep, hangs ? -SIGKILL : DONE);
    sweep_judge_run(now.sweep, false);
}

STORY(another_program_in_a_sweep,
      "what another program of the host sets meanwhile ends a sweep")
{
    static const char *const words[] = {"power 0", "lines 64", "power 50"};
    const char *word = words[user_any(0, 2)];
    scene now = begin("", "");
    until_recording(&now, 3);
    user_expect_status(user_run(now.b.host, "lumctl %s", word), DONE);
    user_expect_status(now.sweep, FAILED);
    sweep_judge_run(now.sweep, false);
    expect_rest(&now, "");
}

STORY(a_full_disk_in_a_sweep,
      "a full disk ends a sweep; no file and no manifest is cut short")
{
    scene now = begin("", " --laser");
    user_pause_between_ms(100, 3000);
    world_disk_fill(world_disk_of(now.b.host), (uint64_t)user_any(0, 300000));
    user_expect_status(now.sweep, FAILED);
    sweep_judge_run(now.sweep, true);
    sweep_judge_dark(world_now());
    world_disk_heal(world_disk_of(now.b.host));
    user_pause_ms(1000);
    expect_rest(&now, " --laser");
}

STORY(a_killed_sweep,
      "a killed sweep leaves the laser off within 3.2 s, and is continued")
{
    static const int signals[] = {SIGKILL, SIGTERM, SIGINT, SIGHUP};
    scene now = begin("", " --laser");
    user_pause_between_ms(0, 6000);
    const int64_t killed_ns = world_now();
    const bool has_ended = user_ended(now.sweep);
    if (!has_ended) {
        user_signal(now.sweep, signals[user_any(0, 3)]);
    }
    sweep_judge_run(now.sweep, false);
    sweep_judge_dark(has_ended ? killed_ns : now.sweep->process->ended_ns);
    expect_rest(&now, " --laser");
}

STORY(a_sweep_and_a_slow_disk,
      "a disk that stands still during a recording keeps no heartbeat back")
{
    scene now = begin("", " --laser");
    user_until(user_laser_is_on(now.s));
    user_pause_ms(300);
    world_disk_stall(world_disk_of(now.b.host), WORLD_DISK_ALL,
                     world_now() + user_any(200, 900) * WORLD_MS);
    user_expect_status(now.sweep, DONE);
    for (size_t i = 1; i < user_events(now.s, "heartbeat"); i++) {
        user_expect_at_most(user_event_at(now.s, "heartbeat", i)->t_ns -
                                user_event_at(now.s, "heartbeat", i - 1)->t_ns,
                            WORLD_S);
    }
    sweep_judge_run(now.sweep, true);
}

STORY(a_sweep_of_a_sensor_that_answers_late,
      "a sensor that takes its time to answer is asked for its laser once")
{
    scene now = begin(" --answer-delay 300", " --laser");
    user_expect_status(now.sweep, DONE);
    sweep_judge_run(now.sweep, false);
    user_expect_equal(user_heard(now.s, "u"), 1);
}

/* --- examples/bench/thresholds.sh --- */

static const sweep_plan thresholds = {
    8,
    {{{"1f", "", "40p", "20g", "20b", "", "", "", ""}, true},
     {{"1f", "", "40p", "40g", "40b", "", "", "", ""}, true},
     {{"1f", "", "40p", "60g", "60b", "", "", "", ""}, true},
     {{"1f", "", "40p", "80g", "80b", "", "", "", ""}, true},
     {{"1f", "", "80p", "20g", "20b", "", "", "", ""}, true},
     {{"1f", "", "80p", "40g", "40b", "", "", "", ""}, true},
     {{"1f", "", "80p", "60g", "60b", "", "", "", ""}, true},
     {{"1f", "", "80p", "80g", "80b", "", "", "", ""}, true}}};

static void write_thresholds(world_host *host)
{
    const char *text = "steps:\n";
    for (unsigned power = 40; power <= 80; power += 40) {
        for (unsigned t = 20; t <= 80; t += 20) {
            text = user_format("%s  - {lines: 64, power: %u, threshold: "
                               "{green: %u, blue: %u}, settle: 1, record: 5}\n",
                               text, power, t, t);
        }
    }
    user_write_file(host, "plan.yaml", text);
}

/* Its commands. A run that is killed, or ended by a hazard, is followed by
 * another. */
STORY(thresholds_at_two_powers,
      "a bench waits, sweeps thresholds, makes a cloud of each step, and after "
      "each mishap does what is missing")
{
    scene now = {.b = user_bench_new()};
    const char *options = " --laser --continue";
    int status = -1;
    user_limit(600, 60000000);
    write_thresholds(now.b.host);
    sweep_judge_begin(&now.b, "s", &thresholds, true);
    user_tool *wait = user_start(now.b.host, "lumctl wait clear --for 60");
    user_pause_between_ms(0, 10000);
    now.s = user_sensor_start(now.b.sensor, "--rate 2 --fault fan@USR1-USR2");
    sweep_judge_sensor(now.s);
    user_expect_status(wait, DONE);
    for (unsigned run = 0; status != DONE; run++) {
        now.sweep = start(&now, options);
        user_pause_between_ms(0, run < 2 ? 40000 : 1);
        if (run == 0) {
            user_signal(now.s->tool, SIGUSR1);
            status = user_wait(now.sweep);
            user_expect(status == HAZARD || status == DONE);
            user_signal(now.s->tool, SIGUSR2);
            user_expect_status(user_run(now.b.host, "lumctl wait clear"), DONE);
        } else if (run == 1) {
            user_signal(now.sweep, SIGKILL);
        }
        status = user_wait(now.sweep);
        sweep_judge_run(now.sweep, false);
        sweep_judge_dark(now.sweep->process->ended_ns);
    }
    user_expect_equal(sweep_judge_done(), thresholds.count);
    for (unsigned i = 1; i <= thresholds.count; i++) {
        user_expect_status(user_run(now.b.host,
                                    "lumdump -q s/step-%04u.pcapng -o "
                                    "step-%04u.ply",
                                    i, i),
                           DONE);
    }
    user_expect(!user_laser_is_on(now.s));
}
