/* Tells a script in a world. */
#include "../kernel/disk.h"
#include "../kernel/net.h"
#include "../kernel/pipe.h"
#include "../kernel/task.h"
#include "../kernel/trace.h"
#include "../witness.h"
#include "capture.h"
#include "script.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#define MS WORLD_MS

/* After the last step: the longest that a tool may take to its end. */
#define ENDING_MS INT64_C(90000)

/* What a session needs besides its own. */
#define LIMIT_S     (4 * 3600)
#define LIMIT_CALLS UINT64_C(40000000)

#define CALLS 32 /* that steps wait for */

/* A step, or its end. */
struct turn {
    int64_t at_ms;
    const script_step *step;
    bool is_end;
};

static struct {
    const struct script *script;
    user_bench bench;
    world_host *other; /* 10.42.0.2 */
    user_sensor *sensor;
    int64_t sensor_ms; /* when it was switched on */
    user_tool *tools[SCRIPT_TOOLS];
    world_writer *inputs[SCRIPT_TOOLS];
    world_reader *readers[SCRIPT_TOOLS];
    struct turn turns[2 * SCRIPT_STEPS];
    unsigned turn_count;
    struct aim {
        const script_step *step;
        user_tool *tool;
    } aims[SCRIPT_STEPS];
    unsigned aim_count;
    unsigned disk_faults; /* now */
    bool is_over;
} now;

/* Of the last telling: longer than `now`, where what is told is gone. */
static char processes[SCRIPT_TOOLS][32];

/* --- Tools --- */

static user_tool *tool_of(const script_step *step)
{
    return step->tool < SCRIPT_TOOLS ? now.tools[step->tool] : NULL;
}

const char *script_process(unsigned tool)
{
    return tool < SCRIPT_TOOLS ? processes[tool] : "";
}

static bool is_of_bench(const user_tool *tool)
{
    return tool->process->host == now.bench.host;
}

/* The trace has their processes. */
static void name_tool(unsigned number, const user_tool *tool)
{
    (void)snprintf(processes[number], sizeof processes[number], "%s[%ld]",
                   tool->process->name, tool->process->pid);
    WORLD_TRACE("[%u] = %s", number, processes[number]);
}

/* To a reader that takes little, or nothing. */
static world_file *slow_pipe(const script_step *step)
{
    world_file *end = NULL;
    now.readers[step->tool] = world_reader_new("output", &end);
    world_reader_pace(now.readers[step->tool], step->value);
    return end;
}

static void run(const script_step *step)
{
    static const char *const environment[] = {"HOME=/home", NULL};
    user_with with = {.environment = environment,
                      .ignores_int = step->ignores_int};
    if (step->tool >= SCRIPT_TOOLS) {
        return;
    }
    if (strstr(step->text, " shell") != NULL) {
        now.inputs[step->tool] = world_writer_new(&with.input);
    }
    if (step->is_stalled) {
        with.output = slow_pipe(step);
    }
    user_tool *tool = user_start_with(step->is_far ? now.other : now.bench.host,
                                      with, "%s", step->text);
    now.tools[step->tool] = tool;
    name_tool(step->tool, tool);
    if (step->is_wrong) {
        witness_wrong(tool);
    }
    if ((now.disk_faults > 0 && is_of_bench(tool)) || step->is_stalled) {
        witness_stalls(tool);
    }
}

static void type(const script_step *step)
{
    world_writer *input =
        step->tool < SCRIPT_TOOLS ? now.inputs[step->tool] : NULL;
    if (input == NULL) {
        return;
    }
    if (step->text[0] == '\0') {
        world_writer_close(input);
        now.inputs[step->tool] = NULL;
        return;
    }
    witness_typed(now.tools[step->tool], step->text);
    world_writer_say(input, step->text);
    world_writer_say(input, "\n");
}

/* Only to what runs: a number may be another's later. */
static void signal_to(const script_step *step, int number)
{
    user_tool *tool = tool_of(step);
    if (tool != NULL && !user_ended(tool)) {
        user_signal(tool, number);
    }
}

/* --- The network --- */

static void wire(const script_step *step, bool is_end)
{
    const user_faults good = {0};
    const user_faults faults = is_end ? good : step->faults;
    if (step->way != SCRIPT_IN) {
        user_fault_out(now.bench.eth0, faults);
    }
    if (step->way != SCRIPT_OUT) {
        user_fault_in(now.bench.eth0, faults);
    }
}

static void cut(const script_step *step, bool is_end)
{
    if (step->way != SCRIPT_IN) {
        now.bench.eth0->out.is_cut = !is_end;
    }
    if (step->way != SCRIPT_OUT) {
        now.bench.eth0->in.is_cut = !is_end;
    }
}

static void address(bool is_end)
{
    const uint32_t own = WORLD_ADDRESS(10, 42, 0, 1);
    world_interface_remove(now.bench.eth0, own);
    if (is_end) {
        world_interface_add(now.bench.eth0, own, 24);
    }
}

/* --- Disk, clock, power --- */

static void disk_begins(const script_step *step)
{
    world_disk *disk = world_disk_of(now.bench.host);
    const unsigned writes = WORLD_DISK_WRITE | WORLD_DISK_SYNC |
                            WORLD_DISK_RENAME | WORLD_DISK_OPEN |
                            WORLD_DISK_CLOSE;
    if (strcmp(step->text, "stall") == 0) {
        world_disk_stall(disk, writes, world_now() + step->lasts_ms * WORLD_MS);
    } else if (strcmp(step->text, "slow") == 0) {
        world_disk_slow(disk, writes, MS, 200 * MS);
    } else if (strcmp(step->text, "full") == 0) {
        world_disk_fill(disk, (uint64_t)step->value);
    } else if (strcmp(step->text, "sync") == 0) {
        world_disk_fail(disk, WORLD_DISK_SYNC, 1.0, EIO);
    } else if (strcmp(step->text, "rename") == 0) {
        world_disk_fail(disk, WORLD_DISK_RENAME, 1.0, EIO);
    } else if (strcmp(step->text, "open") == 0) {
        world_disk_fail(disk, WORLD_DISK_OPEN, 1.0, EMFILE);
    } else {
        world_disk_fail(disk, WORLD_DISK_WRITE | WORLD_DISK_SYNC, 0.2, EIO);
    }
}

static void disk(const script_step *step, bool is_end)
{
    if (is_end) {
        now.disk_faults--;
        world_disk_heal(world_disk_of(now.bench.host));
        return;
    }
    now.disk_faults++;
    for (unsigned i = 0; i < SCRIPT_TOOLS; i++) {
        if (now.tools[i] != NULL && !user_ended(now.tools[i]) &&
            is_of_bench(now.tools[i])) {
            witness_stalls(now.tools[i]);
        }
    }
    disk_begins(step);
}

static void clock_changes(const script_step *step)
{
    if (step->kind == SCRIPT_CLOCK) {
        world_host_step_utc(now.bench.host, step->value * MS);
    } else {
        world_host_set_drift(now.bench.host, step->value * 1000);
    }
}

static bool is_of_sensor(const script_step *step)
{
    return step->kind == SCRIPT_SENSOR;
}

/* The faults that are still to come, as lumsim takes them. */
static void sensor_on(void)
{
    char options[2048];
    size_t used =
        (size_t)snprintf(options, sizeof options, "%s", now.script->sensor);
    now.sensor_ms = world_now() / MS;
    for (unsigned i = 0; i < now.script->count && used < sizeof options; i++) {
        const script_step *s = &now.script->steps[i];
        const int64_t from_ms = s->at_ms - now.sensor_ms;
        if (!is_of_sensor(s) || from_ms <= 0) {
            continue;
        }
        used += (size_t)snprintf(options + used, sizeof options - used,
                                 " --fault %s@%.3f", s->text,
                                 (double)from_ms / 1000.0);
        if (strcmp(s->text, "reboot") != 0 && used < sizeof options) {
            used +=
                (size_t)snprintf(options + used, sizeof options - used, "-%.3f",
                                 (double)(from_ms + s->lasts_ms) / 1000.0);
        }
    }
    now.sensor = user_sensor_power_on(now.bench.sensor, options);
}

static void power(bool is_end)
{
    if (!is_end) {
        if (!user_ended(now.sensor->tool)) {
            user_signal(now.sensor->tool, SIGKILL);
        }
    } else if (user_ended(now.sensor->tool)) {
        sensor_on();
    }
}

static void blackout(const script_step *step)
{
    for (unsigned i = 0; i < SCRIPT_TOOLS; i++) {
        if (now.tools[i] != NULL && !user_ended(now.tools[i]) &&
            is_of_bench(now.tools[i])) {
            witness_cut(now.tools[i]);
        }
    }
    world_host_power_cut(now.bench.host, (double)step->value / 100.0);
    witness_blackout(now.bench.host);
}

/* --- Steps --- */

static void write_plan(const script_step *step)
{
    user_write_file(now.bench.host, user_format("plan%u.yaml", step->n),
                    user_format("version: 1\nsteps:\n%s", step->text));
}

/* What was met. Behind the ':' the name of a fault, for the judges. */
static const char *name_step(const script_step *step)
{
    static const char *const names[] = {
        [SCRIPT_RUN] = "step:run",         [SCRIPT_TYPE] = "step:type",
        [SCRIPT_SIGNAL] = "step:signal",   [SCRIPT_STOP] = "step:stop",
        [SCRIPT_AT_CALL] = "step:at-call", [SCRIPT_WIRE] = "step:wire",
        [SCRIPT_CUT] = "step:cut",         [SCRIPT_CABLE] = "step:cable",
        [SCRIPT_ADDRESS] = "step:address", [SCRIPT_DISK] = "step:disk",
        [SCRIPT_CLOCK] = "step:clock",     [SCRIPT_DRIFT] = "step:drift",
        [SCRIPT_SLOW] = "step:slow-host",  [SCRIPT_SENSOR] = "step:hazard",
        [SCRIPT_POWER] = "step:power",     [SCRIPT_BLACKOUT] = "step:blackout",
        [SCRIPT_PLAN] = "step:plan"};
    if (step->kind == SCRIPT_RUN && step->is_far) {
        return "step:far";
    }
    if (step->kind == SCRIPT_SENSOR && step->text[0] == 'r') {
        return "step:reboot";
    }
    if (step->kind == SCRIPT_SENSOR && step->text[1] == 'i') {
        return "step:silence";
    }
    return names[step->kind];
}

/* What of it disturbs the way between tools and the sensor. */
static bool is_of_way(script_kind kind)
{
    return kind == SCRIPT_WIRE || kind == SCRIPT_CUT || kind == SCRIPT_CABLE ||
           kind == SCRIPT_ADDRESS || kind == SCRIPT_SLOW ||
           kind == SCRIPT_POWER;
}

/* Somewhat longer than it lasts: what was held back comes later. */
static void tell_witness(const script_step *step)
{
    const char *name = name_step(step);
    world_met(name);
    if (!is_of_way(step->kind)) {
        return;
    }
    const int64_t held_ns =
        (int64_t)((step->faults.delay_ms + step->faults.jitter_ms +
                   step->faults.reorder_ms) *
                  1e6);
    witness_fault(strchr(name, ':') + 1, world_now(),
                  world_now() + (step->lasts_ms + 100) * MS + held_ns);
}

static void take_lasting(const script_step *step, bool is_end)
{
    if (step->kind == SCRIPT_WIRE) {
        wire(step, is_end);
    } else if (step->kind == SCRIPT_CUT) {
        cut(step, is_end);
    } else if (step->kind == SCRIPT_CABLE) {
        user_cable(now.bench.eth0, is_end);
    } else if (step->kind == SCRIPT_ADDRESS) {
        address(is_end);
    } else if (step->kind == SCRIPT_DISK) {
        disk(step, is_end);
    } else if (step->kind == SCRIPT_SLOW) {
        now.bench.host->slowness = is_end ? 1 : (unsigned)step->value;
    } else if (step->kind == SCRIPT_POWER) {
        power(is_end);
    } else if (step->kind == SCRIPT_STOP) {
        signal_to(step, is_end ? SIGCONT : SIGSTOP);
    } else if (step->kind == SCRIPT_RUN && is_end) {
        world_reader_close(now.readers[step->tool]);
    }
}

/* --- Steps that wait for a call --- */

/* As it is met: "call:rename". Names live as long as the program. */
static const char *name_call(const char *call)
{
    static char names[CALLS][32];
    unsigned i = 0;
    while (i + 1 < CALLS && names[i][0] != '\0' &&
           strcmp(names[i] + strlen("call:"), call) != 0) {
        i++;
    }
    (void)snprintf(names[i], sizeof names[i], "call:%s", call);
    return names[i];
}

static void end_aimed(void *argument)
{
    const struct aim *aim = argument;
    take_lasting(aim->step, true);
}

static void begin_aimed(void *argument)
{
    struct aim *aim = argument;
    const script_step *step = aim->step;
    tell_witness(step);
    take_lasting(step, false);
    if (step->kind == SCRIPT_BLACKOUT) {
        blackout(step);
    } else if (step->lasts_ms > 0) {
        (void)world_at(world_now() + step->lasts_ms * MS, end_aimed, aim);
    }
}

static void go_on(void *argument)
{
    const struct aim *aim = argument;
    if (!user_ended(aim->tool)) {
        user_signal(aim->tool, SIGCONT);
    }
}

/* Right before the call. What befalls others than the tool itself is an event,
 * which the tool lets go first. */
static void meet_call(void *argument)
{
    struct aim *aim = argument;
    if (now.is_over) {
        return;
    }
    world_met(name_call(aim->step->call));
    if (aim->step->kind != SCRIPT_AT_CALL) {
        (void)world_at(world_now(), begin_aimed, aim);
        return;
    }
    /* Its own task stops in the signal, and nothing behind that is done. */
    if (aim->step->number == SIGSTOP) {
        if (strncmp(aim->step->call, "send", 4) == 0) {
            witness_held(aim->tool);
        }
        (void)world_at(world_now() + aim->step->value * MS, go_on, aim);
    }
    user_signal(aim->tool, aim->step->number);
}

static void take_aim(const script_step *step)
{
    user_tool *tool = tool_of(step);
    if (tool != NULL && !user_ended(tool)) {
        struct aim *aim = &now.aims[now.aim_count++];
        *aim = (struct aim){step, tool};
        user_at_call(tool, step->call, step->n, meet_call, aim);
    }
}

/* --- Turns --- */

static void take_turn(const struct turn *turn)
{
    const script_step *step = turn->step;
    if (step->kind == SCRIPT_AT_CALL) {
        tell_witness(step);
    }
    if (step->call[0] != '\0') {
        take_aim(step);
        return;
    }
    if (!turn->is_end) {
        tell_witness(step);
    }
    take_lasting(step, turn->is_end);
    if (turn->is_end) {
        return;
    }
    if (step->kind == SCRIPT_RUN) {
        run(step);
    } else if (step->kind == SCRIPT_TYPE) {
        type(step);
    } else if (step->kind == SCRIPT_PLAN) {
        write_plan(step);
    } else if (step->kind == SCRIPT_SIGNAL) {
        signal_to(step, step->number);
    } else if (step->kind == SCRIPT_CLOCK || step->kind == SCRIPT_DRIFT) {
        clock_changes(step);
    } else if (step->kind == SCRIPT_BLACKOUT) {
        blackout(step);
    }
}

static void add_turn(int64_t at_ms, const script_step *step, bool is_end)
{
    unsigned i = now.turn_count++;
    for (; i > 0 && now.turns[i - 1].at_ms > at_ms; i--) {
        now.turns[i] = now.turns[i - 1];
    }
    now.turns[i] = (struct turn){at_ms, step, is_end};
}

static void plan(void)
{
    for (unsigned i = 0; i < now.script->count; i++) {
        const script_step *step = &now.script->steps[i];
        add_turn(step->at_ms, step, false);
        if (step->lasts_ms > 0 && !is_of_sensor(step) &&
            step->call[0] == '\0') {
            add_turn(step->at_ms + step->lasts_ms, step, true);
        }
    }
}

static void wait_until(int64_t at_ms)
{
    world_queue nobody = {NULL, NULL};
    if (world_now() < at_ms * MS) {
        world_wait_deaf(&nobody, at_ms * MS);
    }
}

/* --- The end --- */

static bool have_all_ended(void)
{
    for (unsigned i = 0; i < SCRIPT_TOOLS; i++) {
        if (now.tools[i] != NULL && !user_ended(now.tools[i])) {
            return false;
        }
    }
    return true;
}

static void end_tools(int number)
{
    for (unsigned i = 0; i < SCRIPT_TOOLS; i++) {
        if (now.tools[i] != NULL && !user_ended(now.tools[i])) {
            user_signal(now.tools[i], number);
        }
    }
}

/* All is well again, and all that runs is told to end. What does not is for the
 * judges. */
static void finish(void)
{
    const int64_t end_ns = world_now() + ENDING_MS * MS;
    now.is_over = true;
    end_tools(SIGTERM);
    while (!have_all_ended() && world_now() < end_ns) {
        wait_until(world_now() / MS + 500);
    }
    end_tools(SIGKILL);
    if (!user_ended(now.sensor->tool)) {
        (void)user_end(now.sensor->tool, SIGINT);
    }
}

static void tell(void)
{
    size_t size = 0;
    const uint8_t *bytes = capture_small(&size);
    user_limit(LIMIT_S, LIMIT_CALLS);
    witness_knows_all();
    now.bench = user_bench_new();
    now.other = user_host_new("other");
    (void)user_interface(now.other, "eth0", now.bench.wire, "10.42.0.2/24");
    world_disk_put(world_disk_of(now.bench.sensor), "/home/small.pcap", bytes,
                   size);
    sensor_on();
    for (unsigned i = 0; i < now.turn_count; i++) {
        wait_until(now.turns[i].at_ms);
        take_turn(&now.turns[i]);
    }
    wait_until(now.script->ends_ms);
    finish();
}

user_result script_tell(const struct script *script)
{
    static const user_story story = {.name = "dice",
                                     .fact = "whatever a user does",
                                     .file = "dice",
                                     .tell = tell};
    memset(&now, 0, sizeof now);
    memset(processes, 0, sizeof processes);
    now.script = script;
    plan();
    return user_tell(&story, script->seed);
}
