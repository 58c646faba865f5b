#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/clock_calls.h"
#include "kernel/file_calls.h"
#include "kernel/option_calls.h"
#include "kernel/pipe.h"
#include "kernel/process.h"
#include "kernel/signal_calls.h"
#include "kernel/small_calls.h"
#include "kernel/task.h"
#include "kernel/thread_calls.h"
#include "kernel/time.h"
#include "kernel/trace.h"
#include "kernel/world.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>

#define SEED 7

/* Programs without an image: their calls are the world's by name. */
#define OF_PROGRAM __attribute__((section("program_data")))
extern char __start_program_data[];
extern char __stop_program_data[];

OF_PROGRAM static int turns = 3; /* what a tool's static data is */
static int (*run_program)(int argc, char **argv);
static world_host *host;
static void (*script)(void);

/* What programs found. */
static int found[4];
static int64_t found_ns[4];
static char *found_text[8];
static unsigned found_count;

static int program_main(int argc, char **argv)
{
    return run_program(argc, argv);
}

static void sleep_ns(int64_t ns)
{
    const struct timespec wanted = {.tv_sec = (time_t)(ns / WORLD_S),
                                    .tv_nsec = (long)(ns % WORLD_S)};
    found[3] = world_call_clock_nanosleep(CLOCK_MONOTONIC, 0, &wanted, NULL);
}

static world_process *start(int (*run)(int argc, char **argv))
{
    static const char *const none[] = {NULL};
    const world_start s = {
        .host = host, .program = "program", .arguments = none};
    run_program = run;
    world_process *process = world_process_start(&s);
    assert_non_null(process);
    return process;
}

static int status_of(world_process *process)
{
    assert_true(world_process_wait(process, world_now() + 3600 * WORLD_S));
    return process->status;
}

static void *run_user(void *argument)
{
    (void)argument;
    host = world_host_new("bench");
    script();
    return NULL;
}

static void run_under(uint64_t seed, void (*user)(void))
{
    memset(found, 0, sizeof found);
    memset(found_ns, 0, sizeof found_ns);
    found_count = 0;
    script = user;
    world_begin(seed);
    const bool has_ended =
        world_run(world_task_begin(NULL, run_user, NULL), WORLD_NEVER);
    assert_string_equal(world_failure(), "");
    assert_true(has_ended);
}

static void run(void (*user)(void))
{
    run_under(SEED, user);
}

/* --- processes --- */

static int count_turns(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    for (int i = 0; i < 4; i++) {
        turns++;
        sleep_ns(WORLD_MS);
    }
    return turns;
}

static void two_of_one_program(void)
{
    world_process *first = start(count_turns);
    world_process *second = start(count_turns);
    assert_int_equal(WEXITSTATUS(status_of(first)), 7);
    assert_int_equal(WEXITSTATUS(status_of(second)), 7);
    assert_int_equal(WEXITSTATUS(status_of(start(count_turns))), 7);
}

static void each_process_has_static_data_of_its_own(void **state)
{
    (void)state;
    run(two_of_one_program);
}

static int look_around(int argc, char **argv)
{
    assert_int_equal(argc, 3);
    assert_string_equal(argv[0], "program");
    assert_string_equal(argv[1], "--laser");
    argv[2][0] = '?'; /* its own copy */
    assert_null(argv[3]);
    assert_string_equal(world_call_getenv("HOME"), "/home");
    assert_null(world_call_getenv("HOM"));
    assert_int_equal(world_call_getpid(), world_process_self()->pid);
    cpu_set_t cores;
    assert_int_equal(world_call_sched_getaffinity(0, sizeof cores, &cores), 0);
    assert_int_equal(CPU_COUNT(&cores), 2);
    world_call_exit(300);
}

static void one_with_arguments(void)
{
    static const char *const arguments[] = {"--laser", "on", NULL};
    static const char *const environment[] = {"HOMER=no", "HOME=/home", NULL};
    run_program = look_around;
    world_process *process =
        world_process_start(&(world_start){.host = host,
                                           .program = "program",
                                           .arguments = arguments,
                                           .environment = environment});
    assert_int_equal(status_of(process), (300 & 0xff) << 8);
    assert_string_equal(process->arguments[2], "on");
}

static void arguments_and_environment_are_given_and_the_status_taken(
    void **state)
{
    (void)state;
    run(one_with_arguments);
}

/* Nothing frees it but the end. */
static int waste(int argc, char **argv)
{
    (void)argv;
    unsigned char *small = world_call_malloc(100);
    unsigned char *large = world_call_calloc(1, (size_t)16 << 20);
    memset(small, 'x', 100);
    assert_int_equal(large[((size_t)16 << 20) - 1], 0);
    small = world_call_realloc(small, 1000);
    assert_int_equal(small[99], 'x');
    found[0] = small[999]; /* chance, but the same in each run */
    assert_null(world_call_calloc((size_t)argc << 62, 8));
    world_call_free(NULL);
    found_text[0] = world_call_strndup("lidar", 3);
    assert_string_equal(found_text[0], "lid");
    while (found[1] == 0) {
        sleep_ns(WORLD_S);
    }
    return 0;
}

static void one_that_wastes(void)
{
    world_process *process = start(waste);
    assert_false(world_process_wait(process, 10 * WORLD_S));
    world_process_signal(process, SIGKILL);
    assert_int_equal(status_of(process), SIGKILL);
}

static void memory_is_freed_with_a_process_that_is_killed(void **state)
{
    (void)state;
    run(one_that_wastes);
    const int junk = found[0];
    const uint64_t digest = world_digest();
    run(one_that_wastes);
    assert_int_equal(found[0], junk);
    assert_true(world_digest() == digest);
}

/* What a tool reads on its stack before it has written there. */
static int read_a_stack(int argc, char **argv)
{
    char *unwritten = __builtin_alloca((size_t)32 * 1024);
    (void)argc;
    (void)argv;
    /* The compiler cannot know that nobody has written there. */
    __asm__ volatile("" : : "r"(unwritten) : "memory");
    found[0] = (unsigned char)unwritten[1024];
    memset(unwritten, found[0] + 1, (size_t)32 * 1024);
    found_text[0] = unwritten;
    __asm__ volatile("" : : "r"(unwritten) : "memory");
    return 0;
}

static void one_that_reads_its_stack(void)
{
    assert_int_equal(status_of(start(read_a_stack)), 0);
}

static void a_stack_is_the_same_under_a_seed_and_differs_between_seeds(
    void **state)
{
    bool differs = false;
    (void)state;
    run(one_that_reads_its_stack);
    const int junk = found[0];
    const char *place = found_text[0];
    for (uint64_t seed = 1; seed < 6; seed++) {
        run_under(seed, one_that_reads_its_stack);
        differs = differs || found[0] != junk;
        assert_ptr_equal(found_text[0], place);
    }
    assert_true(differs);
    run(one_that_reads_its_stack);
    assert_int_equal(found[0], junk);
}

static const char *printed;

static int print(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    (void)world_call_write(1, printed, strlen(printed));
    return 0;
}

static void one_that_prints(void)
{
    const char *const none[] = {NULL};
    world_start s = {.host = host, .program = "program", .arguments = none};
    run_program = print;
    (void)world_reader_new("output", &s.output);
    assert_int_equal(status_of(world_process_start(&s)), 0);
}

/* The moments are the same. */
static void what_a_program_writes_is_in_the_digest(void **state)
{
    (void)state;
    printed = "a text of a program";
    run(one_that_prints);
    const uint64_t digest = world_digest();
    run(one_that_prints);
    assert_true(world_digest() == digest);
    printed = "a text of q program";
    run(one_that_prints);
    assert_true(world_digest() != digest);
    printed = "a text of a progran";
    run(one_that_prints);
    assert_true(world_digest() != digest);
}

/* --- what was met --- */

static void one_that_meets(void)
{
    world_queue nobody = {NULL, NULL};
    world_met("fault:a");
    world_wait_deaf(&nobody, 3 * WORLD_S);
    world_met("fault:b");
    world_wait_deaf(&nobody, 6 * WORLD_S);
    world_met("fault:c");
    world_met("fault:c");
}

static void what_was_met_within_five_seconds_is_near(void **state)
{
    (void)state;
    run(one_that_meets);
    assert_int_equal(world_met_count(), 3);
    assert_string_equal(world_met_name(2), "fault:c");
    assert_true(world_met_times(0) == 1 && world_met_times(2) == 2);
    assert_true(world_met_near(0, 1) && world_met_near(1, 0));
    assert_true(world_met_near(1, 2) && world_met_near(2, 1));
    assert_false(world_met_near(0, 2) || world_met_near(2, 0));
}

/* --- threads --- */

OF_PROGRAM static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
OF_PROGRAM static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static int inside, seen_together, wakes;

static void *enter_often(void *argument)
{
    for (int i = 0; i < 200; i++) {
        (void)world_call_pthread_mutex_lock(&lock);
        inside++;
        (void)world_call_getpid();
        seen_together += inside > 1;
        inside--;
        (void)world_call_pthread_mutex_unlock(&lock);
    }
    return argument;
}

static int lock_in_three(int argc, char **argv)
{
    pthread_t threads[3];
    (void)argv;
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(world_call_pthread_create(&threads[i], NULL,
                                                   enter_often, &found[i]),
                         0);
    }
    for (size_t i = 0; i < 3; i++) {
        void *result = NULL;
        assert_int_equal(world_call_pthread_join(threads[i], &result), 0);
        assert_ptr_equal(result, &found[i]);
    }
    return argc - 1 + seen_together;
}

static void one_with_threads(void)
{
    assert_int_equal(status_of(start(lock_in_three)), 0);
}

static void one_thread_at_a_time_has_a_mutex(void **state)
{
    (void)state;
    run(one_with_threads);
}

static void *wake_later(void *argument)
{
    (void)argument;
    sleep_ns(5 * WORLD_MS);
    assert_int_equal(world_call_pthread_mutex_trylock(&lock), 0);
    assert_int_equal(world_call_pthread_mutex_trylock(&lock), EBUSY);
    wakes = 1;
    (void)world_call_pthread_cond_broadcast(&changed);
    (void)world_call_pthread_mutex_unlock(&lock);
    return NULL;
}

static struct timespec in(int64_t ns)
{
    struct timespec t;
    (void)world_call_clock_gettime(CLOCK_REALTIME, &t);
    ns += (int64_t)t.tv_nsec;
    t.tv_sec += (time_t)(ns / WORLD_S);
    t.tv_nsec = (long)(ns % WORLD_S);
    return t;
}

static int wait_for_change(int argc, char **argv)
{
    pthread_t thread;
    (void)argc;
    (void)argv;
    wakes = 0;
    const struct timespec soon = in(WORLD_MS);
    const struct timespec late = in(WORLD_S);
    (void)world_call_pthread_mutex_lock(&lock);
    (void)world_call_pthread_create(&thread, NULL, wake_later, NULL);
    found[0] = world_call_pthread_cond_timedwait(&changed, &lock, &soon);
    found_ns[0] = world_now();
    while (wakes == 0 && found[1] == 0) {
        found[1] = world_call_pthread_cond_timedwait(&changed, &lock, &late);
    }
    found_ns[1] = world_now();
    (void)world_call_pthread_mutex_unlock(&lock);
    return world_call_pthread_join(thread, NULL);
}

static void one_that_waits_for_a_change(void)
{
    assert_int_equal(status_of(start(wait_for_change)), 0);
    assert_int_equal(found[0], ETIMEDOUT);
    assert_in_range(found_ns[0], WORLD_MS, 2 * WORLD_MS);
    assert_int_equal(found[1], 0);
    assert_in_range(found_ns[1], 5 * WORLD_MS, 6 * WORLD_MS);
}

static void a_condition_is_waited_for_until_it_comes_or_in_vain(void **state)
{
    (void)state;
    run(one_that_waits_for_a_change);
}

/* --- signals --- */

static void note(int number)
{
    found[0] = number;
    found[1]++;
    found_ns[1] = (int64_t)world_call_pthread_sigmask(SIG_BLOCK, NULL, NULL);
}

static void handle(int number, void (*handler)(int), int flags)
{
    struct sigaction action = {.sa_handler = handler, .sa_flags = flags};
    (void)sigemptyset(&action.sa_mask);
    assert_int_equal(world_call_sigaction(number, &action, NULL), 0);
}

static int sleep_with_handler(int argc, char **argv)
{
    (void)argv;
    handle(SIGTERM, note, 0);
    handle(SIGPIPE, SIG_IGN, 0);
    sleep_ns(100 * WORLD_S);
    found_ns[0] = world_now();
    world_signal_self(SIGPIPE);
    return argc - 1;
}

static void one_that_handles(void)
{
    world_process *process = start(sleep_with_handler);
    (void)world_process_wait(process, WORLD_S);
    world_process_signal(process, SIGTERM);
    assert_int_equal(status_of(process), 0);
    assert_int_equal(found[0], SIGTERM);
    assert_int_equal(found[1], 1);
    assert_int_equal(found[3], EINTR);
    assert_in_range(found_ns[0], WORLD_S, WORLD_S + WORLD_MS);
}

static void a_handler_ends_a_sleep(void **state)
{
    (void)state;
    run(one_that_handles);
}

static int block_for_a_while(int argc, char **argv)
{
    sigset_t all;
    (void)argv;
    handle(SIGINT, note, 0);
    (void)sigfillset(&all);
    (void)world_call_pthread_sigmask(SIG_BLOCK, &all, NULL);
    sleep_ns(2 * WORLD_S);
    assert_int_equal(found[1], 0);
    (void)world_call_sigprocmask(SIG_UNBLOCK, &all, NULL);
    assert_int_equal(found[1], 1);
    handle(SIGINT, SIG_DFL, 0);
    (void)world_call_raise(SIGINT);
    return argc + 100; /* not reached */
}

static void one_that_blocks(void)
{
    world_process *process = start(block_for_a_while);
    (void)world_process_wait(process, WORLD_S);
    world_process_signal(process, SIGINT);
    world_process_signal(process, SIGINT);
    assert_int_equal(status_of(process), SIGINT);
}

static void a_signal_that_is_blocked_waits_and_the_default_ends(void **state)
{
    (void)state;
    run(one_that_blocks);
}

static const world_task *handled_in;

static void note_task(int number)
{
    (void)number;
    handled_in = world_task_self();
}

static void *take_signals(void *argument)
{
    sigset_t usr1;
    (void)sigemptyset(&usr1);
    (void)sigaddset(&usr1, SIGUSR1);
    (void)world_call_pthread_sigmask(SIG_UNBLOCK, &usr1, NULL);
    *(const world_task **)argument = world_task_self();
    sleep_ns(5 * WORLD_S);
    return NULL;
}

static int leave_signals_to_a_thread(int argc, char **argv)
{
    const world_task *task = NULL;
    pthread_t thread;
    sigset_t all;
    (void)argv;
    handle(SIGUSR1, note_task, 0);
    (void)sigfillset(&all);
    (void)world_call_pthread_sigmask(SIG_BLOCK, &all, NULL);
    (void)world_call_pthread_create(&thread, NULL, take_signals, &task);
    sleep_ns(2 * WORLD_S);
    assert_non_null(task);
    assert_ptr_equal(handled_in, task);
    return argc - 1 + world_call_pthread_join(thread, NULL);
}

static void one_with_a_thread_for_signals(void)
{
    world_process *process = start(leave_signals_to_a_thread);
    (void)world_process_wait(process, WORLD_S);
    world_process_signal(process, SIGUSR1);
    assert_int_equal(status_of(process), 0);
}

static void a_thread_that_does_not_block_a_signal_takes_it(void **state)
{
    (void)state;
    run(one_with_a_thread_for_signals);
}

static void one_that_is_stopped(void)
{
    world_process *process = start(count_turns);
    world_process_signal(process, SIGSTOP);
    assert_false(world_process_wait(process, WORLD_S));
    world_process_signal(process, SIGUSR1); /* for when it goes on */
    assert_false(world_process_wait(process, 2 * WORLD_S));
    world_process_signal(process, SIGCONT);
    assert_int_equal(status_of(process), SIGUSR1);
    assert_true(process->ended_ns >= 2 * WORLD_S);
}

static void a_process_that_is_stopped_does_nothing_until_it_goes_on(
    void **state)
{
    (void)state;
    run(one_that_is_stopped);
}

static int ring_thrice(int argc, char **argv)
{
    const struct itimerval timer = {.it_value = {.tv_usec = 50000},
                                    .it_interval = {.tv_usec = 20000}};
    (void)argv;
    handle(SIGALRM, note, 0);
    assert_int_equal(world_call_setitimer(ITIMER_REAL, &timer, NULL), 0);
    while (found[1] < 3) {
        sleep_ns(WORLD_S);
    }
    found_ns[0] = world_now();
    return argc - 1;
}

static void one_that_rings(void)
{
    assert_int_equal(status_of(start(ring_thrice)), 0);
    assert_in_range(found_ns[0], 90 * WORLD_MS, 91 * WORLD_MS);
}

static void a_timer_rings_at_its_times(void **state)
{
    (void)state;
    run(one_that_rings);
}

/* --- clocks and options --- */

static int read_clocks(int argc, char **argv)
{
    struct timespec before;
    struct timespec after;
    (void)argv;
    (void)world_call_clock_gettime(CLOCK_MONOTONIC, &before);
    before.tv_sec += 100;
    assert_int_equal(world_call_clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME,
                                                &before, NULL),
                     0);
    (void)world_call_clock_gettime(CLOCK_MONOTONIC, &after);
    found_ns[0] = (int64_t)(after.tv_sec - before.tv_sec);
    found_ns[1] = world_now();
    assert_int_equal(world_call_clock_gettime(99, &after), -1);
    assert_int_equal(errno, EINVAL);
    return argc - 1;
}

static void one_with_a_clock_that_is_slow(void)
{
    world_host_set_drift(host, -100000000); /* a tenth */
    assert_int_equal(status_of(start(read_clocks)), 0);
    assert_int_equal(found_ns[0], 0);
    assert_in_range(found_ns[1], 111 * WORLD_S, 112 * WORLD_S);
}

static void a_sleep_is_by_the_clock_of_its_host(void **state)
{
    (void)state;
    run(one_with_a_clock_that_is_slow);
}

static int read_options(int argc, char **argv)
{
    static const struct option named[] = {
        {"rate", required_argument, NULL, 256},
        {"rating", no_argument, NULL, 257},
        {"quiet", no_argument, NULL, 'q'},
        {NULL, 0, NULL, 0}};
    static char *words[] = {"program", "--rate=5", "-qn3",   "--quiet=1",
                            "--rat",   "--rate",   "-x",     "--rati",
                            "-n",      "7",        "--rate", NULL};
    static const int wanted[] = {256, 'q', 'n', '?', '?',
                                 256, 257, 'n', ':', -1};
    (void)argv;
    world_call_opterr = 0;
    world_call_optind = 0;
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        const int option =
            world_call_getopt_long(11, words, "+:qn:", named, NULL);
        assert_int_equal(option, wanted[i]);
        if (option == 256 || option == 'n') {
            found_text[found_count++] = world_call_optarg;
        }
    }
    return argc - 1;
}

static void one_with_options(void)
{
    assert_int_equal(status_of(start(read_options)), 0);
    assert_int_equal(found_count, 4);
    assert_string_equal(found_text[0], "5");
    assert_string_equal(found_text[1], "3");
    assert_string_equal(found_text[2], "-x");
    assert_string_equal(found_text[3], "7");
}

static void options_are_read_as_getopt_long_does(void **state)
{
    (void)state;
    run(one_with_options);
}

int main(void)
{
    static const world_image image = {
        "program", program_main, __start_program_data, __stop_program_data};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_process_has_static_data_of_its_own),
        cmocka_unit_test(
            arguments_and_environment_are_given_and_the_status_taken),
        cmocka_unit_test(memory_is_freed_with_a_process_that_is_killed),
        cmocka_unit_test(
            a_stack_is_the_same_under_a_seed_and_differs_between_seeds),
        cmocka_unit_test(what_a_program_writes_is_in_the_digest),
        cmocka_unit_test(what_was_met_within_five_seconds_is_near),
        cmocka_unit_test(one_thread_at_a_time_has_a_mutex),
        cmocka_unit_test(a_condition_is_waited_for_until_it_comes_or_in_vain),
        cmocka_unit_test(a_handler_ends_a_sleep),
        cmocka_unit_test(a_signal_that_is_blocked_waits_and_the_default_ends),
        cmocka_unit_test(a_thread_that_does_not_block_a_signal_takes_it),
        cmocka_unit_test(
            a_process_that_is_stopped_does_nothing_until_it_goes_on),
        cmocka_unit_test(a_timer_rings_at_its_times),
        cmocka_unit_test(a_sleep_is_by_the_clock_of_its_host),
        cmocka_unit_test(options_are_read_as_getopt_long_does),
    };
    world_process_images(&image, 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
