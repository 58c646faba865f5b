#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/crash.h"
#include "kernel/process.h"
#include "kernel/process_internal.h"
#include "kernel/sanitizer.h"
#include "kernel/task.h"
#include "kernel/time.h"
#include "kernel/world.h"

#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define SEED 4711

extern char __start_program_data[];
extern char __stop_program_data[];

/* A program of the world; what it does to crash. */
__attribute__((section("program_data"))) static volatile int depth = 1;
static void (*crash)(void);

static int program_main(int argc, char **argv)
{
    (void)argv;
    crash();
    return argc;
}

#if !WORLD_SANITIZED
static void fill_stack(void)
{
    volatile char room[4096];
    room[0] = (char)depth++;
    if (depth > 0) {
        fill_stack();
    }
    room[1] = room[0];
}

static void read_nothing(void)
{
    const volatile int *volatile nowhere = NULL;
    depth = *nowhere;
}
#else
static void read_behind_memory(void)
{
    const volatile char *volatile room = world_malloc(24);
    depth = room[24];
}

static void read_before_memory(void)
{
    const volatile char *volatile room = world_malloc(24);
    depth = room[-1];
}

static void read_freed_memory(void)
{
    volatile char *volatile room = world_malloc(24);
    world_free((void *)(uintptr_t)room);
    volatile char *volatile other = world_malloc(24);
    other[0] = 1;
    depth = room[0];
}

/* Others have had their turn meanwhile. */
static void write_behind_an_array(void)
{
    volatile char room[24];
    volatile char *volatile end = room + sizeof room;
    world_yield();
    *end = 1;
    depth = room[0];
}
#endif

static void *run_user(void *argument)
{
    (void)argument;
    static const char *const none[] = {NULL};
    world_process *process =
        world_process_start(&(world_start){.host = world_host_new("bench"),
                                           .program = "program",
                                           .arguments = none});
    (void)world_process_wait(process, WORLD_NEVER);
    return NULL;
}

static void run_world(int error_end)
{
    static const world_image image = {
        "program", program_main, __start_program_data, __stop_program_data};
    (void)dup2(error_end, STDERR_FILENO);
    world_process_images(&image, 1);
    world_crash_tell();
    world_begin(SEED);
    (void)world_run(world_task_begin(NULL, run_user, NULL), WORLD_NEVER);
    _exit(0);
}

/* In a process of the system, which it kills; what that said. */
static void expect_told(void (*how)(void), const char *what)
{
    static char said[65536];
    size_t length = 0;
    int ends[2];
    int status = 0;
    ssize_t got = 0;
    crash = how;
    memset(said, 0, sizeof said);
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        run_world(ends[1]);
    }
    (void)close(ends[1]);
    while ((got = read(ends[0], said + length, sizeof said - 1 - length)) > 0) {
        length += (size_t)got;
    }
    (void)close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WORLD_SANITIZED) {
        assert_true(WIFEXITED(status));
        assert_int_not_equal(WEXITSTATUS(status), 0);
    } else {
        assert_true(WIFSIGNALED(status));
        assert_int_equal(WTERMSIG(status), SIGSEGV);
    }
    assert_non_null(strstr(said, what));
    assert_non_null(strstr(said, "in program[1000], seed 4711\n"));
}

#if !WORLD_SANITIZED
static void a_crash_names_its_seed(void **state)
{
    (void)state;
    expect_told(read_nothing, "SIGSEGV");
}

static void so_does_a_stack_that_runs_out(void **state)
{
    (void)state;
    expect_told(fill_stack, "SIGSEGV");
}
#else
static void a_find_names_its_seed(void **state)
{
    (void)state;
    expect_told(read_behind_memory, "use-after-poison");
    expect_told(read_before_memory, "use-after-poison");
    expect_told(read_freed_memory, "use-after-poison");
}

static void arrays_are_watched_across_a_wait(void **state)
{
    (void)state;
    expect_told(write_behind_an_array, "stack-buffer-overflow");
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#if !WORLD_SANITIZED
        cmocka_unit_test(a_crash_names_its_seed),
        cmocka_unit_test(so_does_a_stack_that_runs_out),
#else
        cmocka_unit_test(a_find_names_its_seed),
        cmocka_unit_test(arrays_are_watched_across_a_wait),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
