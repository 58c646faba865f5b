/* For tests of the kernel: functions of the test run as programs of a host. */
#ifndef WORLD_TEST_BENCH_H
#define WORLD_TEST_BENCH_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/disk.h"
#include "kernel/file.h"
#include "kernel/process.h"
#include "kernel/small_calls.h"
#include "kernel/task.h"
#include "kernel/time.h"
#include "kernel/trace.h"
#include "kernel/world.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#define BENCH_SEED     7
#define BENCH_PROGRAMS 32

/* Static data of a program, as an image has it. */
__attribute__((section("bench_section"), used)) static int bench_data = 1;
extern char __start_bench_section[];
extern char __stop_bench_section[];

static world_host *host;
static void (*bench_script)(void);
static int (*bench_programs[BENCH_PROGRAMS])(void);
static unsigned bench_count;

static inline int bench_main(int argc, char **argv)
{
    assert_int_equal(argc, 2);
    assert_int_equal(bench_data, 1);
    return bench_programs[strtoul(argv[1], NULL, 10)]();
}

/* A process whose descriptors 0 to 2 are these; NULL: /dev/null. */
static inline world_process *bench_start(int (*program)(void),
                                         world_file *input, world_file *output,
                                         world_file *error)
{
    char number[16];
    const char *const arguments[] = {number, NULL};
    assert_true(bench_count < BENCH_PROGRAMS);
    (void)snprintf(number, sizeof number, "%u", bench_count);
    bench_programs[bench_count++] = program;
    world_process *process =
        world_process_start(&(world_start){.host = host,
                                           .program = "program",
                                           .arguments = arguments,
                                           .input = input,
                                           .output = output,
                                           .error = error});
    assert_non_null(process);
    return process;
}

static inline int bench_wait(world_process *process)
{
    assert_true(world_process_wait(process, world_now() + 3600 * WORLD_S));
    return process->status;
}

/* A program on its own, which has to end with 0. */
static inline void bench_do(int (*program)(void))
{
    assert_int_equal(bench_wait(bench_start(program, NULL, NULL, NULL)), 0);
}

static inline void bench_pause(int64_t ns)
{
    world_queue nothing = {NULL, NULL};
    world_wait_deaf(&nothing, world_now() + ns);
}

static inline void *bench_user(void *argument)
{
    (void)argument;
    host = world_host_new("bench");
    bench_script();
    return NULL;
}

/* The user's task in a new world. */
static inline void bench_run(void (*user)(void))
{
    static const world_image image = {
        "program", bench_main, __start_bench_section, __stop_bench_section};
    static bool is_known;
    if (!is_known) {
        world_process_images(&image, 1);
        is_known = true;
    }
    bench_script = user;
    bench_count = 0;
    world_begin(BENCH_SEED);
    const bool has_ended =
        world_run(world_task_begin(NULL, bench_user, NULL), WORLD_NEVER);
    assert_string_equal(world_failure(), "");
    assert_true(has_ended);
    world_end();
}

#endif
