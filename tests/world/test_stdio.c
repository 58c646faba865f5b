#define _GNU_SOURCE
#include "bench.h"

#include "kernel/disk_calls.h"
#include "kernel/file_calls.h"
#include "kernel/pipe.h"
#include "kernel/signal_calls.h"
#include "kernel/stdio_calls.h"
#include "kernel/terminal.h"
#include "kernel/thread_calls.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define out world_call_stdout
#define in  world_call_stdin
#define err world_call_stderr

static world_reader *printed, *complained;

static world_disk *disk(void)
{
    return world_disk_of(host);
}

/* A program whose output and errors the user reads. */
static world_process *start(int (*program)(void), world_file *input)
{
    world_file *output = NULL;
    world_file *error = NULL;
    printed = world_reader_new("out", &output);
    complained = world_reader_new("err", &error);
    return bench_start(program, input, output, error);
}

static void printed_is(const char *text)
{
    bench_pause(WORLD_MS);
    assert_string_equal(world_reader_text(printed, NULL), text);
}

/* --- buffers --- */

static int print_and_wait(void)
{
    assert_int_equal(world_call_printf("%d and %s\n", 1, "two"), 10);
    assert_int_equal(world_call_puts("three"), 6);
    assert_int_equal(world_call_fputs("four", out), 1);
    assert_int_equal(world_call_putc('5', out), '5');
    assert_int_equal(world_call_fwrite("67", 1, 2, out), 2);
    assert_true(world_call_fprintf(err, "seen at once") > 0);
    bench_pause(10 * WORLD_S);
    assert_int_equal(world_call_fflush(out), 0);
    bench_pause(10 * WORLD_S);
    (void)world_call_printf("last");
    return 0;
}

#define ALL "1 and two\nthree\nfour567"

static void run_print(void)
{
    world_process *p = start(print_and_wait, NULL);
    bench_pause(5 * WORLD_S);
    printed_is("");
    assert_string_equal(world_reader_text(complained, NULL), "seen at once");
    bench_pause(10 * WORLD_S);
    printed_is(ALL);
    assert_int_equal(bench_wait(p), 0);
    printed_is(ALL "last");
    p = start(print_and_wait, NULL);
    bench_pause(5 * WORLD_S);
    world_process_signal(p, SIGTERM);
    (void)bench_wait(p);
    printed_is("");
}

static void what_is_printed_waits_for_a_flush_or_the_exit(void **state)
{
    (void)state;
    bench_run(run_print);
}

static int print_lines(void)
{
    (void)world_call_printf("a line\nand a half");
    bench_pause(10 * WORLD_S);
    return 0;
}

static int print_lines_anywhere(void)
{
    assert_int_equal(world_call_setvbuf(out, NULL, _IOLBF, 0), 0);
    return print_lines();
}

static int print_unbuffered(void)
{
    assert_int_equal(world_call_setvbuf(out, NULL, _IONBF, 0), 0);
    return print_lines();
}

static void run_lines(void)
{
    world_terminal *terminal = world_terminal_new("tty");
    world_process *p =
        bench_start(print_lines, NULL, world_terminal_file(terminal), NULL);
    bench_pause(5 * WORLD_S);
    assert_string_equal(world_terminal_text(terminal, NULL), "a line\n");
    assert_int_equal(bench_wait(p), 0);
    assert_string_equal(world_terminal_text(terminal, NULL),
                        "a line\nand a half");
    p = start(print_lines_anywhere, NULL);
    bench_pause(5 * WORLD_S);
    printed_is("a line\n");
    (void)bench_wait(p);
    p = start(print_unbuffered, NULL);
    bench_pause(5 * WORLD_S);
    printed_is("a line\nand a half");
    (void)bench_wait(p);
}

static void a_terminal_is_printed_to_by_lines(void **state)
{
    (void)state;
    bench_run(run_lines);
}

static int print_much(void)
{
    static char bytes[10000];
    memset(bytes, 'm', sizeof bytes);
    assert_int_equal(world_call_fwrite(bytes, 1, 10, out), 10);
    assert_int_equal(world_call_fwrite(bytes, 100, 100, out), 100);
    bench_pause(10 * WORLD_S);
    return 0;
}

static void run_much(void)
{
    size_t size = 0;
    world_process *p = start(print_much, NULL);
    bench_pause(5 * WORLD_S);
    (void)world_reader_text(printed, &size);
    assert_int_equal(size, 8192); /* whole buffers */
    assert_int_equal(bench_wait(p), 0);
    bench_pause(WORLD_MS);
    (void)world_reader_text(printed, &size);
    assert_int_equal(size, 10010);
}

static void whole_buffers_do_not_wait(void **state)
{
    (void)state;
    bench_run(run_much);
}

/* --- errors --- */

static int print_in_vain(void)
{
    const struct sigaction action = {.sa_handler = SIG_IGN};
    assert_int_equal(world_call_sigaction(SIGPIPE, &action, NULL), 0);
    assert_true(world_call_printf("x") == 1);
    assert_int_equal(world_call_fflush(out), EOF);
    assert_int_equal(errno, EPIPE);
    assert_true(world_call_ferror(out) != 0);
    world_call_clearerr(out);
    assert_int_equal(world_call_ferror(out), 0);
    assert_int_equal(world_call_fflush(out), 0); /* it is forgotten */
    FILE *full = world_call_fopen64("/dev/full", "w");
    assert_int_equal(world_call_fputs("x", full), 1);
    assert_int_equal(world_call_fclose(full), EOF);
    assert_int_equal(errno, ENOSPC);
    assert_null(world_call_fopen64("none", "r"));
    assert_int_equal(errno, ENOENT);
    world_call_perror("none");
    assert_null(world_call_fdopen(99, "w"));
    assert_int_equal(errno, EBADF);
    const int fd = world_call_open64("/dev/null", O_RDONLY);
    assert_null(world_call_fdopen(fd, "w"));
    assert_int_equal(errno, EINVAL);
    return 0;
}

static void run_in_vain(void)
{
    world_process *p = start(print_in_vain, NULL);
    world_reader_close(printed);
    assert_int_equal(bench_wait(p), 0);
    bench_pause(WORLD_MS);
    assert_string_equal(world_reader_text(complained, NULL),
                        "none: No such file or directory\n");
}

static void what_cannot_be_written_is_an_error_of_its_stream(void **state)
{
    (void)state;
    bench_run(run_in_vain);
}

/* --- files --- */

static int use_files(void)
{
    char line[16];
    char bytes[10000];
    FILE *f = world_call_fopen64("a", "w");
    assert_non_null(f);
    for (int i = 0; i < 2000; i++) {
        assert_true(world_call_fprintf(f, "%04d\n", i) == 5);
    }
    assert_int_equal(world_call_fclose(f), 0);
    f = world_call_fopen64("a", "r");
    assert_ptr_equal(world_call_fgets(line, 3, f), line);
    assert_string_equal(line, "00");
    assert_ptr_equal(world_call_fgets(line, sizeof line, f), line);
    assert_string_equal(line, "00\n");
    assert_int_equal(world_call_fread(bytes, 5, 1998, f), 1998);
    assert_memory_equal(bytes, "0001\n0002\n", 10);
    assert_memory_equal(bytes + 5 * 1997, "1998\n", 5);
    assert_int_equal(world_call_fread(bytes, 1, 100, f), 5);
    assert_true(world_call_feof(f) != 0);
    assert_null(world_call_fgets(line, sizeof line, f));
    assert_int_equal(world_call_ferror(f), 0);
    assert_int_equal(world_call_fclose(f), 0);
    f = world_call_tmpfile64();
    assert_int_equal(world_call_fputs("first\nsecond\n", f), 1);
    world_call_rewind(f);
    assert_ptr_equal(world_call_fgets(line, sizeof line, f), line);
    assert_string_equal(line, "first\n");
    assert_int_equal(world_call_ftell(f), 6);
    assert_int_equal(world_call_fclose(f), 0);
    return 0;
}

static int use_memory(void)
{
    char *text = NULL;
    size_t len = 0;
    FILE *f = world_call_open_memstream(&text, &len);
    for (int i = 0; i < 1000; i++) {
        assert_true(world_call_fprintf(f, "%03d", i) == 3);
    }
    assert_int_equal(world_call_fflush(f), 0);
    assert_int_equal(len, 3000);
    assert_memory_equal(text, "000001002", 9);
    assert_int_equal(world_call_putc('!', f), '!');
    assert_int_equal(world_call_fclose(f), 0);
    assert_int_equal(len, 3001);
    assert_string_equal(text + 2997, "999!");
    world_free(text);
    return 0;
}

static void run_files(void)
{
    bench_do(use_files);
    assert_int_equal(world_disk_size(disk(), "/home/a"), 10000);
    bench_do(use_memory);
}

static void files_are_read_as_they_were_written(void **state)
{
    (void)state;
    bench_run(run_files);
}

static int read_lines(void)
{
    char line[32];
    while (world_call_fgets(line, sizeof line, in) != NULL) {
        (void)world_call_printf("<%s", line);
        assert_int_equal(world_call_fflush(out), 0);
    }
    return world_call_feof(in) != 0 ? 0 : 1;
}

static void run_input(void)
{
    world_file *input = NULL;
    world_writer *writer = world_writer_new(&input);
    world_process *p = start(read_lines, input);
    world_writer_say(writer, "one\ntw");
    bench_pause(WORLD_S);
    printed_is("<one\n");
    world_writer_say(writer, "o\nend");
    world_writer_close(writer);
    assert_int_equal(bench_wait(p), 0);
    printed_is("<one\n<two\n<end");
}

static void lines_are_read_as_they_come(void **state)
{
    (void)state;
    bench_run(run_input);
}

/* --- threads --- */

static void *print_slowly(void *argument)
{
    for (int i = 0; i < 20; i++) {
        (void)world_call_fprintf(err, "%s%s%s\n", (const char *)argument,
                                 (const char *)argument,
                                 (const char *)argument);
    }
    return NULL;
}

static int print_from_two(void)
{
    static char first[1000];
    static char second[1000];
    pthread_t thread;
    memset(first, '1', sizeof first - 1u);
    memset(second, '2', sizeof second - 1u);
    assert_int_equal(
        world_call_pthread_create(&thread, NULL, print_slowly, second), 0);
    (void)print_slowly(first);
    assert_int_equal(world_call_pthread_join(thread, NULL), 0);
    return 0;
}

/* With little room in the pipe each write waits in its middle. */
static void run_two(void)
{
    world_process *p = start(print_from_two, NULL);
    world_reader_pace(complained, 20000);
    assert_int_equal(bench_wait(p), 0);
    while (!world_reader_has_ended(complained)) {
        (void)world_wait(world_reader_came(complained), WORLD_NEVER);
    }
    const char *line = world_reader_text(complained, NULL);
    unsigned lines = 0;
    for (; *line != '\0'; line = strchr(line, '\n') + 1) {
        assert_int_equal(strspn(line, *line == '1' ? "1" : "2"), 2997);
        lines++;
    }
    assert_int_equal(lines, 40);
}

static void two_threads_do_not_mix_their_lines(void **state)
{
    (void)state;
    bench_run(run_two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_printed_waits_for_a_flush_or_the_exit),
        cmocka_unit_test(a_terminal_is_printed_to_by_lines),
        cmocka_unit_test(whole_buffers_do_not_wait),
        cmocka_unit_test(what_cannot_be_written_is_an_error_of_its_stream),
        cmocka_unit_test(files_are_read_as_they_were_written),
        cmocka_unit_test(lines_are_read_as_they_come),
        cmocka_unit_test(two_threads_do_not_mix_their_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
