#define _DEFAULT_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumctl/file_writer.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define HEADER "time,value\n"
#define RUNS   4
#define ROWS   200

static char folder[] = "/tmp/lum-writer-XXXXXX";

static const char *in_folder(const char *name)
{
    static char path[64];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static const char *read_file(const char *path)
{
    static char text[65536];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    return text;
}

static struct file_writer *begin(const char *rows, const char *page)
{
    lum_error error = {""};
    struct file_writer *writer = file_writer_new(rows, HEADER, page, &error);
    assert_string_equal(error.text, "");
    assert_non_null(writer);
    return writer;
}

static void end(struct file_writer *writer, uint64_t lost, bool page_failed)
{
    const struct file_writer_rest rest = file_writer_end(writer);
    assert_int_equal(rest.lost, lost);
    assert_int_equal(rest.page_failed, page_failed);
    assert_false(rest.hangs);
}

static void lines_follow_one_header(void **state)
{
    const char *path = in_folder("a");
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct file_writer *writer = begin(path, NULL);
        file_writer_add(writer, "1,a\n");
        file_writer_add(writer, "2,b\n");
        end(writer, 0, false);
    }
    assert_string_equal(read_file(path), HEADER "1,a\n2,b\n1,a\n2,b\n");
}

static void half_a_line_is_cut_off(void **state)
{
    const char *path = in_folder("half");
    (void)state;
    write_file(path, HEADER "1,a\n2,");
    struct file_writer *writer = begin(path, NULL);
    file_writer_add(writer, "3,c\n");
    end(writer, 0, false);
    assert_string_equal(read_file(path), HEADER "1,a\n3,c\n");
}

static void half_a_header_is_written_anew(void **state)
{
    static const char *const texts[] = {"", "t", "time,valu"};
    const char *path = in_folder("half");
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        write_file(path, texts[i]);
        struct file_writer *writer = begin(path, NULL);
        file_writer_add(writer, "3,c\n");
        end(writer, 0, false);
        assert_string_equal(read_file(path), HEADER "3,c\n");
    }
}

static void a_file_of_other_columns_is_refused(void **state)
{
    static char tail[3000] = HEADER;
    const char *const texts[] = {"other\n1\n", "time,v\n", "\n", tail};
    const char *path = in_folder("other");
    (void)state;
    memset(tail + sizeof HEADER - 1, 'x', 2000);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        lum_error error = {""};
        write_file(path, texts[i]);
        assert_null(file_writer_new(path, HEADER, NULL, &error));
        assert_non_null(strstr(error.text, "other columns"));
        assert_string_equal(read_file(path), texts[i]);
    }
}

static void a_folder_that_is_not_there_is_named(void **state)
{
    lum_error error = {""};
    (void)state;
    assert_null(file_writer_new("/nonexistent/rows", HEADER, NULL, &error));
    assert_string_equal(error.text,
                        "/nonexistent/rows: No such file or directory");
}

static void a_page_that_cannot_be_written_is_news_once(void **state)
{
    lum_error error = {""};
    (void)state;
    struct file_writer *writer = begin(in_folder("a"), "/nonexistent/page");
    for (unsigned i = 0; i < 3; i++) {
        file_writer_turn(writer, "page");
    }
    while (!file_writer_tell(writer, &error)) {
        (void)usleep(1000);
    }
    assert_non_null(strstr(error.text, "/nonexistent/page"));
    assert_false(file_writer_tell(writer, &error));
    end(writer, 0, true);
}

static void the_last_page_counts(void **state)
{
    const char *path = in_folder("page");
    (void)state;
    struct file_writer *writer = begin(NULL, path);
    for (unsigned i = 0; i < 100; i++) {
        char page[32];
        (void)snprintf(page, sizeof page, "page %u\n", i);
        file_writer_turn(writer, page);
        file_writer_add(writer, "no file takes it\n");
    }
    end(writer, 0, false);
    assert_string_equal(read_file(path), "page 99\n");
}

static void a_pipe_is_refused(void **state)
{
    const char *path = in_folder("pipe");
    lum_error error = {""};
    (void)state;
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_null(file_writer_new(path, HEADER, NULL, &error));
    assert_non_null(strstr(error.text, "is a pipe"));
}

/* Its standard output is a full pipe that nobody reads. */
static void write_in_vain(void)
{
    char row[FILE_WRITER_ROW_BYTES];
    lum_error error = {""};
    memset(row, 'x', sizeof row);
    row[sizeof row - 2] = '\n';
    row[sizeof row - 1] = '\0';
    struct file_writer *writer = file_writer_new("-", HEADER, NULL, &error);
    for (unsigned i = 0; i < 1000; i++) {
        file_writer_add(writer, row);
    }
    const struct file_writer_rest rest = file_writer_end(writer);
    _exit(rest.hangs && rest.lost == 1000 ? 0 : 1);
}

static void lines_without_room_are_counted(void **state)
{
    int ends[2];
    int status = -1;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(fcntl(ends[1], F_SETFL, O_NONBLOCK), 0);
    while (write(ends[1], HEADER, 1) == 1) {
    }
    assert_int_equal(fcntl(ends[1], F_SETFL, 0), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        (void)dup2(ends[1], STDOUT_FILENO);
        write_in_vain();
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    (void)close(ends[0]);
    (void)close(ends[1]);
    assert_int_equal(status, 0);
}

static void write_many(const char *path, unsigned run)
{
    struct file_writer *writer = begin(path, NULL);

    for (unsigned i = 0; i < ROWS; i++) {
        char row[64];
        (void)snprintf(row, sizeof row, "%u,%u\n", run, i);
        file_writer_add(writer, row);
        (void)usleep(100);
    }
    _exit(file_writer_end(writer).lost == 0 ? 0 : 1);
}

static void runs_that_write_one_file_tear_no_line(void **state)
{
    const char *path = in_folder("shared");
    unsigned next[RUNS] = {0};
    (void)state;
    for (unsigned run = 0; run < RUNS; run++) {
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            write_many(path, run);
        }
    }
    for (unsigned run = 0; run < RUNS; run++) {
        int status = -1;
        assert_true(wait(&status) > 0);
        assert_int_equal(status, 0);
    }
    const char *at = read_file(path);
    assert_memory_equal(at, HEADER, sizeof HEADER - 1);
    at += sizeof HEADER - 1;
    for (unsigned i = 0; i < RUNS * ROWS; i++) {
        char *end = NULL;
        const unsigned long run = strtoul(at, &end, 10);
        assert_in_range(run, 0, RUNS - 1);
        assert_int_equal(*end, ',');
        assert_int_equal(strtoul(end + 1, &end, 10), next[run]++);
        assert_int_equal(*end, '\n');
        at = end + 1;
    }
    assert_int_equal(*at, '\0');
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"a",    "half", "other",
                                        "page", "pipe", "shared"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        (void)unlink(in_folder(names[i]));
    }
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_follow_one_header),
        cmocka_unit_test(half_a_line_is_cut_off),
        cmocka_unit_test(half_a_header_is_written_anew),
        cmocka_unit_test(a_file_of_other_columns_is_refused),
        cmocka_unit_test(a_folder_that_is_not_there_is_named),
        cmocka_unit_test(a_page_that_cannot_be_written_is_news_once),
        cmocka_unit_test(the_last_page_counts),
        cmocka_unit_test(a_pipe_is_refused),
        cmocka_unit_test(lines_without_room_are_counted),
        cmocka_unit_test(runs_that_write_one_file_tear_no_line)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
