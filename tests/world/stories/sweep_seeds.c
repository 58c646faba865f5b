/* A sweep that anything may befall: its plan, what happens to it and when, and
 * how often it is continued, are the seed's. */
#include "help.h"
#include "sweep_judge.h"

#include <stdio.h>
#include <string.h>

#define FOLDER      "s"
#define ACTIONS     4
#define OWNERS      16
#define RUNS        3  /* that are disturbed */
#define FAULTS_S    36 /* after its start a sensor has none any more */
#define SENSOR_RATE "--rate 2"

typedef enum action_kind {
    CUT,
    LOSS,
    FULL,
    STALL,
    BROKEN,
    FAR_OWNER,
    NEAR_OWNER,
    OTHER_SETS,
    OTHER_DARK,
    MOVE,
    POWER,
    SIGNAL,
    SIGNAL_AT_CALL,
    ACTION_KINDS
} action_kind;

typedef struct action {
    action_kind kind;
    int64_t at_ms, lasts_ms;
} action;

static struct {
    user_bench b;
    world_host *other;
    user_sensor *sensor;
    sweep_plan plan;
    user_tool *owners[OWNERS]; /* others that may keep a laser on */
    unsigned owner_count;
    bool had_disk_fault;
    int64_t faults_end_ns; /* those of the sensor */
} now;

static bool one_in(int64_t n)
{
    return user_any(1, n) == 1;
}

/* --- The plan --- */

static void set(sweep_plan_step *step, char letter, const char *text)
{
    const char *at = strchr(sweep_letters, letter);
    (void)snprintf(step->in_force[at - sweep_letters], sizeof step->in_force[0],
                   "%s", text);
}

/* A line of the plan's YAML, behind what a step's begin has. */
static const char *draw_scan(sweep_plan_step *step, bool is_first)
{
    const char *text = "";
    if (is_first || one_in(5)) {
        set(step, 'f', "1f");
        set(step, 'T', "");
        text = "    lines: 64\n";
    }
    if (one_in(5)) {
        const int64_t degrees = user_any(11, 30);
        set(step, 'y', user_format("%dy", (int)degrees));
        set(step, 'T', "");
        return user_format("%s    yscan: %d\n", text, (int)degrees);
    }
    if (one_in(5)) {
        set(step, 'y', "");
        set(step, 'T', "T");
        return user_format("%s    yscan: {shape: gaussian, center_deg: -2, "
                           "sigma_deg: %d}\n",
                           text, (int)user_any(2, 6));
    }
    return text;
}

static const char *draw_settings(sweep_plan_step *step, bool is_first)
{
    const char *text = draw_scan(step, is_first);
    if (one_in(2)) {
        const int64_t n = user_any(1, 100);
        set(step, 'p', user_format("%dp", (int)n));
        text = user_format("%s    power: %d\n", text, (int)n);
    }
    if (one_in(3)) {
        const int64_t n = user_any(0, 100);
        set(step, 'g', user_format("%dg", (int)n));
        text = user_format("%s    threshold: {green: %d}\n", text, (int)n);
    }
    if (one_in(4)) {
        const int64_t n = user_any(15, 25) * 10;
        set(step, 'h', user_format("%dh", (int)n));
        text = user_format("%s    holdoff: %d\n", text, (int)n);
    }
    return text;
}

static const char *draw_record(sweep_plan_step *step, bool has_settings)
{
    const char *settle =
        one_in(3) ? user_format("    settle: 0.%d\n", (int)user_any(1, 9)) : "";
    step->records = !has_settings || !one_in(4);
    if (!step->records) {
        return settle;
    }
    return one_in(2) ? user_format("%s    record: {frames: %d}\n", settle,
                                   (int)user_any(1, 3))
                     : user_format("%s    record: %d.%d\n", settle,
                                   (int)user_any(0, 1), (int)user_any(1, 9));
}

/* "    power: 40" becomes "  - power: 40". */
static const char *make_item(const char *lines)
{
    return user_format("  - %s", lines + 4);
}

static void draw_plan(void)
{
    const char *yaml = "version: 1\nsteps:\n";
    now.plan.count = (unsigned)user_any(2, 6);
    for (unsigned i = 0; i < now.plan.count; i++) {
        sweep_plan_step *step = &now.plan.steps[i];
        if (i > 0) {
            *step = now.plan.steps[i - 1];
        }
        const char *settings = draw_settings(step, i == 0);
        const char *record = draw_record(step, *settings != '\0');
        yaml = user_format("%s%s", yaml,
                           make_item(user_format("%s%s", settings, record)));
    }
    user_write_file(now.b.host, "plan.yaml", yaml);
}

/* --- What befalls it --- */

static void mend_wire(void *argument)
{
    (void)argument;
    user_fault(now.b.eth0, (user_faults){0});
    user_cable(now.b.eth0, true);
}

static void mend_disk(void *argument)
{
    (void)argument;
    world_disk_heal(world_disk_of(now.b.host));
}

static void sensor_on(void *argument)
{
    (void)argument;
    if (user_ended(now.sensor->tool)) {
        now.sensor = user_sensor_power_on(now.b.sensor, SENSOR_RATE);
        sweep_judge_sensor(now.sensor);
    }
}

/* Where it is now. */
static const char *address_now(void)
{
    const char *address = now.sensor->address;
    for (const user_event *e = now.sensor->first; e != NULL; e = e->next) {
        if (strcmp(e->kind, "move") == 0 &&
            user_has(e->line, "\"done\": true")) {
            address = user_value(e->line, "address");
        }
    }
    return address;
}

static void add_owner(user_tool *tool)
{
    if (now.owner_count < OWNERS) {
        now.owners[now.owner_count++] = tool;
    }
}

static void disturb_disk(const action *a)
{
    world_disk *disk = world_disk_of(now.b.host);
    now.had_disk_fault = true;
    if (a->kind == FULL) {
        world_disk_fill(disk, (uint64_t)user_any(0, 2000000));
    } else if (a->kind == STALL) {
        world_disk_stall(disk, WORLD_DISK_ALL,
                         world_now() + a->lasts_ms * WORLD_MS);
    } else {
        static const unsigned calls[] = {WORLD_DISK_SYNC, WORLD_DISK_RENAME,
                                         WORLD_DISK_OPEN, WORLD_DISK_WRITE};
        world_disk_fail(disk, calls[user_any(0, 3)], 0.5, 5);
    }
    (void)world_at(world_now() + a->lasts_ms * WORLD_MS, mend_disk, NULL);
}

static void disturb_wire(const action *a)
{
    if (a->kind == CUT) {
        user_cable(now.b.eth0, false);
    } else {
        user_fault(now.b.eth0,
                   (user_faults){.lose = (double)user_any(1, 60) / 100.0});
    }
    (void)world_at(world_now() + a->lasts_ms * WORLD_MS, mend_wire, NULL);
}

static int any_signal(void)
{
    static const int signals[] = {SIGKILL, SIGKILL, SIGTERM, SIGINT};
    return signals[user_any(0, 3)];
}

static void aim_signal(user_tool *tool)
{
    static const char *const calls[] = {"rename", "fsync",    "open",
                                        "write",  "sendmmsg", "close"};
    const char *call = calls[user_any(0, 5)];
    user_signal_at(
        tool, call,
        (unsigned)user_any(1, strcmp(call, "sendmmsg") == 0 ? 80 : 12),
        any_signal());
}

/* Other programs. */
static void intrude(const action *a)
{
    const char *address = address_now();
    if (a->kind == FAR_OWNER || a->kind == NEAR_OWNER) {
        add_owner(user_start(a->kind == FAR_OWNER ? now.other : now.b.host,
                             "lumctl --host %s heartbeat --duration %d",
                             address, (int)user_any(1, 4)));
    } else if (a->kind == OTHER_SETS) {
        (void)user_start(now.b.host, "lumctl --host %s %s", address,
                         one_in(2) ? "power 0" : "lines 64");
    } else if (a->kind == OTHER_DARK) {
        (void)user_start(one_in(2) ? now.b.host : now.other,
                         "lumctl --host %s send d", address);
    } else if (a->kind == MOVE) {
        (void)user_start(now.other, "lumctl --host %s set-ip 10.42.0.%d",
                         address, (int)user_any(38, 40));
    }
}

static void act(const action *a, user_tool *tool)
{
    if (a->kind == CUT || a->kind == LOSS) {
        disturb_wire(a);
    } else if (a->kind == FULL || a->kind == STALL || a->kind == BROKEN) {
        disturb_disk(a);
    } else if (a->kind == POWER && !user_ended(now.sensor->tool)) {
        user_signal(now.sensor->tool, SIGKILL);
        (void)world_at(world_now() + a->lasts_ms * WORLD_MS, sensor_on, NULL);
    } else if (a->kind == SIGNAL) {
        user_signal(tool, any_signal());
    } else {
        intrude(a);
    }
}

static unsigned draw_actions(action out[ACTIONS])
{
    const unsigned count = (unsigned)user_any(0, ACTIONS);
    for (unsigned i = 0; i < count; i++) {
        const action a = {(action_kind)user_any(0, ACTION_KINDS - 1),
                          user_any(100, 9000),
                          user_any(100, one_in(4) ? 9000 : 2000)};
        unsigned k = i;
        for (; k > 0 && out[k - 1].at_ms > a.at_ms; k--) {
            out[k] = out[k - 1];
        }
        out[k] = a;
    }
    return count;
}

/* --- Runs --- */

static user_tool *start_sweep(bool has_laser, unsigned run)
{
    sweep_judge_start();
    return user_start(now.b.host,
                      "lumctl --host %s sweep plan.yaml -o " FOLDER "%s%s",
                      address_now(), has_laser ? " --laser" : "",
                      run > 0 ? " --continue" : "");
}

static void disturb(user_tool *tool)
{
    action actions[ACTIONS];
    const unsigned count = draw_actions(actions);
    const int64_t begin_ns = world_now();
    for (unsigned i = 0; i < count; i++) {
        if (actions[i].kind == SIGNAL_AT_CALL) {
            aim_signal(tool);
        }
    }
    for (unsigned i = 0; i < count; i++) {
        while (!user_ended(tool) &&
               world_now() < begin_ns + actions[i].at_ms * WORLD_MS) {
            user_pause_ms(20);
        }
        if (!user_ended(tool)) {
            act(&actions[i], tool);
        }
    }
}

/* The laser is off 3.2 s after the last program that may keep it on. */
static void expect_dark(user_tool *tool)
{
    int64_t since_ns = tool->process->ended_ns;
    for (unsigned i = 0; i < now.owner_count; i++) {
        (void)user_wait(now.owners[i]);
        const int64_t ended_ns = now.owners[i]->process->ended_ns;
        since_ns = ended_ns > since_ns ? ended_ns : since_ns;
    }
    sweep_judge_dark(since_ns);
}

static void run_disturbed(bool has_laser, unsigned run)
{
    now.had_disk_fault = false;
    user_tool *tool = start_sweep(has_laser, run);
    disturb(tool);
    (void)user_wait(tool);
    sweep_judge_run(tool, now.had_disk_fault);
    mend_disk(NULL);
    expect_dark(tool);
    if (one_in(2)) {
        user_pause_between_ms(0, 3000);
    }
}

/* Steps are continued at the address where they were begun. */
static void move_back(void)
{
    const char *begun = sweep_judge_address();
    const char *present = address_now();
    if (begun != NULL && sweep_judge_done() > 0 &&
        strcmp(begun, present) != 0) {
        user_expect_status(
            user_run(now.b.host, "lumctl --host %s set-ip %s", present, begun),
            DONE);
    }
}

/* All is well again: what is missing is done. */
static void run_in_calm(bool has_laser, unsigned run, bool has_faults)
{
    user_pause_ms(10000);
    mend_wire(NULL);
    mend_disk(NULL);
    sensor_on(NULL);
    while (has_faults && world_now() < now.faults_end_ns) {
        user_pause_ms(1000);
    }
    user_expect_status(
        user_run(now.b.host, "lumctl --host %s wait --for 20", address_now()),
        DONE);
    move_back();
    user_tool *tool = start_sweep(has_laser, run);
    user_expect_status(tool, DONE);
    sweep_judge_run(tool, false);
    user_expect_equal(sweep_judge_done(), now.plan.count);
    expect_dark(tool);
}

static const char *draw_sensor_faults(void)
{
    static const char *const hazards[] = {"fan", "interlock", "board",
                                          "silence"};
    const char *text = "";
    if (one_in(3)) {
        text = user_format(" --fault reboot@%d.%03d", (int)user_any(1, 30),
                           (int)user_any(0, 999));
    }
    if (one_in(3)) {
        const int64_t from = user_any(1000, 30000);
        const int64_t to = from + user_any(100, 5000);
        text = user_format("%s --fault %s@%.3f-%.3f", text,
                           hazards[user_any(0, 3)], (double)from / 1e3,
                           (double)to / 1e3);
    }
    return text;
}

STORY(a_sweep_and_any_fault,
      "whatever befalls a sweep, its manifest is true, and what is missing is "
      "done when it is continued")
{
    memset(&now, 0, sizeof now);
    const bool has_laser = !one_in(3);
    user_limit(1200, 60000000);
    now.b = user_bench_new();
    now.other = user_host_new("other");
    (void)user_interface(now.other, "eth0", now.b.wire, "10.42.0.2/24");
    draw_plan();
    const char *faults = draw_sensor_faults();
    sweep_judge_begin(&now.b, FOLDER, &now.plan, has_laser);
    now.sensor = user_sensor_start(now.b.sensor, SENSOR_RATE "%s", faults);
    sweep_judge_sensor(now.sensor);
    now.faults_end_ns = world_now() + FAULTS_S * WORLD_S;
    const unsigned runs = (unsigned)user_any(1, RUNS);
    for (unsigned i = 0; i < runs; i++) {
        run_disturbed(has_laser, i);
    }
    run_in_calm(has_laser, runs, *faults != '\0');
}
