/* What befalls tools by the steps of a script, each alone. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "dice/dice.h"
#include "dice/script.h"
#include "image/images.h"
#include "kernel/disk.h"
#include "kernel/trace.h"
#include "telling.h"
#include "user.h"
#include "witness.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* The table of stories is not empty. */
STORY(nothing, "nothing happens")
{
}

static struct script script;

/* Of the tool that is looked at, when all was told; status as user_wait(). */
static struct {
    int status;
    double lasted_s;
    char host[24];
    char process[32];
    bool has_file; /* f1.csv */
} seen;

/* The second one: the first is the sensor. */
static void look(void)
{
    const user_tool *tool = user_tool_first()->next;
    const world_process *p = tool->process;
    assert_true(p->has_ended);
    seen.status =
        WIFSIGNALED(p->status) ? -WTERMSIG(p->status) : WEXITSTATUS(p->status);
    seen.lasted_s = (double)(p->ended_ns - p->began_ns) / 1e9;
    seen.has_file = world_disk_has(world_disk_of(p->host), "/home/f1.csv");
    (void)snprintf(seen.host, sizeof seen.host, "%s", p->host->name);
    (void)snprintf(seen.process, sizeof seen.process, "%s[%ld]", p->name,
                   p->pid);
}

static script_step *begin(const char *command)
{
    memset(&script, 0, sizeof script);
    memset(&seen, 0, sizeof seen);
    script.seed = 4;
    script.ends_ms = 60000;
    (void)snprintf(script.sensor, sizeof script.sensor,
                   "--replay small.pcap --loop");
    script_step *run = &script.steps[script.count++];
    run->kind = SCRIPT_RUN;
    run->at_ms = 1000;
    run->tool = 1;
    (void)snprintf(run->text, sizeof run->text, "%s", command);
    return run;
}

static script_step *add(script_kind kind, int64_t at_ms)
{
    script_step *step = &script.steps[script.count++];
    step->kind = kind;
    step->at_ms = at_ms;
    step->tool = 1;
    return step;
}

static script_step *add_at_call(script_kind kind, const char *call, unsigned n)
{
    script_step *step = add(kind, 1000);
    (void)snprintf(step->call, sizeof step->call, "%s", call);
    step->n = n;
    return step;
}

static void tell(void)
{
    user_ends = look;
    const user_result result = script_tell(&script);
    assert_string_equal(result.failure, "");
}

static bool was_met(const char *name)
{
    unsigned i = 0;
    while (i < world_met_count() && strcmp(world_met_name(i), name) != 0) {
        i++;
    }
    return i < world_met_count();
}

/* --- Tools --- */

static void a_tool_runs_on_the_bench_and_is_named(void **state)
{
    (void)state;
    (void)begin("lumctl heartbeat --duration 2");
    tell();
    assert_int_equal(seen.status, 0);
    assert_string_equal(seen.host, "bench");
    assert_string_equal(script_process(1), seen.process);
    assert_string_equal(script_process(2), "");
    assert_true(seen.lasted_s > 1.9 && seen.lasted_s < 2.5);
}

static void a_second_computer_has_a_way_to_the_sensor(void **state)
{
    (void)state;
    begin("lumctl status")->is_far = true;
    tell();
    assert_string_equal(seen.host, "other");
    assert_int_equal(seen.status, 0);
    assert_true(was_met("step:far"));
}

static void a_tool_that_is_stopped_at_a_call_goes_on(void **state)
{
    (void)state;
    (void)begin("lumctl heartbeat --duration 2");
    script_step *stop = add_at_call(SCRIPT_AT_CALL, "close", 1);
    stop->number = SIGSTOP;
    stop->value = 7000;
    tell();
    assert_int_equal(seen.status, 0);
    assert_true(seen.lasted_s > 7.0 && seen.lasted_s < 9.5);
    assert_true(was_met("call:close"));
}

static void a_signal_comes_before_a_call(void **state)
{
    (void)state;
    (void)begin("lumctl heartbeat");
    add_at_call(SCRIPT_AT_CALL, "sendmmsg", 3)->number = SIGKILL;
    tell();
    assert_int_equal(seen.status, -SIGKILL);
    assert_true(seen.lasted_s < 1.0);
}

/* --- Pipes --- */

static script_step *begin_pipe(int64_t bytes_per_s)
{
    script_step *run = begin("lumdump udp://10.42.0.37 -q -o - --format csv");
    run->is_stalled = true;
    run->value = bytes_per_s;
    return run;
}

static void a_reader_that_stalls_is_given_up(void **state)
{
    (void)state;
    (void)begin_pipe(0);
    add(SCRIPT_SIGNAL, 20000)->number = SIGINT;
    tell();
    assert_true(was_met("fault:reader-stalls"));
    assert_int_equal(seen.status, 1);
    assert_true(seen.lasted_s > 21.0 && seen.lasted_s < 24.0);
}

static void a_fast_reader_is_no_fault(void **state)
{
    (void)state;
    (void)begin_pipe(10000000);
    add(SCRIPT_SIGNAL, 20000)->number = SIGINT;
    tell();
    assert_int_equal(seen.status, 0);
}

static void a_reader_that_goes_ends_the_run(void **state)
{
    (void)state;
    begin_pipe(1000)->lasts_ms = 5000;
    tell();
    assert_true(was_met("fault:reader-closes"));
    assert_true(seen.lasted_s > 4.9 && seen.lasted_s < 8.0);
}

/* --- At a call --- */

static void begin_recording(void)
{
    (void)begin("lumdump udp://10.42.0.37 -q -o f1.csv --duration 3");
}

static void a_recording_has_its_file(void **state)
{
    (void)state;
    begin_recording();
    tell();
    assert_int_equal(seen.status, 0);
    assert_true(seen.has_file);
}

static void a_disk_fails_at_a_rename(void **state)
{
    (void)state;
    begin_recording();
    script_step *disk = add_at_call(SCRIPT_DISK, "rename", 1);
    (void)snprintf(disk->text, sizeof disk->text, "rename");
    disk->lasts_ms = 1000;
    tell();
    assert_true(was_met("fault:disk-fail-rename"));
    assert_int_equal(seen.status, 1);
    assert_false(seen.has_file);
}

static void a_disk_stalls_at_a_sync_for_a_while(void **state)
{
    (void)state;
    begin_recording();
    script_step *disk = add_at_call(SCRIPT_DISK, "fsync", 1);
    (void)snprintf(disk->text, sizeof disk->text, "stall");
    disk->lasts_ms = 9000;
    tell();
    assert_true(was_met("fault:disk-stall-sync"));
    assert_int_equal(seen.status, 0);
    assert_true(seen.has_file);
    assert_true(seen.lasted_s > 12.0);
}

static void the_power_goes_before_a_name_is_given(void **state)
{
    (void)state;
    begin_recording();
    add_at_call(SCRIPT_BLACKOUT, "rename", 1)->value = 100;
    tell();
    assert_int_equal(seen.status, -SIGKILL);
    assert_false(seen.has_file);
    assert_true(was_met("call:rename"));
}

static void the_wire_is_cut_at_a_request_and_mended(void **state)
{
    (void)state;
    (void)begin("lumctl status --timeout 500 --retries 4");
    add_at_call(SCRIPT_CUT, "sendmmsg", 1)->lasts_ms = 1200;
    tell();
    assert_int_equal(seen.status, 0);
    assert_true(was_met("step:cut"));
    assert_true(seen.lasted_s > 1.2);
}

static void what_waits_for_a_call_that_never_comes_does_nothing(void **state)
{
    (void)state;
    (void)begin("lumctl heartbeat --duration 2");
    add_at_call(SCRIPT_BLACKOUT, "rename", 1)->value = 50;
    tell();
    assert_int_equal(seen.status, 0);
    assert_false(was_met("step:blackout"));
    assert_false(was_met("call:rename"));
}

/* --- The smallest, told again --- */

/* What the dice make up fails for us if it runs something on the other
 * computer, and ends its process if that is asked for. */
static bool kills;

static void look_for_far(void)
{
    if (was_met("step:far")) {
        world_fail("something ran there");
        if (kills) {
            (void)raise(SIGKILL);
        }
    }
}

static uint64_t seed_with_far(void)
{
    for (uint64_t seed = 1;; seed++) {
        script_draw(&script, seed);
        for (unsigned i = 0; i < script.count; i++) {
            if (script.steps[i].is_far) {
                return seed;
            }
        }
    }
}

/* What is printed, in a process as main.c does it. */
static uint64_t printed_of;

static void print_smallest(void *file)
{
    assert_int_equal(dup2(fileno(file), STDOUT_FILENO), STDOUT_FILENO);
    dice_print_smallest(printed_of, kills);
}

static void read_smallest(char *out, size_t room)
{
    FILE *file = tmpfile();
    assert_non_null(file);
    assert_int_equal(telling_apart(print_smallest, file), 0);
    rewind(file);
    out[fread(out, 1, room - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
}

static void expect_smallest(void)
{
    char text[4096];
    char steps[64];
    printed_of = seed_with_far();
    user_ends = look_for_far;
    read_smallest(text, sizeof text);
    const char *command = strstr(text, " --steps ");
    const char *end = strstr(text, " --end ");
    assert_true(command != NULL && end != NULL);
    assert_int_equal(sscanf(command, " --steps %63s", steps), 1);
    const double end_s = strtod(end + strlen(" --end "), NULL);
    assert_null(strchr(steps, ',')); /* one step is enough */
    assert_non_null(strstr(text, "(other) $ "));
    assert_true(kills || strstr(text, "([") != NULL);
    kills = false;
    assert_true(dice_only(steps, (int64_t)(end_s * 1000.0)));
    assert_string_not_equal(dice_run(printed_of).failure, "");
    assert_true(dice_only("none", (int64_t)(end_s * 1000.0)));
    assert_string_equal(dice_run(printed_of).failure, "");
    assert_true(dice_only(NULL, 0));
}

static void the_smallest_that_fails_can_be_told_again(void **state)
{
    (void)state;
    kills = false;
    expect_smallest();
}

static void so_can_one_that_takes_the_process_with_it(void **state)
{
    (void)state;
    kills = true;
    expect_smallest();
}

static void steps_are_numbers(void **state)
{
    static const char *const bad[] = {"",   "0",    "1,", ",1",  "x",     "1;2",
                                      "97", "1,,2", "-1", "1 2", "none,1"};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(dice_only(bad[i], 0));
    }
    assert_true(dice_only("1,96", 0));
    assert_true(dice_only(NULL, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tool_runs_on_the_bench_and_is_named),
        cmocka_unit_test(a_second_computer_has_a_way_to_the_sensor),
        cmocka_unit_test(a_tool_that_is_stopped_at_a_call_goes_on),
        cmocka_unit_test(a_signal_comes_before_a_call),
        cmocka_unit_test(a_reader_that_stalls_is_given_up),
        cmocka_unit_test(a_fast_reader_is_no_fault),
        cmocka_unit_test(a_reader_that_goes_ends_the_run),
        cmocka_unit_test(a_recording_has_its_file),
        cmocka_unit_test(a_disk_fails_at_a_rename),
        cmocka_unit_test(a_disk_stalls_at_a_sync_for_a_while),
        cmocka_unit_test(the_power_goes_before_a_name_is_given),
        cmocka_unit_test(the_wire_is_cut_at_a_request_and_mended),
        cmocka_unit_test(what_waits_for_a_call_that_never_comes_does_nothing),
        cmocka_unit_test(the_smallest_that_fails_can_be_told_again),
        cmocka_unit_test(so_can_one_that_takes_the_process_with_it),
        cmocka_unit_test(steps_are_numbers),
    };
    world_images();
    witness_install(); /* what it asks at the end, each test asks itself */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
