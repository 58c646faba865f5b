#define _GNU_SOURCE
#include "bench.h"

#include "kernel/disk_calls.h"
#include "kernel/file_calls.h"
#include "kernel/pipe.h"
#include "kernel/signal_calls.h"
#include "kernel/terminal.h"
#include "kernel/thread_calls.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#define PIPE_BYTES 65536

/* A call fails with this errno. */
#define refuses(call, code)                                                    \
    do {                                                                       \
        errno = 0;                                                             \
        assert_true((call) < 0);                                               \
        assert_int_equal(errno, code);                                         \
    } while (0)

static world_reader *reader;
static world_writer *writer;
static world_terminal *terminal;
static int64_t ended_ns; /* of what a program did */

static world_disk *disk(void)
{
    return world_disk_of(host);
}

static short look(int fd, short events)
{
    struct pollfd one = {.fd = fd, .events = events};
    assert_true(world_call_poll(&one, 1, 0) >= 0);
    return one.revents;
}

static void ignore(int number)
{
    const struct sigaction action = {.sa_handler = SIG_IGN};
    assert_int_equal(world_call_sigaction(number, &action, NULL), 0);
}

/* --- between tasks --- */

static int fill_pipe(void)
{
    static char bytes[PIPE_BYTES];
    int ends[2];
    int held = 0;
    assert_int_equal(world_call_pipe2(ends, O_NONBLOCK | O_CLOEXEC), 0);
    refuses(world_call_read(ends[0], bytes, 1), EAGAIN);
    assert_int_equal(look(ends[0], POLLIN), 0);
    assert_int_equal(look(ends[1], POLLOUT), POLLOUT);
    assert_int_equal(world_call_write(ends[1], bytes, 100), 100);
    assert_int_equal(world_call_write(ends[1], bytes, sizeof bytes),
                     PIPE_BYTES - 4096);
    assert_int_equal(look(ends[1], POLLOUT), 0);
    refuses(world_call_write(ends[1], bytes, 4096), EAGAIN);
    /* As Linux: behind the last bytes there is none, before them there was. */
    refuses(world_call_write(ends[1], bytes, 1), EAGAIN);
    assert_int_equal(world_call_ioctl(ends[0], FIONREAD, &held), 0);
    assert_int_equal(held, PIPE_BYTES - 4096 + 100);
    assert_int_equal(world_call_read(ends[0], bytes, 99), 99);
    assert_int_equal(look(ends[1], POLLOUT), 0);
    assert_int_equal(world_call_read(ends[0], bytes, 1), 1);
    assert_int_equal(look(ends[1], POLLOUT), POLLOUT);
    assert_int_equal(world_call_write(ends[1], bytes, 5000), 4096);
    refuses(world_call_lseek64(ends[0], 0, SEEK_CUR), ESPIPE);
    refuses(world_call_fsync(ends[0]), EINVAL);
    assert_int_equal(world_call_close(ends[1]), 0);
    assert_int_equal(look(ends[0], POLLIN), POLLIN | POLLHUP);
    while (world_call_read(ends[0], bytes, sizeof bytes) > 0) {
    }
    assert_int_equal(world_call_read(ends[0], bytes, 1), 0);
    assert_int_equal(look(ends[0], POLLIN), POLLHUP);
    return 0;
}

static void run_fill(void)
{
    bench_do(fill_pipe);
}

static void a_pipe_holds_what_one_of_linux_does(void **state)
{
    (void)state;
    bench_run(run_fill);
}

static void *read_late(void *argument)
{
    char bytes[8];
    bench_pause(WORLD_S);
    assert_int_equal(world_call_read(*(const int *)argument, bytes, 8), 2);
    return NULL;
}

static int write_to_thread(void)
{
    int ends[2];
    pthread_t thread;
    assert_int_equal(world_call_pipe(ends), 0);
    assert_int_equal(
        world_call_pthread_create(&thread, NULL, read_late, &ends[0]), 0);
    assert_int_equal(world_call_write(ends[1], "ab", 2), 2);
    while (look(ends[0], POLLIN) != 0) {
        bench_pause(WORLD_MS);
    }
    assert_true(world_now() >= WORLD_S);
    assert_int_equal(world_call_pthread_join(thread, NULL), 0);
    return 0;
}

static void run_threads(void)
{
    bench_do(write_to_thread);
}

static void one_thread_writes_what_another_reads(void **state)
{
    (void)state;
    bench_run(run_threads);
}

static int close_both(void)
{
    int ends[2];
    char byte;
    assert_int_equal(world_call_pipe(ends), 0);
    assert_int_equal(world_call_dup2(ends[1], ends[0]), ends[0]);
    ignore(SIGPIPE);
    assert_int_equal(look(ends[1], POLLOUT), POLLOUT | POLLERR);
    refuses(world_call_write(ends[1], "x", 1), EPIPE);
    refuses(world_call_read(ends[1], &byte, 1), EBADF);
    refuses(world_call_write(99, "x", 1), EBADF);
    assert_int_equal(look(99, POLLIN), POLLNVAL);
    assert_int_equal(world_call_fcntl64(ends[1], F_DUPFD_CLOEXEC, 77), 77);
    assert_int_equal(world_call_fcntl64(77, F_GETFD), FD_CLOEXEC);
    assert_int_equal(world_call_fcntl64(77, F_SETFL, O_NONBLOCK), 0);
    assert_int_equal(world_call_fcntl64(ends[1], F_GETFL),
                     O_WRONLY | O_NONBLOCK);
    return 0;
}

static int write_to_nobody(void)
{
    int ends[2];
    assert_int_equal(world_call_pipe(ends), 0);
    assert_int_equal(world_call_close(ends[0]), 0);
    (void)world_call_write(ends[1], "x", 1);
    return 0;
}

static void run_broken(void)
{
    bench_do(close_both);
    const int status =
        bench_wait(bench_start(write_to_nobody, NULL, NULL, NULL));
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGPIPE);
}

static void a_pipe_without_a_reader_is_broken(void **state)
{
    (void)state;
    bench_run(run_broken);
}

/* --- waits --- */

static volatile sig_atomic_t rung;

static void ring(int number)
{
    (void)number;
    rung = 1;
}

static int wait_in_vain(void)
{
    int ends[2];
    char byte;
    const struct sigaction action = {.sa_handler = ring};
    assert_int_equal(world_call_pipe(ends), 0);
    struct pollfd set[2] = {{.fd = ends[0], .events = POLLIN},
                            {.fd = -1, .events = POLLIN}};
    const int64_t before = world_now();
    assert_int_equal(world_call_poll(set, 2, 250), 0);
    assert_true(world_now() >= before + 250 * WORLD_MS);
    assert_true(world_now() < before + 251 * WORLD_MS);
    assert_int_equal(world_call_sigaction(SIGUSR1, &action, NULL), 0);
    const struct timespec wait = {.tv_sec = 100};
    refuses(world_call_ppoll(set, 2, &wait, NULL), EINTR);
    assert_int_equal(rung, 1);
    refuses(world_call_read(ends[0], &byte, 1), EINTR);
    ended_ns = world_now();
    return 0;
}

static void run_waits(void)
{
    rung = 0;
    world_process *p = bench_start(wait_in_vain, NULL, NULL, NULL);
    bench_pause(5 * WORLD_S);
    world_process_signal(p, SIGUSR1);
    bench_pause(5 * WORLD_S);
    world_process_signal(p, SIGUSR1);
    assert_int_equal(bench_wait(p), 0);
    assert_true(ended_ns >= 10 * WORLD_S && ended_ns < 11 * WORLD_S);
}

static void waits_end_in_time_or_with_a_signal(void **state)
{
    (void)state;
    bench_run(run_waits);
}

/* --- the user's ends --- */

static int copy_input(void)
{
    char bytes[1000];
    ssize_t n = 0;
    while ((n = world_call_read(STDIN_FILENO, bytes, sizeof bytes)) > 0) {
        assert_int_equal(world_call_write(STDOUT_FILENO, bytes, (size_t)n), n);
    }
    return n == 0 ? 0 : 1;
}

static void run_ends(void)
{
    world_file *in = NULL;
    world_file *out = NULL;
    char bytes[200000];
    size_t size = 0;
    memset(bytes, 'b', sizeof bytes);
    writer = world_writer_new(&in);
    reader = world_reader_new("copy", &out);
    world_process *copy = bench_start(copy_input, in, out, NULL);
    world_writer_say(writer, "a line\n");
    while (strcmp(world_reader_text(reader, NULL), "a line\n") != 0) {
        (void)world_wait(world_reader_came(reader), WORLD_NEVER);
    }
    world_reader_pace(reader, 0);
    world_writer_put(writer, bytes, sizeof bytes);
    assert_false(world_process_wait(copy, 50 * WORLD_S));
    assert_int_equal(strlen(world_reader_text(reader, NULL)), 7);
    assert_true(world_writer_left(writer) > 0);
    world_reader_pace(reader, 10000);
    world_writer_close(writer);
    assert_int_equal(bench_wait(copy), 0);
    while (!world_reader_has_ended(reader)) {
        (void)world_wait(world_reader_came(reader), WORLD_NEVER);
    }
    assert_true(world_now() >= 69 * WORLD_S && world_now() < 80 * WORLD_S);
    (void)world_reader_text(reader, &size);
    assert_int_equal(size, 7 + sizeof bytes);
}

static void the_user_reads_and_writes_as_slowly_as_it_likes(void **state)
{
    (void)state;
    bench_run(run_ends);
}

static int say_for_ever(void)
{
    while (world_call_write(STDOUT_FILENO, "x", 1) == 1) {
        bench_pause(WORLD_MS);
    }
    return 0;
}

static void run_close(void)
{
    world_file *out = NULL;
    reader = world_reader_new("x", &out);
    world_process *p = bench_start(say_for_ever, NULL, out, NULL);
    bench_pause(WORLD_S);
    world_reader_close(reader);
    assert_int_equal(WTERMSIG(bench_wait(p)), SIGPIPE);
    assert_true(world_reader_has_ended(reader));
    assert_true(strlen(world_reader_text(reader, NULL)) > 900);
    reader = world_reader_new("x", &out);
    p = bench_start(say_for_ever, NULL, out, NULL);
    bench_pause(WORLD_S);
    world_process_signal(p, SIGKILL);
    (void)bench_wait(p);
    bench_pause(WORLD_MS);
    assert_true(world_reader_has_ended(reader));
}

static void an_end_that_goes_is_noticed_at_the_other(void **state)
{
    (void)state;
    bench_run(run_close);
}

/* --- fifos --- */

static int open_fifos(void)
{
    char bytes[8];
    refuses(world_call_open64("in", O_WRONLY | O_NONBLOCK), ENXIO);
    const int early = world_call_open64("in", O_RDONLY | O_NONBLOCK);
    assert_true(early >= 0);
    assert_int_equal(look(early, POLLIN), 0);
    assert_int_equal(world_call_read(early, bytes, 8), 0);
    assert_int_equal(world_call_close(early), 0);
    const int64_t before = world_now();
    const int in = world_call_open64("in", O_RDONLY);
    assert_true(world_now() > before + WORLD_S / 2);
    assert_int_equal(world_call_read(in, bytes, 8), 5);
    assert_memory_equal(bytes, "hello", 5);
    assert_int_equal(world_call_read(in, bytes, 8), 0);
    assert_int_equal(look(in, POLLIN), POLLHUP);
    const int out = world_call_open64("out", O_WRONLY);
    assert_int_equal(world_call_write(out, "bye\n", 4), 4);
    struct stat status;
    assert_int_equal(world_call_fstat64(out, &status), 0);
    assert_true(S_ISFIFO(status.st_mode));
    return 0;
}

static void run_fifos(void)
{
    world_disk_make_fifo(disk(), "/home/in");
    world_disk_make_fifo(disk(), "/home/out");
    world_process *p = bench_start(open_fifos, NULL, NULL, NULL);
    bench_pause(WORLD_S);
    writer = world_writer_of_fifo(disk(), "/home/in");
    world_writer_say(writer, "hello");
    bench_pause(WORLD_S);
    world_writer_close(writer);
    bench_pause(WORLD_S);
    assert_false(p->has_ended);
    reader = world_reader_of_fifo(disk(), "/home/out");
    assert_int_equal(bench_wait(p), 0);
    bench_pause(WORLD_MS);
    assert_string_equal(world_reader_text(reader, NULL), "bye\n");
    assert_true(world_reader_has_ended(reader));
}

static void a_fifo_waits_for_its_other_side(void **state)
{
    (void)state;
    bench_run(run_fifos);
}

static int wait_for_reader(void)
{
    (void)world_call_open64("out", O_WRONLY);
    return 1;
}

static void run_killed_fifo(void)
{
    world_disk_make_fifo(disk(), "/home/out");
    world_process *p = bench_start(wait_for_reader, NULL, NULL, NULL);
    bench_pause(WORLD_S);
    world_process_signal(p, SIGKILL);
    (void)bench_wait(p);
    reader = world_reader_of_fifo(disk(), "/home/out");
    bench_pause(WORLD_S);
    assert_false(world_reader_has_ended(reader)); /* nobody writes yet */
    p = bench_start(wait_for_reader, NULL, NULL, NULL);
    assert_int_equal(WEXITSTATUS(bench_wait(p)), 1);
    bench_pause(WORLD_MS);
    assert_true(world_reader_has_ended(reader));
}

static void whoever_is_killed_while_opening_leaves_nothing(void **state)
{
    (void)state;
    bench_run(run_killed_fifo);
}

/* --- terminals --- */

static int talk(void)
{
    char line[64];
    struct winsize size;
    assert_int_equal(world_call_isatty(STDIN_FILENO), 1);
    assert_int_equal(world_call_ioctl(STDERR_FILENO, TIOCGWINSZ, &size), 0);
    assert_int_equal(size.ws_col, 100);
    assert_int_equal(world_call_tcgetpgrp(STDIN_FILENO),
                     world_process_self()->group);
    assert_int_equal(look(STDIN_FILENO, POLLIN), 0);
    const ssize_t n = world_call_read(STDIN_FILENO, line, sizeof line);
    assert_int_equal(n, 6);
    assert_int_equal(world_call_write(STDOUT_FILENO, line, 6), 6);
    assert_int_equal(world_call_read(STDIN_FILENO, line, sizeof line), 0);
    (void)world_call_read(STDIN_FILENO, line, sizeof line);
    return 0;
}

static world_process *start_at_terminal(int (*program)(void))
{
    terminal = world_terminal_new("tty");
    world_terminal_set_size(terminal, 100, 30);
    world_process *p = bench_start(program, world_terminal_file(terminal),
                                   world_terminal_file(terminal),
                                   world_terminal_file(terminal));
    world_terminal_set_foreground(terminal, p->group);
    return p;
}

static void run_terminal(void)
{
    world_process *p = start_at_terminal(talk);
    bench_pause(WORLD_S);
    world_terminal_type(terminal, "hell");
    bench_pause(WORLD_S);
    world_terminal_type(terminal, "o\n\4");
    bench_pause(WORLD_S);
    assert_string_equal(world_terminal_text(terminal, NULL), "hello\nhello\n");
    assert_false(p->has_ended);
    world_terminal_type(terminal, "\3");
    assert_int_equal(WTERMSIG(bench_wait(p)), SIGINT);
}

static void a_terminal_has_lines_and_keys(void **state)
{
    (void)state;
    bench_run(run_terminal);
}

static int ask_in_background(void)
{
    char line[8];
    assert_int_equal(world_call_write(STDOUT_FILENO, "!", 1), 1);
    assert_int_equal(world_call_read(STDIN_FILENO, line, sizeof line), 3);
    assert_int_equal(world_call_read(STDIN_FILENO, line, sizeof line), 0);
    refuses(world_call_write(STDOUT_FILENO, "!", 1), EIO);
    return 0;
}

static void run_background(void)
{
    world_process *p = start_at_terminal(ask_in_background);
    world_terminal_set_foreground(terminal, 0);
    world_terminal_type(terminal, "hi\n");
    bench_pause(WORLD_S);
    assert_true(p->is_stopped);
    world_terminal_type(terminal, "\3");
    world_terminal_set_foreground(terminal, p->group);
    world_process_signal(p, SIGCONT);
    bench_pause(WORLD_S);
    assert_false(p->has_ended);
    world_terminal_set_foreground(terminal, p->group);
    world_terminal_hang_up(terminal);
    assert_int_equal(WTERMSIG(bench_wait(p)), SIGHUP);
}

static void whoever_reads_in_the_background_is_stopped(void **state)
{
    (void)state;
    bench_run(run_background);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pipe_holds_what_one_of_linux_does),
        cmocka_unit_test(one_thread_writes_what_another_reads),
        cmocka_unit_test(a_pipe_without_a_reader_is_broken),
        cmocka_unit_test(waits_end_in_time_or_with_a_signal),
        cmocka_unit_test(the_user_reads_and_writes_as_slowly_as_it_likes),
        cmocka_unit_test(an_end_that_goes_is_noticed_at_the_other),
        cmocka_unit_test(a_fifo_waits_for_its_other_side),
        cmocka_unit_test(whoever_is_killed_while_opening_leaves_nothing),
        cmocka_unit_test(a_terminal_has_lines_and_keys),
        cmocka_unit_test(whoever_reads_in_the_background_is_stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
