#define _GNU_SOURCE /* syscall */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/outfile_io.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/magic.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <sys/wait.h>
#include <unistd.h>

#define NOBODY 65534u

static char directory[] = "/tmp/lum-outfile-XXXXXX";

/* Requests to the disk, and its answers. */
static struct {
    unsigned calls;
    unsigned failing; /* the call that fails, from 1; 0: none */
    int code;
    bool had_name[4]; /* whether "a" was there at the call */
    bool was_directory[4];
    int lock_code; /* of all locks; 0: they work */
    bool is_ext4;
    unsigned reservations;
    unsigned most_reservations; /* then the disk is full */
    off_t reserved_from;
    off_t reserved_to;
    size_t free_mib;
    off_t cut_to; /* -1: not at all */
} disk;

static const char *in_directory(const char *name)
{
    static char path[4][400];
    static unsigned turn;
    char *out = path[turn++ % 4u];
    snprintf(out, sizeof path[0], "%s/%s", directory, name);
    return out;
}

static bool exists(const char *name)
{
    struct stat status;
    return lstat(in_directory(name), &status) == 0;
}

/* In the place of the C library's. */
int fsync(int fd)
{
    struct stat status;
    const unsigned i = disk.calls++;
    if (i < 4u) {
        disk.had_name[i] = exists("a");
        disk.was_directory[i] =
            fstat(fd, &status) == 0 && S_ISDIR(status.st_mode);
    }
    if (disk.calls == disk.failing) {
        errno = disk.code;
        return -1;
    }
    return (int)syscall(SYS_fsync, fd);
}

int flock(int fd, int operation)
{
    if (disk.lock_code != 0) {
        errno = disk.lock_code;
        return -1;
    }
    return (int)syscall(SYS_flock, fd, operation);
}

/* The last bytes that need not stay in memory. */
static struct {
    unsigned calls;
    int advice;
    off_t from;
    off_t len;
} forgotten;

int posix_fadvise(int fd, off_t from, off_t len, int advice)
{
    (void)fd;
    forgotten.calls++;
    forgotten.from = from;
    forgotten.len = len;
    forgotten.advice = advice;
    return 0;
}

int fstatfs(int fd, struct statfs *status)
{
    (void)fd;
    memset(status, 0, sizeof *status);
    status->f_type = disk.is_ext4 ? EXT4_SUPER_MAGIC : TMPFS_MAGIC;
    status->f_bsize = 4096;
    status->f_bavail = disk.free_mib * 256u;
    return 0;
}

int fallocate(int fd, int mode, off_t from, off_t n)
{
    (void)fd;
    assert_int_equal(mode, FALLOC_FL_KEEP_SIZE);
    if (disk.reservations == disk.most_reservations) {
        errno = ENOSPC;
        return -1;
    }
    disk.reservations++;
    disk.reserved_from = from;
    disk.reserved_to = from + n;
    return 0;
}

int ftruncate(int fd, off_t size)
{
    disk.cut_to = size;
    return (int)syscall(SYS_ftruncate, fd, size);
}

static int begin(void **state)
{
    (void)state;
    memset(&disk, 0, sizeof disk);
    memset(&forgotten, 0, sizeof forgotten);
    disk.cut_to = -1;
    disk.free_mib = 100000;
    memcpy(directory + sizeof directory - 7u, "XXXXXX", 6);
    return mkdtemp(directory) == NULL;
}

static int end(void **state)
{
    const struct dirent *entry;
    DIR *all = opendir(directory);
    (void)state;
    assert_non_null(all);
    while ((entry = readdir(all)) != NULL) {
        (void)unlink(in_directory(entry->d_name));
    }
    closedir(all);
    return rmdir(directory);
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

static unsigned count_files(void)
{
    unsigned n = 0;
    DIR *all = opendir(directory);
    assert_non_null(all);
    while (readdir(all) != NULL) {
        n++;
    }
    closedir(all);
    return n - 2u;
}

/* The one whose name begins so and ends with .part; "" if there is none. */
static const char *find_part(const char *before)
{
    static char name[300];
    const struct dirent *entry;
    DIR *all = opendir(directory);
    assert_non_null(all);
    name[0] = '\0';
    while ((entry = readdir(all)) != NULL) {
        const size_t len = strlen(entry->d_name);
        if (strncmp(entry->d_name, before, strlen(before)) == 0 && len > 5u &&
            strcmp(entry->d_name + len - 5u, ".part") == 0) {
            snprintf(name, sizeof name, "%s", entry->d_name);
        }
    }
    closedir(all);
    return name;
}

static lum_outfile open_as(const char *name, lum_outfile_kind kind)
{
    lum_outfile file;
    lum_error error = {""};
    if (lum_outfile_open(in_directory(name), kind, &file, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return file;
}

static void put(const lum_outfile *file, const char *text)
{
    const ssize_t len = (ssize_t)strlen(text);
    assert_true(write(file->fd, text, (size_t)len) == len);
}

static void finish(lum_outfile *file)
{
    lum_error error = {""};
    if (lum_outfile_finish(file, &error) != 0) {
        fail_msg("%s", error.text);
    }
    lum_outfile_discard(file);
}

static void expect_refusal(const char *name, lum_outfile_kind kind, int code,
                           const char *says)
{
    lum_outfile file;
    lum_error error = {""};
    errno = 0;
    assert_int_equal(lum_outfile_open(in_directory(name), kind, &file, &error),
                     -1);
    assert_int_equal(errno, code);
    if (strstr(error.text, says) == NULL) {
        fail_msg("'%s' does not say '%s'", error.text, says);
    }
}

static void expect_busy(const char *name)
{
    for (int kind = 0; kind < 2; kind++) {
        expect_refusal(name, (lum_outfile_kind)kind, EBUSY, "is writing it");
    }
}

static void a_whole_file_has_its_name_at_the_end(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    assert_false(exists("a"));
    assert_string_not_equal(find_part("a."), "");
    assert_true(exists(".a.lumsdk"));
    put(&file, "hello");
    finish(&file);
    expect_file("a", "hello");
    assert_int_equal(count_files(), 1);
}

static void a_discarded_file_leaves_nothing_and_the_old_one(void **state)
{
    (void)state;
    put_file("a", "old");
    for (int kind = 0; kind < 2; kind++) {
        lum_outfile file = open_as("a", (lum_outfile_kind)kind);
        put(&file, "new");
        lum_outfile_discard(&file);
        expect_file("a", "old");
        assert_int_equal(count_files(), 1);
    }
}

static void files_of_others_are_not_touched(void **state)
{
    (void)state;
    put_file("a.part", "mine");
    put_file("a.0123456789ab.part", "mine too");
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "new");
    finish(&file);
    expect_file("a.part", "mine");
    expect_file("a.0123456789ab.part", "mine too");
    assert_int_equal(count_files(), 3);
}

static void a_second_writer_of_a_name_is_refused(void **state)
{
    (void)state;
    lum_outfile first = open_as("a", LUM_OUTFILE_WHOLE);
    put(&first, "first");
    expect_busy("a");
    expect_busy("./a");
    finish(&first);
    lum_outfile next = open_as("a", LUM_OUTFILE_WHOLE);
    expect_busy("a");
    put(&next, "next");
    finish(&next);
    expect_file("a", "next");
    assert_int_equal(count_files(), 1);
}

static int be_refused(void)
{
    lum_outfile file;
    char process[64];
    lum_error error = {""};
    snprintf(process, sizeof process, "another run is writing it (process %ld)",
             (long)getppid());
    return lum_outfile_open(in_directory("a"), LUM_OUTFILE_WHOLE, &file,
                            &error) == 0 ||
           errno != EBUSY || strstr(error.text, process) == NULL;
}

static void the_refusal_names_the_process(void **state)
{
    int status = -1;
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    expect_refusal("a", LUM_OUTFILE_WHOLE, EBUSY, "this run is writing it");
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(be_refused());
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    lum_outfile_discard(&file);
}

static void a_link_leads_to_the_same_name(void **state)
{
    struct stat status;
    (void)state;
    put_file("a", "old");
    assert_int_equal(symlink("a", in_directory("link")), 0);
    lum_outfile file = open_as("link", LUM_OUTFILE_WHOLE);
    expect_busy("a");
    put(&file, "new");
    finish(&file);
    expect_file("a", "new");
    assert_int_equal(lstat(in_directory("link"), &status), 0);
    assert_true(S_ISLNK(status.st_mode));
}

static void a_growing_file_has_its_name_when_it_is_shown(void **state)
{
    (void)state;
    put_file("a", "old");
    lum_outfile file = open_as("a", LUM_OUTFILE_GROWS);
    expect_file("a", "old");
    put(&file, "new");
    assert_int_equal(lum_outfile_show(&file, NULL), 0);
    expect_file("a", "new");
    assert_int_equal(count_files(), 1);
    expect_busy("a");
    put(&file, " and more");
    lum_outfile_discard(&file);
    expect_file("a", "new and more");
}

#define MIB ((size_t)1 << 20)

static void a_long_recording_leaves_its_beginning_to_the_disk(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_GROWS);
    lum_outfile_wrote(&file, 64 * MIB);
    assert_int_equal(forgotten.calls, 0);
    lum_outfile_wrote(&file, 8 * MIB - 1);
    assert_int_equal(forgotten.calls, 0);
    lum_outfile_wrote(&file, 1);
    assert_int_equal(forgotten.calls, 1);
    assert_int_equal(forgotten.advice, POSIX_FADV_DONTNEED);
    assert_int_equal(forgotten.from, 0);
    assert_int_equal(forgotten.len, 8 * MIB);
    lum_outfile_wrote(&file, 5000 * MIB);
    assert_int_equal(forgotten.from, 0);
    assert_int_equal(forgotten.len, 5008 * MIB);
    finish(&file);
}

/* Who converts a capture reads the result next. */
static void a_file_that_does_not_grow_stays_in_memory(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    lum_outfile_wrote(&file, 500 * MIB);
    lum_outfile_wrote(&file, 500 * MIB);
    assert_int_equal(forgotten.calls, 0);
    finish(&file);
}

/* The lock follows the file; the name alone would not show it. */
static void a_growing_file_is_known_by_another_name(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_GROWS);
    assert_int_equal(lum_outfile_show(&file, NULL), 0);
    assert_int_equal(link(in_directory("a"), in_directory("b")), 0);
    expect_busy("b");
    finish(&file);
    file = open_as("b", LUM_OUTFILE_WHOLE);
    finish(&file);
}

static void what_begins_to_be_written_meanwhile_is_not_replaced(void **state)
{
    lum_error error = {""};
    (void)state;
    put_file("a", "old");
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    const int other = open(in_directory("a"), O_WRONLY);
    assert_int_equal(flock(other, LOCK_EX), 0);
    assert_int_equal(lum_outfile_finish(&file, &error), -1);
    assert_int_equal(errno, EBUSY);
    lum_outfile_discard(&file);
    close(other);
    expect_file("a", "old");
    assert_int_equal(count_files(), 1);
}

static void only_what_was_written_gets_the_name(void **state)
{
    char part[300];
    lum_error error = {""};
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    snprintf(part, sizeof part, "%s", find_part("a."));
    assert_int_equal(unlink(in_directory(part)), 0);
    put_file(part, "of another");
    assert_int_equal(lum_outfile_finish(&file, &error), -1);
    assert_non_null(strstr(error.text, part));
    lum_outfile_discard(&file);
    expect_file("a", "");
    expect_file(part, "of another");
    assert_int_equal(count_files(), 2);
}

static void expect_told(const lum_outfile *file, const char *what,
                        const char *where)
{
    lum_error error = {""};
    assert_int_equal(lum_outfile_check(file, &error), -1);
    assert_int_equal(errno, ENOENT);
    assert_non_null(strstr(error.text, what));
    assert_non_null(strstr(error.text, where));
}

static void expect_lost(lum_outfile *file, const char *says)
{
    lum_error error = {""};
    assert_int_equal(lum_outfile_finish(file, &error), -1);
    assert_int_equal(errno, ENOENT);
    assert_non_null(strstr(error.text, says));
    lum_outfile_discard(file);
}

static void expect_put_back(lum_outfile *file, const char *name)
{
    char says[512];
    (void)snprintf(says, sizeof says, "put back as %s", in_directory(name));
    expect_lost(file, says);
}

static lum_outfile open_shown(const char *name)
{
    lum_outfile file = open_as(name, LUM_OUTFILE_GROWS);
    assert_int_equal(lum_outfile_show(&file, NULL), 0);
    put(&file, "data");
    assert_int_equal(lum_outfile_check(&file, NULL), 0);
    return file;
}

static void a_file_that_is_renamed_is_told_with_its_name(void **state)
{
    (void)state;
    lum_outfile file = open_shown("a");
    assert_int_equal(rename(in_directory("a"), in_directory("b")), 0);
    expect_told(&file, "renamed", in_directory("b"));
    put_file("a", "another");
    expect_told(&file, "renamed", in_directory("b"));
    expect_lost(&file, in_directory("b"));
    expect_file("a", "another");
    expect_file("b", "data");
}

static void a_file_that_has_its_name_again_is_fine(void **state)
{
    (void)state;
    lum_outfile file = open_shown("a");
    assert_int_equal(rename(in_directory("a"), in_directory("b")), 0);
    assert_int_equal(rename(in_directory("b"), in_directory("a")), 0);
    finish(&file);
    expect_file("a", "data");
}

static void a_folder_that_is_renamed_is_told(void **state)
{
    (void)state;
    assert_int_equal(mkdir(in_directory("day"), 0777), 0);
    lum_outfile file = open_shown("day/a");
    assert_int_equal(rename(in_directory("day"), in_directory("old")), 0);
    expect_told(&file, "renamed", in_directory("old/a"));
    expect_lost(&file, in_directory("old/a"));
    expect_file("old/a", "data");
    assert_int_equal(unlink(in_directory("old/a")), 0);
    assert_int_equal(rmdir(in_directory("old")), 0);
}

static void a_file_that_is_removed_is_copied_back(void **state)
{
    char place[64];
    struct stat status;
    (void)state;
    lum_outfile file = open_shown("a");
    assert_int_equal(chmod(in_directory("a"), 0640), 0);
    assert_int_equal(unlink(in_directory("a")), 0);
    snprintf(place, sizeof place, "cp /proc/%ld/fd/%d", (long)getpid(),
             file.fd);
    expect_told(&file, "removed", place);
    put(&file, " and more");
    expect_put_back(&file, "a");
    expect_file("a", "data and more");
    assert_int_equal(stat(in_directory("a"), &status), 0);
    assert_int_equal(status.st_mode & 0777u, 0640);
    assert_int_equal(count_files(), 1);
}

/* More than the memory that copies, and odd. */
static void a_large_file_is_copied_whole(void **state)
{
    enum {
        BYTES = 300001
    };
    static uint8_t want[BYTES];
    static uint8_t got[BYTES + 1];
    (void)state;
    for (size_t i = 0; i < BYTES; i++) {
        want[i] = (uint8_t)(i * 2654435761u >> 13);
    }
    lum_outfile file = open_shown("a");
    assert_int_equal(pwrite(file.fd, want, BYTES, 0), BYTES);
    assert_int_equal(unlink(in_directory("a")), 0);
    expect_put_back(&file, "a");
    FILE *copy = fopen(in_directory("a"), "rb");
    assert_non_null(copy);
    assert_int_equal(fread(got, 1, sizeof got, copy), BYTES);
    (void)fclose(copy);
    assert_memory_equal(got, want, BYTES);
}

/* The file that is there stays, and so does one in the second place. */
static void a_file_that_is_replaced_is_saved_beside_it(void **state)
{
    (void)state;
    lum_outfile file = open_shown("a");
    assert_int_equal(unlink(in_directory("a")), 0);
    put_file("a", "another");
    expect_told(&file, "removed", "/fd/");
    expect_put_back(&file, "a.recovered");
    expect_file("a", "another");
    expect_file("a.recovered", "data");
    assert_int_equal(unlink(in_directory("a")), 0);
    file = open_shown("a");
    assert_int_equal(unlink(in_directory("a")), 0);
    put_file("a", "another");
    expect_put_back(&file, "a.");
    expect_file("a", "another");
    expect_file("a.recovered", "data");
    expect_file(find_part("a."), "data");
    assert_int_equal(count_files(), 3);
}

/* Which gets its name at its end. */
static void a_file_that_another_writes_by_now_is_saved_beside_it(void **state)
{
    (void)state;
    for (int has_link = 0; has_link < 2; has_link++) {
        lum_outfile file = open_shown("a");
        if (has_link != 0) {
            assert_int_equal(link(in_directory("a"), in_directory("b")), 0);
        }
        assert_int_equal(unlink(in_directory("a")), 0);
        lum_outfile next = open_as("a", LUM_OUTFILE_WHOLE);
        put(&next, "next");
        expect_put_back(&file, "a.recovered");
        finish(&next);
        expect_file("a", "next");
        expect_file("a.recovered", "data");
        assert_int_equal(unlink(in_directory("a")), 0);
        assert_int_equal(unlink(in_directory("a.recovered")), 0);
    }
}

static lum_outfile open_in_removed_folder(void)
{
    assert_int_equal(mkdir(in_directory("day"), 0777), 0);
    const lum_outfile file = open_shown("day/a");
    assert_int_equal(unlink(in_directory("day/a")), 0);
    assert_int_equal(rmdir(in_directory("day")), 0);
    return file;
}

static void a_folder_that_is_removed_takes_the_data_with_it(void **state)
{
    (void)state;
    lum_outfile file = open_in_removed_folder();
    expect_told(&file, "removed", "/fd/");
    expect_lost(&file, "its data is lost, as it could not be put back: No such "
                       "file or directory");
    assert_int_equal(count_files(), 0);
}

static void a_folder_that_is_there_again_gets_the_data(void **state)
{
    (void)state;
    lum_outfile file = open_in_removed_folder();
    assert_int_equal(mkdir(in_directory("day"), 0777), 0);
    expect_put_back(&file, "day/a");
    expect_file("day/a", "data");
    assert_int_equal(unlink(in_directory("day/a")), 0);
    assert_int_equal(rmdir(in_directory("day")), 0);
}

static void a_disk_without_room_keeps_no_half_copy(void **state)
{
    struct rlimit before;
    (void)state;
    lum_outfile file = open_shown("a");
    assert_int_equal(unlink(in_directory("a")), 0);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    const struct rlimit small = {.rlim_cur = 3, .rlim_max = before.rlim_max};
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    lum_error error = {""};
    const int result = lum_outfile_finish(&file, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)signal(SIGXFSZ, handler);
    assert_int_equal(result, -1);
    assert_non_null(strstr(error.text, "is lost"));
    assert_non_null(strstr(error.text, "File too large"));
    lum_outfile_discard(&file);
    assert_int_equal(count_files(), 0);
}

static void a_file_with_another_link_gets_its_name_back(void **state)
{
    (void)state;
    lum_outfile file = open_shown("a");
    const ino_t inode = file.inode;
    struct stat status;
    assert_int_equal(link(in_directory("a"), in_directory("b")), 0);
    assert_int_equal(unlink(in_directory("a")), 0);
    expect_put_back(&file, "a");
    assert_int_equal(stat(in_directory("a"), &status), 0);
    assert_int_equal(status.st_ino, inode);
    expect_file("b", "data");
    assert_int_equal(count_files(), 2);
}

static void an_unfinished_file_that_is_removed_gets_its_name(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "data");
    assert_int_equal(unlink(in_directory(find_part("a."))), 0);
    expect_told(&file, ".part, where it is written, was removed", "/fd/");
    expect_put_back(&file, "a");
    expect_file("a", "data");
    assert_int_equal(count_files(), 1);
}

/* One that has failed replaces nothing. */
static void an_unfinished_file_that_is_removed_keeps_the_old(void **state)
{
    (void)state;
    put_file("a", "old");
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "data");
    assert_int_equal(unlink(in_directory(find_part("a."))), 0);
    expect_put_back(&file, "a.recovered");
    expect_file("a", "old");
    expect_file("a.recovered", "data");
}

static void an_unfinished_file_that_is_renamed_is_told(void **state)
{
    char part[300];
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "data");
    snprintf(part, sizeof part, "%s", find_part("a."));
    assert_int_equal(rename(in_directory(part), in_directory("b")), 0);
    expect_told(&file, part, in_directory("b"));
    expect_lost(&file, in_directory("b"));
    expect_file("b", "data");
    assert_false(exists("a"));
}

/* Leave what a run leaves that is killed. */
static void die_writing(const char *name)
{
    int status = -1;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        lum_outfile file;
        if (lum_outfile_open(in_directory(name), LUM_OUTFILE_WHOLE, &file,
                             NULL) != 0 ||
            write(file.fd, "half", 4) != 4) {
            _exit(1);
        }
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

static void what_a_killed_run_left_goes_with_the_next(void **state)
{
    (void)state;
    put_file("a.0123456789ab.part", "mine");
    die_writing("a");
    assert_int_equal(count_files(), 3);
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    assert_int_equal(count_files(), 3);
    put(&file, "whole");
    finish(&file);
    expect_file("a", "whole");
    expect_file("a.0123456789ab.part", "mine");
    assert_int_equal(count_files(), 2);
}

static void a_mark_cannot_have_other_files_removed(void **state)
{
    static const char *const names[] = {"keep",
                                        "../keep",
                                        "a.part",
                                        "a.0123456789.part",
                                        "a.0123456789AB.part",
                                        "b.0123456789ab.part",
                                        "a.0123456789ab.part/../keep"};
    char text[128];
    (void)state;
    put_file("keep", "kept");
    put_file("a.part", "kept");
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(text, sizeof text, "lumsdk\nprocess 1\nunfinished %s\n",
                 names[i]);
        put_file(".a.lumsdk", text);
        lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
        finish(&file);
    }
    expect_file("keep", "kept");
    expect_file("a.part", "kept");
    assert_int_equal(count_files(), 3);
}

/* A mark's name for an unfinished file that is being written, or is a link. */
static void a_mark_names_what_is_in_use_in_vain(void **state)
{
    (void)state;
    put_file(".a.lumsdk", "lumsdk\nunfinished a.0123456789ab.part\n");
    put_file("a.0123456789ab.part", "in use");
    const int fd = open(in_directory("a.0123456789ab.part"), O_WRONLY);
    assert_int_equal(flock(fd, LOCK_EX), 0);
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    finish(&file);
    close(fd);
    expect_file("a.0123456789ab.part", "in use");
}

static void what_is_no_mark_is_in_the_way_and_stays(void **state)
{
    (void)state;
    put_file(".a.lumsdk", "a file of mine");
    expect_refusal("a", LUM_OUTFILE_WHOLE, EEXIST, ".a.lumsdk");
    expect_file(".a.lumsdk", "a file of mine");
    assert_int_equal(unlink(in_directory(".a.lumsdk")), 0);
    assert_int_equal(symlink("a", in_directory(".a.lumsdk")), 0);
    expect_refusal("a", LUM_OUTFILE_WHOLE, EEXIST, ".a.lumsdk");
    assert_int_equal(unlink(in_directory(".a.lumsdk")), 0);
    assert_int_equal(mkfifo(in_directory(".a.lumsdk"), 0666), 0);
    expect_refusal("a", LUM_OUTFILE_WHOLE, EEXIST, ".a.lumsdk");
    assert_int_equal(count_files(), 1);
}

static void bytes_are_on_the_disk_before_the_name(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "x");
    assert_int_equal(disk.calls, 0);
    finish(&file);
    assert_int_equal(disk.calls, 2);
    assert_false(disk.had_name[0] || disk.was_directory[0]);
    assert_true(disk.had_name[1] && disk.was_directory[1]);
}

/* The recording thread does not wait for it. */
static void a_growing_file_waits_for_the_disk_at_its_end_alone(void **state)
{
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_GROWS);
    put(&file, "x");
    assert_int_equal(lum_outfile_show(&file, NULL), 0);
    assert_int_equal(disk.calls, 0);
    finish(&file);
    assert_int_equal(disk.calls, 2);
    assert_true(disk.had_name[0] && !disk.was_directory[0]);
    assert_true(disk.had_name[1] && disk.was_directory[1]);
}

static void a_disk_that_fails_keeps_the_name_away(void **state)
{
    lum_error error = {""};
    (void)state;
    put_file("a", "old");
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    put(&file, "x");
    disk.failing = 1;
    disk.code = EIO;
    assert_int_equal(lum_outfile_finish(&file, &error), -1);
    assert_int_equal(errno, EIO);
    assert_non_null(strstr(error.text, "cannot write it to the disk"));
    lum_outfile_discard(&file);
    expect_file("a", "old");
    assert_int_equal(count_files(), 1);
}

static void a_directory_that_fails_is_told(void **state)
{
    lum_error error = {""};
    (void)state;
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    disk.failing = 2;
    disk.code = EIO;
    assert_int_equal(lum_outfile_finish(&file, &error), -1);
    assert_non_null(strstr(error.text, "its name"));
    lum_outfile_discard(&file);
    assert_int_equal(count_files(), 1);
}

static void a_file_system_that_cannot_sync_will_do(void **state)
{
    static const int codes[] = {EINVAL, ENOSYS, EOPNOTSUPP, EINTR};
    (void)state;
    for (unsigned i = 0; i < 8u; i++) {
        disk.calls = 0;
        disk.failing = 1u + i % 2u;
        disk.code = codes[i / 2u];
        lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
        put(&file, "x");
        finish(&file);
        expect_file("a", "x");
        assert_int_equal(count_files(), 1);
    }
}

/* Then nobody is refused, and no file of another run counts as left over. */
static void a_file_system_without_locks_will_do(void **state)
{
    (void)state;
    disk.lock_code = ENOLCK;
    lum_outfile first = open_as("a", LUM_OUTFILE_WHOLE);
    lum_outfile second = open_as("a", LUM_OUTFILE_WHOLE);
    put(&first, "first");
    put(&second, "second");
    finish(&second);
    expect_file("a", "second");
    finish(&first);
    expect_file("a", "first");
    assert_int_equal(count_files(), 1);
}

static mode_t mode_of(const char *name)
{
    struct stat status;
    assert_int_equal(stat(in_directory(name), &status), 0);
    return status.st_mode & 07777u;
}

static void modes_are_the_old_ones_or_the_umasks(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        const mode_t old = umask(027);
        lum_outfile file = open_as("a", (lum_outfile_kind)kind);
        finish(&file);
        umask(old);
        assert_int_equal(mode_of("a"), 0640);
        assert_int_equal(chmod(in_directory("a"), 0606), 0);
        file = open_as("a", (lum_outfile_kind)kind);
        finish(&file);
        assert_int_equal(mode_of("a"), 0606);
        assert_int_equal(unlink(in_directory("a")), 0);
    }
}

/* Root may write everywhere, so it becomes nobody first. */
static int write_as_nobody(void)
{
    lum_outfile file;
    lum_error error = {""};
    if (geteuid() == 0 && (setgid(NOBODY) != 0 || setuid(NOBODY) != 0)) {
        return 1;
    }
    if (lum_outfile_open(in_directory("a"), LUM_OUTFILE_WHOLE, &file, &error) ==
            0 ||
        errno != EACCES || strstr(error.text, "directory") == NULL) {
        return 2;
    }
    struct stat status;
    if (lum_outfile_open(in_directory("a"), LUM_OUTFILE_GROWS, &file, &error) !=
            0 ||
        stat(in_directory("a"), &status) != 0 || status.st_size != 5 ||
        lum_outfile_show(&file, &error) != 0 || write(file.fd, "new", 3) != 3) {
        return 3;
    }
    lum_outfile other;
    if (lum_outfile_open(in_directory("a"), LUM_OUTFILE_GROWS, &other, NULL) ==
            0 ||
        errno != EBUSY || lum_outfile_finish(&file, &error) != 0) {
        return 4;
    }
    lum_outfile_discard(&file);
    return 0;
}

static void a_growing_file_in_a_closed_directory_is_emptied(void **state)
{
    int status = -1;
    (void)state;
    put_file("a", "older");
    assert_int_equal(chmod(in_directory("a"), 0666), 0);
    assert_int_equal(chmod(directory, 0555), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(write_as_nobody());
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(chmod(directory, 0755), 0);
    expect_file("a", "new");
    assert_int_equal(count_files(), 1);
}

static void the_longest_names_can_be_written(void **state)
{
    char first[256];
    char second[256];
    (void)state;
    for (size_t len = 198; len < sizeof first; len++) {
        memset(first, 'n', len);
        first[len] = '\0';
        memcpy(second, first, sizeof second);
        second[len - 1u] = 'm';
        lum_outfile a = open_as(first, LUM_OUTFILE_WHOLE);
        lum_outfile b = open_as(second, LUM_OUTFILE_WHOLE);
        expect_busy(first);
        finish(&a);
        finish(&b);
        assert_true(exists(first) && exists(second));
        assert_int_equal(count_files(), 2);
        assert_int_equal(unlink(in_directory(first)), 0);
        assert_int_equal(unlink(in_directory(second)), 0);
    }
}

#define RIVALS 8
#define ROUNDS 40

/* Tells by its status whether it may write; holds that until all have tried. */
static int compete(int start, int tried, int all_tried)
{
    lum_outfile file;
    char byte;
    (void)!read(start, &byte, 1);
    const int result =
        lum_outfile_open(in_directory("a"), LUM_OUTFILE_WHOLE, &file, NULL);
    const bool is_refused = result != 0 && errno == EBUSY;
    close(tried);
    (void)!read(all_tried, &byte, 1);
    if (result == 0) {
        lum_outfile_discard(&file);
        return 0;
    }
    return is_refused ? 1 : 2;
}

static unsigned run_rivals(void)
{
    int start[2];
    int tried[2];
    int all_tried[2];
    char byte;
    unsigned winners = 0;
    assert_true(pipe(start) == 0 && pipe(tried) == 0 && pipe(all_tried) == 0);
    fflush(NULL);
    for (int i = 0; i < RIVALS; i++) {
        if (fork() == 0) {
            close(start[1]);
            close(tried[0]);
            close(all_tried[1]);
            _exit(compete(start[0], tried[1], all_tried[0]));
        }
    }
    close(start[0]);
    close(tried[1]);
    close(all_tried[0]);
    close(start[1]);
    assert_int_equal(read(tried[0], &byte, 1), 0);
    close(tried[0]);
    close(all_tried[1]);
    for (int i = 0; i < RIVALS; i++) {
        int status = -1;
        assert_true(wait(&status) > 0);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) < 2);
        winners += WEXITSTATUS(status) == 0 ? 1u : 0u;
    }
    return winners;
}

/* Also where each finds what a run has left that was killed. */
static void of_many_at_once_one_writes(void **state)
{
    (void)state;
    for (int i = 0; i < ROUNDS; i++) {
        if (i % 2 == 1) {
            die_writing("a");
        }
        assert_int_equal(run_rivals(), 1);
        assert_int_equal(count_files(), 0);
    }
}

static void what_is_no_file_is_written_in_place(void **state)
{
    (void)state;
    lum_outfile file;
    assert_int_equal(
        lum_outfile_open("/dev/null", LUM_OUTFILE_WHOLE, &file, NULL), 0);
    assert_true(file.may_block && !file.seekable);
    put(&file, "x");
    finish(&file);
    assert_int_equal(disk.calls, 0);
    assert_int_equal(symlink("nowhere", in_directory("link")), 0);
    expect_refusal("link", LUM_OUTFILE_GROWS, ENOENT, "link to a missing file");
    expect_refusal("no/a", LUM_OUTFILE_GROWS, ENOENT, "does not exist");
    expect_refusal("", LUM_OUTFILE_WHOLE, EISDIR, "is a directory");
}

static void a_write_to_a_pipe_takes_what_there_is_room_for(void **state)
{
    static const char bytes[MIB];
    int ends[2];
    char name[32];
    size_t written = 0;
    lum_outfile file;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_outfile_open(name, LUM_OUTFILE_WHOLE, &file, NULL), 0);
    lum_outfile_never_wait(&file);
    assert_true(file.never_waits);
    assert_int_equal(lum_outfile_put(&file, bytes, MIB, &written), 0);
    assert_in_range(written, PIPE_BUF + 1u, MIB - 1u);
    assert_int_equal(lum_outfile_put(&file, bytes, MIB, &written), 0);
    assert_int_equal(written, 0);
    assert_int_equal(lum_outfile_wait(&file, 0), 0);
    assert_int_equal(fcntl(ends[1], F_GETFL) & O_NONBLOCK, 0);
    finish(&file);
    close(ends[0]);
    close(ends[1]);
}

static void room_in_a_pipe_is_not_taken_away(void **state)
{
    int ends[2];
    char name[32];
    lum_outfile file;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    const int room = fcntl(ends[1], F_SETPIPE_SZ, (int)MIB);
    assert_true(room >= (int)MIB);
    snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_outfile_open(name, LUM_OUTFILE_WHOLE, &file, NULL), 0);
    lum_outfile_never_wait(&file);
    assert_int_equal(fcntl(ends[1], F_GETPIPE_SZ), room);
    finish(&file);
    close(ends[0]);
    close(ends[1]);
}

static void places_are_reserved_ahead_and_given_back(void **state)
{
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    (void)state;
    disk.is_ext4 = true;
    disk.most_reservations = 100;
    put(&file, "some");
    lum_outfile_wrote(&file, 8u * MIB - 1u);
    assert_int_equal(disk.reservations, 0);
    lum_outfile_wrote(&file, 1);
    assert_int_equal(disk.reservations, 1);
    assert_int_equal(disk.reserved_from, 8u * MIB);
    assert_int_equal(disk.reserved_to, 72u * MIB);
    lum_outfile_wrote(&file, 56u * MIB - 1u);
    assert_int_equal(disk.reservations, 1);
    lum_outfile_wrote(&file, 1);
    assert_int_equal(disk.reservations, 2);
    assert_int_equal(disk.reserved_from, 72u * MIB);
    lum_outfile_wrote(&file, 500u * MIB); /* beyond what is reserved */
    assert_int_equal(disk.reservations, 3);
    assert_int_equal(disk.reserved_from, 564u * MIB);
    finish(&file);
    assert_int_equal(disk.cut_to, 4);
    expect_file("a", "some");
}

static void a_full_disk_is_asked_once(void **state)
{
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    (void)state;
    disk.is_ext4 = true;
    disk.most_reservations = 1;
    put(&file, "some");
    for (unsigned i = 0; i < 100u; i++) {
        lum_outfile_wrote(&file, 8u * MIB);
        disk.most_reservations = i < 8u ? 1u : 100u;
    }
    assert_int_equal(disk.reservations, 1);
    finish(&file);
    assert_int_equal(disk.cut_to, 4);
    expect_file("a", "some");
}

/* A request that fails may have got some places. */
static void what_a_failed_request_got_is_given_back(void **state)
{
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    (void)state;
    disk.is_ext4 = true;
    put(&file, "some");
    lum_outfile_wrote(&file, 8u * MIB);
    finish(&file);
    assert_int_equal(disk.reservations, 0);
    assert_int_equal(disk.cut_to, 4);
    expect_file("a", "some");
}

static void little_room_is_left_to_others(void **state)
{
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    (void)state;
    disk.is_ext4 = true;
    disk.most_reservations = 100;
    disk.free_mib = 1024; /* 16 times as much */
    lum_outfile_wrote(&file, 8u * MIB);
    assert_int_equal(disk.reservations, 1);
    disk.free_mib = 1023;
    lum_outfile_wrote(&file, 64u * MIB);
    lum_outfile_wrote(&file, 64u * MIB);
    assert_int_equal(disk.reservations, 1);
    finish(&file);
    assert_int_equal(disk.cut_to, 0);
}

static void nothing_is_reserved_elsewhere(void **state)
{
    lum_outfile file = open_as("a", LUM_OUTFILE_WHOLE);
    (void)state;
    disk.most_reservations = 100;
    lum_outfile_wrote(&file, 100u * MIB);
    disk.is_ext4 = true;
    lum_outfile_wrote(&file, 100u * MIB);
    finish(&file);
    assert_int_equal(disk.reservations, 0);
    assert_int_equal(disk.cut_to, -1);
}

/* A killed process would leave the places with it. */
static void nothing_is_reserved_for_a_file_that_has_its_name(void **state)
{
    lum_error error;
    lum_outfile file = open_as("a", LUM_OUTFILE_GROWS);
    (void)state;
    disk.is_ext4 = true;
    disk.most_reservations = 100;
    assert_int_equal(lum_outfile_show(&file, &error), 0);
    lum_outfile_wrote(&file, 100u * MIB);
    finish(&file);
    assert_int_equal(disk.reservations, 0);
    assert_int_equal(disk.cut_to, -1);
}

#define FACT(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FACT(a_whole_file_has_its_name_at_the_end),
        FACT(a_discarded_file_leaves_nothing_and_the_old_one),
        FACT(files_of_others_are_not_touched),
        FACT(a_second_writer_of_a_name_is_refused),
        FACT(the_refusal_names_the_process),
        FACT(a_link_leads_to_the_same_name),
        FACT(a_growing_file_has_its_name_when_it_is_shown),
        FACT(a_long_recording_leaves_its_beginning_to_the_disk),
        FACT(a_file_that_does_not_grow_stays_in_memory),
        FACT(a_growing_file_is_known_by_another_name),
        FACT(what_begins_to_be_written_meanwhile_is_not_replaced),
        FACT(only_what_was_written_gets_the_name),
        FACT(a_file_that_is_renamed_is_told_with_its_name),
        FACT(a_file_that_has_its_name_again_is_fine),
        FACT(a_folder_that_is_renamed_is_told),
        FACT(a_file_that_is_removed_is_copied_back),
        FACT(a_large_file_is_copied_whole),
        FACT(a_file_that_is_replaced_is_saved_beside_it),
        FACT(a_file_that_another_writes_by_now_is_saved_beside_it),
        FACT(a_folder_that_is_removed_takes_the_data_with_it),
        FACT(a_folder_that_is_there_again_gets_the_data),
        FACT(a_disk_without_room_keeps_no_half_copy),
        FACT(a_file_with_another_link_gets_its_name_back),
        FACT(an_unfinished_file_that_is_removed_gets_its_name),
        FACT(an_unfinished_file_that_is_removed_keeps_the_old),
        FACT(an_unfinished_file_that_is_renamed_is_told),
        FACT(what_a_killed_run_left_goes_with_the_next),
        FACT(a_mark_cannot_have_other_files_removed),
        FACT(a_mark_names_what_is_in_use_in_vain),
        FACT(what_is_no_mark_is_in_the_way_and_stays),
        FACT(bytes_are_on_the_disk_before_the_name),
        FACT(a_growing_file_waits_for_the_disk_at_its_end_alone),
        FACT(a_disk_that_fails_keeps_the_name_away),
        FACT(a_directory_that_fails_is_told),
        FACT(a_file_system_that_cannot_sync_will_do),
        FACT(a_file_system_without_locks_will_do),
        FACT(modes_are_the_old_ones_or_the_umasks),
        FACT(a_growing_file_in_a_closed_directory_is_emptied),
        FACT(the_longest_names_can_be_written),
        FACT(of_many_at_once_one_writes),
        FACT(places_are_reserved_ahead_and_given_back),
        FACT(a_full_disk_is_asked_once),
        FACT(what_a_failed_request_got_is_given_back),
        FACT(little_room_is_left_to_others),
        FACT(nothing_is_reserved_elsewhere),
        FACT(nothing_is_reserved_for_a_file_that_has_its_name),
        FACT(what_is_no_file_is_written_in_place),
        FACT(a_write_to_a_pipe_takes_what_there_is_room_for),
        FACT(room_in_a_pipe_is_not_taken_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
