#define _GNU_SOURCE /* syscall */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cloud/sink.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <semaphore.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

static char directory[] = "/tmp/lum-sink-XXXXXX";

static const char *in_directory(const char *name)
{
    static char path[4][128];
    static unsigned turn;
    char *out = path[turn++ % 4u];
    snprintf(out, sizeof path[0], "%s/%s", directory, name);
    return out;
}

static int make_directory(void **state)
{
    (void)state;
    return mkdtemp(directory) == NULL;
}

static int remove_directory(void **state)
{
    (void)state;
    return rmdir(directory);
}

static bool exists(const char *name)
{
    struct stat status;
    return lstat(in_directory(name), &status) == 0;
}

/* Whether a file is under way. */
static bool has_part(void)
{
    bool found = false;
    const struct dirent *entry;
    DIR *all = opendir(directory);
    assert_non_null(all);
    while ((entry = readdir(all)) != NULL) {
        found = found || strstr(entry->d_name, ".part") != NULL;
    }
    closedir(all);
    return found;
}

static void put_file(const char *name, const char *text)
{
    FILE *file = fopen(in_directory(name), "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void expect_file(const char *name, const char *want)
{
    char got[256] = "";
    FILE *file = fopen(in_directory(name), "r");
    assert_non_null(file);
    got[fread(got, 1, sizeof got - 1u, file)] = '\0';
    fclose(file);
    assert_string_equal(got, want);
}

static lum_sink *open_sink(const char *path)
{
    lum_sink *sink = NULL;
    lum_error error = {""};
    assert_int_equal(lum_sink_open(path, &sink, &error), 0);
    assert_string_equal(error.text, "");
    return sink;
}

static void expect_refusal(const char *path, int code, const char *says)
{
    lum_sink *sink = NULL;
    lum_error error = {""};
    errno = 0;
    assert_int_equal(lum_sink_open(path, &sink, &error), -1);
    assert_int_equal(errno, code);
    assert_non_null(strstr(error.text, path));
    assert_non_null(strstr(error.text, says));
}

/* Byte i of the stream that the larger tests write. */
static char pattern(uint64_t i)
{
    return (char)((i * 2654435761u) >> 13 & 0x7f);
}

/* Append n bytes of the pattern, in pieces of odd sizes. */
static int put_pattern(lum_sink *sink, uint64_t n, lum_error *error)
{
    for (uint64_t i = 0; i < n;) {
        const size_t most = 1u + (size_t)(i % 70001u);
        const size_t now = n - i < most ? (size_t)(n - i) : most;
        char *p = lum_sink_reserve(sink, now, error);
        if (p == NULL) {
            return -1;
        }
        for (size_t j = 0; j < now; j++) {
            p[j] = pattern(i + j);
        }
        lum_sink_commit(sink, now);
        i += now;
    }
    return 0;
}

static void expect_pattern(int fd, uint64_t n)
{
    static char bytes[65536];
    uint64_t i = 0;
    for (ssize_t got = 1; got > 0;) {
        got = read(fd, bytes, sizeof bytes);
        assert_true(got >= 0);
        for (ssize_t j = 0; j < got; j++, i++) {
            if (bytes[j] != pattern(i)) {
                fail_msg("byte %llu differs", (unsigned long long)i);
            }
        }
    }
    assert_true(i == n);
}

static void a_file_has_its_name_only_when_it_is_whole(void **state)
{
    (void)state;
    lum_sink *sink = open_sink(in_directory("a"));
    assert_true(has_part());
    assert_false(exists("a"));
    assert_int_equal(lum_sink_write(sink, "hello", 5, NULL), 0);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    assert_false(has_part());
    expect_file("a", "hello");
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void an_abort_leaves_nothing_and_keeps_the_old_file(void **state)
{
    (void)state;
    put_file("a", "old");
    lum_sink *sink = open_sink(in_directory("a"));
    assert_int_equal(put_pattern(sink, 5000000, NULL), 0);
    lum_sink_abort(sink);
    assert_false(has_part());
    expect_file("a", "old");
    assert_int_equal(unlink(in_directory("a")), 0);
    lum_sink_abort(NULL);
}

static void a_link_stays_and_its_file_is_replaced(void **state)
{
    (void)state;
    put_file("real", "old");
    assert_int_equal(symlink("real", in_directory("link")), 0);
    lum_sink *sink = open_sink(in_directory("link"));
    assert_int_equal(lum_sink_write(sink, "new", 3, NULL), 0);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    expect_file("real", "new");
    assert_int_equal(unlink(in_directory("real")), 0);
    assert_int_equal(unlink(in_directory("link")), 0);
}

static void an_empty_output_is_an_empty_file(void **state)
{
    (void)state;
    assert_int_equal(lum_sink_close(open_sink(in_directory("a")), NULL), 0);
    expect_file("a", "");
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void the_mode_follows_the_umask(void **state)
{
    struct stat status;
    (void)state;
    const mode_t old = umask(027);
    assert_int_equal(lum_sink_close(open_sink(in_directory("a")), NULL), 0);
    umask(old);
    assert_int_equal(stat(in_directory("a"), &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void many_blocks_arrive_in_order(void **state)
{
    (void)state;
    const uint64_t n = 20u * LUM_SINK_BLOCK_BYTES + 12345u;
    lum_sink *sink = open_sink(in_directory("a"));
    assert_int_equal(put_pattern(sink, n, NULL), 0);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    const int fd = open(in_directory("a"), O_RDONLY);
    expect_pattern(fd, n);
    close(fd);
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void what_is_lent_stands_in_its_place(void **state)
{
    enum {
        LENT = 9000000,
        COPIED = 1000,
        EACH = LENT + COPIED
    };
    char *all = malloc(3u * EACH);
    (void)state;
    assert_non_null(all);
    for (uint64_t i = 0; i < 3u * EACH; i++) {
        all[i] = pattern(i);
    }
    lum_sink *sink = open_sink(in_directory("lent"));
    for (char *p = all; p < all + 3u * EACH; p += EACH) {
        assert_int_equal(lum_sink_lend(sink, p, LENT, NULL), 0);
        assert_int_equal(lum_sink_write(sink, p + LENT, COPIED, NULL), 0);
        assert_int_equal(lum_sink_settle(sink, NULL), 0);
        memset(p, 0, EACH); /* it is not read any more */
    }
    assert_int_equal(lum_sink_bytes(sink), 3 * EACH);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    free(all);
    const int fd = open(in_directory("lent"), O_RDONLY);
    expect_pattern(fd, 3u * EACH);
    assert_int_equal(close(fd), 0);
    assert_int_equal(unlink(in_directory("lent")), 0);
}

static void a_block_is_the_most_that_can_be_reserved(void **state)
{
    (void)state;
    lum_sink *sink = open_sink(in_directory("a"));
    for (int i = 0; i < 5; i++) {
        char *p = lum_sink_reserve(sink, LUM_SINK_BLOCK_BYTES, NULL);
        assert_non_null(p);
        assert_int_equal((uintptr_t)p % 4096u, 0);
        memset(p, 'x', LUM_SINK_BLOCK_BYTES);
        lum_sink_commit(sink, LUM_SINK_BLOCK_BYTES);
    }
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    struct stat status;
    assert_int_equal(stat(in_directory("a"), &status), 0);
    assert_true((uint64_t)status.st_size == 5u * LUM_SINK_BLOCK_BYTES);
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void a_patch_overwrites_what_was_written_before(void **state)
{
    (void)state;
    lum_sink *sink = open_sink(in_directory("a"));
    assert_true(lum_sink_seekable(sink));
    assert_int_equal(lum_sink_write(sink, "count 000 end", 13, NULL), 0);
    assert_int_equal(lum_sink_patch(sink, 6, "123", 3, NULL), 0);
    assert_int_equal(lum_sink_write(sink, ".", 1, NULL), 0);
    assert_int_equal(lum_sink_close(sink, NULL), 0);
    expect_file("a", "count 123 end.");
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void names_that_cannot_be_written_are_refused(void **state)
{
    (void)state;
    expect_refusal(in_directory("no/such"), ENOENT, "directory does not exist");
    expect_refusal(directory, EISDIR, "is a directory");
    put_file("file", "");
    expect_refusal(in_directory("file/x"), ENOTDIR, "Not a directory");
    assert_int_equal(unlink(in_directory("file")), 0);
}

static void a_full_disk_is_told_by_close(void **state)
{
    lum_error error = {""};
    (void)state;
    lum_sink *sink = open_sink("/dev/full");
    assert_false(lum_sink_seekable(sink));
    assert_int_equal(lum_sink_write(sink, "x", 1, &error), 0);
    assert_int_equal(lum_sink_close(sink, &error), -1);
    assert_int_equal(errno, ENOSPC);
    assert_non_null(strstr(error.text, "/dev/full: cannot write: No space"));
}

static void a_full_disk_stops_a_large_output(void **state)
{
    lum_error error = {""};
    (void)state;
    lum_sink *sink = open_sink("/dev/full");
    assert_int_equal(put_pattern(sink, 50000000, &error), -1);
    assert_int_equal(errno, ENOSPC);
    assert_int_equal(lum_sink_write(sink, "x", 1, NULL), 0);
    assert_int_equal(lum_sink_close(sink, &error), -1);
    assert_int_equal(errno, ENOSPC);
}

/* The default action of SIGPIPE is in force here: it would kill us. */
static void a_reader_that_leaves_is_an_error_and_no_death(void **state)
{
    int ends[2];
    char name[32];
    lum_error error = {""};
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    lum_sink *sink = open_sink(name);
    close(ends[0]);
    assert_int_equal(put_pattern(sink, 50000000, &error), -1);
    assert_int_equal(errno, EPIPE);
    lum_sink_abort(sink);
    close(ends[1]);
}

static void an_abort_does_not_wait_for_a_reader_that_sleeps(void **state)
{
    int ends[2];
    char name[32];
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    lum_sink *sink = open_sink(name);
    alarm(600);
    assert_int_equal(put_pattern(sink, 5u * LUM_SINK_BLOCK_BYTES / 2u, NULL),
                     0);
    lum_sink_abort(sink);
    alarm(0);
    close(ends[0]);
    close(ends[1]);
}

static void a_flush_shows_what_was_appended(void **state)
{
    int ends[2];
    char name[32];
    char got[8] = "";
    lum_error error = {""};
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    lum_sink *sink = open_sink(name);
    assert_int_equal(lum_sink_flush(sink, &error), 0);
    assert_int_equal(lum_sink_write(sink, "line\n", 5, &error), 0);
    assert_int_equal(lum_sink_bytes(sink), 5);
    assert_int_equal(lum_sink_flush(sink, &error), 0);
    alarm(600);
    assert_int_equal(read(ends[0], got, sizeof got), 5);
    alarm(0);
    assert_memory_equal(got, "line\n", 5);
    assert_int_equal(lum_sink_close(sink, &error), 0);
    close(ends[0]);
    close(ends[1]);
}

/* Three blocks would be queued and the fourth flush wait, if a flush did not
 * leave a busy thread alone. */
static void a_flush_does_not_wait_for_a_reader_that_sleeps(void **state)
{
    int ends[2];
    char name[32];
    char bytes[65536] = "";
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    lum_sink *sink = open_sink(name);
    alarm(600);
    for (int i = 0; i < 10; i++) {
        assert_int_equal(lum_sink_write(sink, bytes, sizeof bytes, NULL), 0);
        assert_int_equal(lum_sink_flush(sink, NULL), 0);
    }
    alarm(0);
    lum_sink_abort(sink);
    close(ends[0]);
    close(ends[1]);
}

static void a_flush_tells_that_the_reader_has_left(void **state)
{
    int ends[2];
    char name[32];
    lum_error error = {""};
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    lum_sink *sink = open_sink(name);
    assert_int_equal(lum_sink_flush(sink, &error), 0);
    close(ends[0]);
    assert_int_equal(lum_sink_flush(sink, &error), -1);
    assert_int_equal(errno, EPIPE);
    lum_sink_abort(sink);
    close(ends[1]);
}

/* Run in a child whose standard output is fd. */
static int run_on_stdout(int fd, uint64_t n)
{
    lum_sink *sink = NULL;
    if (dup2(fd, STDOUT_FILENO) < 0 || lum_sink_open("-", &sink, NULL) != 0 ||
        put_pattern(sink, n, NULL) != 0 || lum_sink_close(sink, NULL) != 0) {
        return 1;
    }
    return fcntl(STDOUT_FILENO, F_GETFD) < 0; /* it stays open */
}

static void expect_child_succeeds(pid_t child)
{
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

/* Short writes and, as the pipe does not block, EAGAIN. */
static void a_slow_reader_gets_every_byte(void **state)
{
    const uint64_t n = 5000001;
    int ends[2];
    (void)state;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(fcntl(ends[1], F_SETFL, O_NONBLOCK), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        _exit(run_on_stdout(ends[1], n));
    }
    close(ends[1]);
    expect_pattern(ends[0], n);
    close(ends[0]);
    expect_child_succeeds(child);
}

/* Append a part of n bytes of the pattern, which begin at one of them. */
static int move_pattern(lum_sink *sink, lum_sink *part, uint64_t from, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const char byte = pattern(from + i);
        if (lum_sink_write(part, &byte, 1, NULL) != 0) {
            return -1;
        }
    }
    return lum_sink_move(sink, part, NULL);
}

/* Run in a child whose standard output is fd. */
static int move_to_stdout(int fd, uint64_t n)
{
    static const size_t sizes[] = {400000, 1, 1300000, 700000, 3000, 260000};
    lum_sink *sink = NULL;
    lum_sink *part = NULL;
    uint64_t i = 0;
    if (dup2(fd, STDOUT_FILENO) < 0 || lum_sink_open("-", &sink, NULL) != 0 ||
        lum_sink_open_memory("-", &part, NULL) != 0) {
        return 1;
    }
    for (unsigned k = 0; i < n; k++) {
        const size_t most = sizes[k % (sizeof sizes / sizeof sizes[0])];
        const size_t now = n - i < most ? (size_t)(n - i) : most;
        if (move_pattern(sink, part, i, now) != 0 ||
            lum_sink_bytes(sink) != i + now || lum_sink_bytes(part) != 0) {
            return 2;
        }
        i += now;
    }
    const bool waits = (fcntl(STDOUT_FILENO, F_GETFL) & O_NONBLOCK) == 0;
    lum_sink_abort(part);
    return lum_sink_close(sink, NULL) != 0 || !waits;
}

static void a_pipe_gets_parts_and_who_else_has_it_still_waits(void **state)
{
    const uint64_t n = 9000001;
    int ends[2];
    (void)state;
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        _exit(move_to_stdout(ends[1], n));
    }
    close(ends[1]);
    expect_pattern(ends[0], n);
    close(ends[0]);
    expect_child_succeeds(child);
}

/* Root may write everywhere, so it becomes nobody first. */
static int open_without_permission(void)
{
    lum_sink *sink = NULL;
    lum_error error = {""};
    if (geteuid() == 0 && setuid(65534) != 0) {
        return 1;
    }
    return lum_sink_open(in_directory("a"), &sink, &error) != -1 ||
           errno != EACCES || strstr(error.text, "cannot replace it") == NULL;
}

static void a_file_without_write_permission_is_kept(void **state)
{
    (void)state;
    put_file("a", "mine");
    assert_int_equal(chmod(in_directory("a"), 0444), 0);
    assert_int_equal(chmod(directory, 0777), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(open_without_permission());
    }
    expect_child_succeeds(child);
    expect_file("a", "mine");
    assert_int_equal(unlink(in_directory("a")), 0);
}

static int patch_on_stdout(int fd)
{
    lum_sink *sink = NULL;
    if (dup2(fd, STDOUT_FILENO) < 0 || lum_sink_open("-", &sink, NULL) != 0 ||
        !lum_sink_seekable(sink) || lum_sink_write(sink, "xyz", 3, NULL) != 0 ||
        lum_sink_patch(sink, 1, "Y", 1, NULL) != 0) {
        return 1;
    }
    return lum_sink_close(sink, NULL) != 0;
}

static void a_patch_counts_from_where_standard_output_stood(void **state)
{
    (void)state;
    const int fd = open(in_directory("a"), O_CREAT | O_RDWR, 0666);
    assert_int_equal(write(fd, "before ", 7), 7);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(patch_on_stdout(fd));
    }
    expect_child_succeeds(child);
    close(fd);
    expect_file("a", "before xYz");
    assert_int_equal(unlink(in_directory("a")), 0);
}

static int ask_append_on_stdout(int fd)
{
    lum_sink *sink = NULL;
    if (dup2(fd, STDOUT_FILENO) < 0 || lum_sink_open("-", &sink, NULL) != 0) {
        return 1;
    }
    const bool seekable = lum_sink_seekable(sink);
    lum_sink_abort(sink);
    return seekable;
}

/* Large writes, each of which waits to be let through. */
static struct {
    bool is_shut;
    sem_t entered;
    sem_t passes;
} gate;

/* In the place of the C library's. */
ssize_t write(int fd, const void *bytes, size_t n)
{
    if (gate.is_shut && n >= LUM_SINK_BLOCK_BYTES) {
        (void)sem_post(&gate.entered);
        (void)sem_wait(&gate.passes);
    }
    return (ssize_t)syscall(SYS_write, fd, bytes, n);
}

static void put_block(lum_sink *sink)
{
    char *bytes = lum_sink_reserve(sink, LUM_SINK_BLOCK_BYTES, NULL);
    assert_non_null(bytes);
    memset(bytes, 'x', LUM_SINK_BLOCK_BYTES);
    lum_sink_commit(sink, LUM_SINK_BLOCK_BYTES);
}

/* The thread has a block to write at each moment. */
static void a_busy_output_is_told_that_its_file_was_removed(void **state)
{
    lum_error error = {""};
    lum_sink *sink = NULL;
    (void)state;
    (void)sem_init(&gate.entered, 0, 0);
    (void)sem_init(&gate.passes, 0, 0);
    assert_int_equal(lum_sink_open_growing(in_directory("a"), &sink, NULL), 0);
    put_block(sink);
    assert_int_equal(lum_sink_patch(sink, 0, "", 0, &error), 0);
    assert_int_equal(lum_sink_check(sink, &error), 0);
    gate.is_shut = true;
    put_block(sink);
    put_block(sink);
    assert_non_null(lum_sink_reserve(sink, 1, &error));
    (void)sem_wait(&gate.entered);
    assert_int_equal(unlink(in_directory("a")), 0);
    (void)sem_post(&gate.passes);
    (void)sem_wait(&gate.entered);
    const int result = lum_sink_check(sink, &error);
    const int code = errno;
    gate.is_shut = false;
    (void)sem_post(&gate.passes);
    assert_int_equal(result, -1);
    assert_int_equal(code, ENOENT);
    assert_non_null(strstr(error.text, "was removed"));
    assert_int_equal(lum_sink_close(sink, &error), -1);
    assert_non_null(strstr(error.text, "put back"));
    assert_int_equal(unlink(in_directory("a")), 0);
}

static void an_output_opened_to_append_cannot_be_patched(void **state)
{
    (void)state;
    const int fd = open(in_directory("a"), O_CREAT | O_WRONLY | O_APPEND, 0666);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(ask_append_on_stdout(fd));
    }
    expect_child_succeeds(child);
    close(fd);
    assert_int_equal(unlink(in_directory("a")), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_has_its_name_only_when_it_is_whole),
        cmocka_unit_test(an_abort_leaves_nothing_and_keeps_the_old_file),
        cmocka_unit_test(a_link_stays_and_its_file_is_replaced),
        cmocka_unit_test(an_empty_output_is_an_empty_file),
        cmocka_unit_test(the_mode_follows_the_umask),
        cmocka_unit_test(many_blocks_arrive_in_order),
        cmocka_unit_test(what_is_lent_stands_in_its_place),
        cmocka_unit_test(a_block_is_the_most_that_can_be_reserved),
        cmocka_unit_test(a_patch_overwrites_what_was_written_before),
        cmocka_unit_test(names_that_cannot_be_written_are_refused),
        cmocka_unit_test(a_file_without_write_permission_is_kept),
        cmocka_unit_test(a_full_disk_is_told_by_close),
        cmocka_unit_test(a_full_disk_stops_a_large_output),
        cmocka_unit_test(a_reader_that_leaves_is_an_error_and_no_death),
        cmocka_unit_test(an_abort_does_not_wait_for_a_reader_that_sleeps),
        cmocka_unit_test(a_flush_shows_what_was_appended),
        cmocka_unit_test(a_flush_does_not_wait_for_a_reader_that_sleeps),
        cmocka_unit_test(a_flush_tells_that_the_reader_has_left),
        cmocka_unit_test(a_slow_reader_gets_every_byte),
        cmocka_unit_test(a_pipe_gets_parts_and_who_else_has_it_still_waits),
        cmocka_unit_test(a_busy_output_is_told_that_its_file_was_removed),
        cmocka_unit_test(a_patch_counts_from_where_standard_output_stood),
        cmocka_unit_test(an_output_opened_to_append_cannot_be_patched),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
