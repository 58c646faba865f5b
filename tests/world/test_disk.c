#define _GNU_SOURCE
#include "bench.h"

#include "kernel/disk_calls.h"
#include "kernel/file_calls.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#define NEW (O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC)

/* A call fails with this errno. */
#define refuses(call, code)                                                    \
    do {                                                                       \
        errno = 0;                                                             \
        assert_true((call) < 0);                                               \
        assert_int_equal(errno, code);                                         \
    } while (0)

static world_disk *disk(void)
{
    return world_disk_of(host);
}

static int make(const char *path, const char *text)
{
    const int fd = world_call_open64(path, NEW, 0666);
    const ssize_t len = (ssize_t)strlen(text);
    assert_true(fd >= 0);
    assert_int_equal(world_call_write(fd, text, (size_t)len), len);
    return fd;
}

static void make_closed(const char *path, const char *text)
{
    assert_int_equal(world_call_close(make(path, text)), 0);
}

/* Behind what a text has. */
static void add(char *text, size_t room, const char *more)
{
    const size_t len = strlen(text);
    assert_true(len + strlen(more) < room);
    memcpy(text + len, more, strlen(more) + 1u);
}

static void has(const char *path, const char *text)
{
    char *found = world_disk_read(disk(), path, NULL);
    assert_non_null(found);
    assert_string_equal(found, text);
    free(found);
}

/* --- bytes --- */

static int use_bytes(void)
{
    char text[16] = "";
    const int fd = make("a", "0123456789");
    refuses(world_call_read(fd, text, 1), EBADF);
    assert_int_equal(world_call_lseek64(fd, 3, SEEK_SET), 3);
    assert_int_equal(world_call_write(fd, "abc", 3), 3);
    assert_int_equal(world_call_pwrite64(fd, "Z", 1, 0), 1);
    assert_int_equal(world_call_lseek64(fd, -1, SEEK_END), 9);
    assert_int_equal(world_call_ftruncate64(fd, 8), 0);
    refuses(world_call_lseek64(fd, -9, SEEK_END), EINVAL);
    assert_int_equal(world_call_close(fd), 0);
    refuses(world_call_close(fd), EBADF);
    const int in = world_call_open64("a", O_RDONLY);
    assert_int_equal(world_call_read(in, text, 4), 4);
    assert_memory_equal(text, "Z12a", 4);
    assert_int_equal(world_call_pread64(in, text, 9, 4), 4);
    assert_memory_equal(text, "bc67", 4);
    assert_int_equal(world_call_read(in, text, 9), 4);
    assert_int_equal(world_call_read(in, text, 9), 0);
    refuses(world_call_write(in, "x", 1), EBADF);
    const int more = world_call_open64("a", O_WRONLY | O_APPEND);
    assert_int_equal(world_call_pwrite64(more, "+", 1, 0), 1);
    return 0;
}

static void run_bytes(void)
{
    bench_do(use_bytes);
    has("/home/a", "Z12abc67+");
}

static void bytes_are_read_and_written_where_they_belong(void **state)
{
    (void)state;
    bench_run(run_bytes);
}

static int write_far(void)
{
    char text[8];
    const int fd = world_call_open64("far", O_RDWR | O_CREAT, 0600);
    assert_int_equal(world_call_pwrite64(fd, "end", 3, 10000), 3);
    assert_int_equal(world_call_pread64(fd, text, 4, 9998), 4);
    assert_memory_equal(text, "\0\0en", 4);
    assert_int_equal(world_call_ftruncate64(fd, 9999), 0);
    assert_int_equal(world_call_ftruncate64(fd, 10002), 0);
    assert_int_equal(world_call_pread64(fd, text, 4, 9999), 3);
    assert_memory_equal(text, "\0\0\0", 3);
    return 0;
}

static void run_far(void)
{
    bench_do(write_far);
}

static void what_was_never_written_is_zero(void **state)
{
    (void)state;
    bench_run(run_far);
}

/* --- names --- */

static int use_wrong_names(void)
{
    make_closed("a", "1");
    refuses(world_call_open64("a", NEW, 0666), EEXIST);
    refuses(world_call_open64("none", O_RDONLY), ENOENT);
    refuses(world_call_open64("none/x", NEW, 0666), ENOENT);
    refuses(world_call_open64("a/x", NEW, 0666), ENOTDIR);
    assert_int_equal(world_call_mkdir("d", 0777), 0);
    make_closed("d/c", "333");
    refuses(world_call_mkdir("d", 0777), EEXIST);
    refuses(world_call_open64("d", O_WRONLY), EISDIR);
    refuses(world_call_open64("a", O_RDONLY | O_DIRECTORY), ENOTDIR);
    return 0;
}

static int move_wrongly(void)
{
    refuses(world_call_rmdir("d"), ENOTEMPTY);
    refuses(world_call_unlink("d"), EISDIR);
    refuses(world_call_rmdir("a"), ENOTDIR);
    refuses(world_call_rename("none", "a"), ENOENT);
    refuses(world_call_rename("a", "d"), EISDIR);
    refuses(world_call_rename("d", "a"), ENOTDIR);
    return 0;
}

static int use_names(void)
{
    struct stat status;
    make_closed("b", "22");
    assert_int_equal(world_call_rename("b", "a"), 0);
    assert_int_equal(world_call_stat64("a", &status), 0);
    assert_int_equal(status.st_size, 2);
    refuses(world_call_stat64("b", &status), ENOENT);
    assert_int_equal(world_call_rename("d/c", "c"), 0);
    assert_int_equal(world_call_rmdir("d"), 0);
    assert_int_equal(world_call_unlink("/home/../home/./c"), 0);
    refuses(world_call_unlink("c"), ENOENT);
    return 0;
}

static void run_names(void)
{
    bench_do(use_wrong_names);
    bench_do(move_wrongly);
    bench_do(use_names);
    assert_string_equal(world_disk_name(disk(), "/home", 0), "a");
    assert_null(world_disk_name(disk(), "/home", 1));
}

static void names_are_made_moved_and_removed(void **state)
{
    (void)state;
    bench_run(run_names);
}

static int use_links(void)
{
    struct stat status;
    char text[16];
    refuses(world_call_open64("link", O_RDONLY | O_NOFOLLOW), ELOOP);
    refuses(world_call_open64("loop", O_RDONLY), ELOOP);
    refuses(world_call_stat64("lost", &status), ENOENT);
    assert_int_equal(world_call_lstat64("lost", &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_int_equal(world_call_readlink("link", text, sizeof text), 8);
    assert_memory_equal(text, "folder/a", 8);
    assert_int_equal(world_call_access("link", R_OK), 0);
    char *path = world_call_realpath("link", NULL);
    assert_string_equal(path, "/home/folder/a");
    world_free(path);
    return 0;
}

static void run_links(void)
{
    world_disk_make_folder(disk(), "/home/folder");
    world_disk_put(disk(), "/home/folder/a", "text", 4);
    world_disk_make_link(disk(), "/home/link", "folder/a");
    world_disk_make_link(disk(), "/home/lost", "/nowhere");
    world_disk_make_link(disk(), "/home/loop", "loop");
    bench_do(use_links);
}

static void links_are_followed_unless_they_must_not(void **state)
{
    (void)state;
    bench_run(run_links);
}

static int read_folder(void)
{
    char all[64] = "";
    DIR *folder = world_call_opendir("/home/folder");
    assert_non_null(folder);
    for (const struct dirent *e = world_call_readdir64(folder); e != NULL;
         e = world_call_readdir64(folder)) {
        add(all, sizeof all, e->d_name);
        add(all, sizeof all, e->d_type == DT_DIR ? "/ " : " ");
    }
    assert_string_equal(all, "./ ../ b a ");
    assert_int_equal(world_call_closedir(folder), 0);
    assert_null(world_call_opendir("/home/folder/a"));
    assert_int_equal(errno, ENOTDIR);
    return 0;
}

static void run_folder(void)
{
    world_disk_make_folder(disk(), "/home/folder");
    world_disk_put(disk(), "/home/folder/b", "", 0);
    world_disk_put(disk(), "/home/folder/a", "", 0);
    bench_do(read_folder);
}

static void a_folder_is_read_in_the_order_of_its_making(void **state)
{
    (void)state;
    bench_run(run_folder);
}

static int try_rights(void)
{
    refuses(world_call_open64("others/new", NEW, 0666), EACCES);
    refuses(world_call_open64("others/file", O_WRONLY), EACCES);
    refuses(world_call_unlink("others/file"), EACCES);
    refuses(world_call_rename("others/file", "mine"), EACCES);
    refuses(world_call_access("others/file", W_OK), EACCES);
    assert_int_equal(world_call_access("others/file", R_OK), 0);
    refuses(world_call_open64("shut/file", O_RDONLY), EACCES);
    refuses(world_call_unlink("/tmp/roots"), EPERM);
    const int fd = world_call_open64("others/file", O_RDONLY);
    refuses(world_call_fchmod(fd, 0600), EPERM);
    refuses(world_call_fchown(fd, WORLD_UID, (gid_t)-1), EPERM);
    world_call_close(fd);
    return 0;
}

static void run_rights(void)
{
    world_disk_make_folder(disk(), "/home/others");
    world_disk_put(disk(), "/home/others/file", "x", 1);
    world_disk_put(disk(), "/tmp/roots", "x", 1);
    world_disk_make_folder(disk(), "/home/shut");
    world_disk_put(disk(), "/home/shut/file", "x", 1);
    world_disk_set_mode(disk(), "/tmp/roots", 0666, true);
    world_disk_set_mode(disk(), "/home/others/file", 0644, true);
    world_disk_set_mode(disk(), "/home/others", 0755, true);
    world_disk_set_mode(disk(), "/home/shut", 0644, false);
    bench_do(try_rights);
}

static void what_belongs_to_root_is_kept_from_tools(void **state)
{
    (void)state;
    bench_run(run_rights);
}

/* --- locks --- */

static int hold_lock(void)
{
    const int fd = world_call_open64("lock", O_RDWR | O_CREAT, 0600);
    assert_int_equal(world_call_flock(fd, LOCK_EX | LOCK_NB), 0);
    bench_pause(10 * WORLD_S);
    return 0;
}

static int want_lock(void)
{
    const int fd = world_call_open64("lock", O_RDWR | O_CREAT, 0600);
    const int second = world_call_open64("lock", O_RDONLY);
    refuses(world_call_flock(fd, LOCK_EX | LOCK_NB), EWOULDBLOCK);
    refuses(world_call_flock(fd, LOCK_SH | LOCK_NB), EWOULDBLOCK);
    assert_int_equal(world_call_flock(fd, LOCK_EX), 0);
    assert_true(world_now() >= 3 * WORLD_S);
    refuses(world_call_flock(second, LOCK_SH | LOCK_NB), EWOULDBLOCK);
    assert_int_equal(world_call_flock(fd, LOCK_SH), 0);
    assert_int_equal(world_call_flock(second, LOCK_SH | LOCK_NB), 0);
    return 0;
}

static void run_locks(void)
{
    world_process *holder = bench_start(hold_lock, NULL, NULL, NULL);
    bench_pause(WORLD_S);
    world_process *second = bench_start(want_lock, NULL, NULL, NULL);
    bench_pause(2 * WORLD_S);
    world_process_signal(holder, SIGKILL);
    assert_int_equal(bench_wait(second), 0);
}

static void a_lock_goes_with_its_process(void **state)
{
    (void)state;
    bench_run(run_locks);
}

/* --- faults --- */

static int write_slowly(void)
{
    make_closed("a", "1");
    return 0;
}

static void run_stall(void)
{
    world_disk_stall(disk(), WORLD_DISK_WRITE, WORLD_NEVER);
    world_process *writer = bench_start(write_slowly, NULL, NULL, NULL);
    assert_false(world_process_wait(writer, 100 * WORLD_S));
    world_disk_heal(disk());
    assert_int_equal(bench_wait(writer), 0);
    world_disk_remove(disk(), "/home/a");
    world_disk_stall(disk(), WORLD_DISK_ALL, 200 * WORLD_S);
    bench_do(write_slowly);
    assert_true(world_now() >= 200 * WORLD_S);
    world_disk_remove(disk(), "/home/a");
    world_disk_slow(disk(), WORLD_DISK_CLOSE, WORLD_S, 2 * WORLD_S);
    const int64_t before = world_now();
    bench_do(write_slowly);
    assert_true(world_now() >= before + WORLD_S);
    assert_true(world_now() < before + 3 * WORLD_S);
    world_disk_stall(disk(), WORLD_DISK_ALL, WORLD_NEVER);
    writer = bench_start(write_slowly, NULL, NULL, NULL);
    bench_pause(WORLD_S);
    world_process_signal(writer, SIGKILL);
    assert_true(WIFSIGNALED(bench_wait(writer)));
}

static void a_disk_stalls_for_a_time_or_until_it_is_healed(void **state)
{
    (void)state;
    bench_run(run_stall);
}

static int fill_disk(void)
{
    char bytes[6000] = {1};
    const int fd = world_call_open64("a", NEW, 0666);
    assert_int_equal(world_call_write(fd, bytes, 6000), 6000);
    assert_int_equal(world_call_write(fd, bytes, 6000), 4000);
    refuses(world_call_write(fd, bytes, 1), ENOSPC);
    refuses(world_call_open64("b", NEW, 0666), ENOSPC);
    assert_int_equal(world_call_pwrite64(fd, "over", 4, 0), 4);
    refuses(world_call_ftruncate64(fd, 20000), ENOSPC);
    assert_int_equal(world_call_unlink("a"), 0);
    refuses(world_call_open64("b", NEW, 0666), ENOSPC); /* still open */
    assert_int_equal(world_call_close(fd), 0);
    make_closed("b", "1");
    return 0;
}

static int fail_to_write(void)
{
    const int fd = world_call_open64("user", O_WRONLY | O_APPEND);
    refuses(world_call_write(fd, "x", 1), ENOSPC);
    return 0;
}

static void run_full(void)
{
    static const char bytes[5000] = {1};
    world_disk_fill(disk(), 10000);
    bench_do(fill_disk);
    world_disk_fill(disk(), 100);
    world_disk_put(disk(), "/home/user", bytes, sizeof bytes);
    assert_int_equal(world_disk_size(disk(), "/home/user"), 5000);
    bench_do(fail_to_write);
}

static void a_full_disk_takes_a_part_and_then_nothing(void **state)
{
    (void)state;
    bench_run(run_full);
}

static int meet_failures(void)
{
    struct stat status;
    const int fd = make("a", "1");
    world_disk_fail(disk(), WORLD_DISK_ALL & ~WORLD_DISK_CLOSE, 1.0, EIO);
    refuses(world_call_write(fd, "2", 1), EIO);
    refuses(world_call_fsync(fd), EIO);
    refuses(world_call_rename("a", "b"), EIO);
    refuses(world_call_unlink("a"), EIO);
    refuses(world_call_open64("a", O_RDONLY), EIO);
    refuses(world_call_stat64("a", &status), EIO);
    assert_true(world_call_open64("/dev/null", O_WRONLY) >= 0);
    world_disk_heal(disk());
    return 0;
}

static int meet_single_failures(void)
{
    char text[4];
    const int fd = make("b", "1");
    const int in = world_call_open64("b", O_RDONLY);
    world_disk_fail_nth(disk(), WORLD_DISK_READ | WORLD_DISK_CLOSE, 2, EIO);
    assert_int_equal(world_call_read(in, text, 1), 1);
    refuses(world_call_close(fd), EIO);
    refuses(world_call_close(fd), EBADF);
    assert_int_equal(world_call_read(in, text, 1), 0);
    return 0;
}

static int write_to_read_only(void)
{
    world_disk_set_read_only(disk(), true);
    refuses(world_call_open64("a", O_WRONLY), EROFS);
    refuses(world_call_open64("new", NEW, 0666), EROFS);
    refuses(world_call_mkdir("new", 0777), EROFS);
    refuses(world_call_rename("a", "b"), EROFS);
    refuses(world_call_access("a", W_OK), EROFS);
    assert_true(world_call_open64("a", O_RDONLY) >= 0);
    return 0;
}

static void run_failures(void)
{
    bench_do(meet_failures);
    bench_do(meet_single_failures);
    bench_do(write_to_read_only);
}

static void calls_fail_as_they_are_told_to(void **state)
{
    (void)state;
    bench_run(run_failures);
}

/* --- power --- */

static void sync_home(void)
{
    const int folder = world_call_open64("/home", O_RDONLY | O_DIRECTORY);
    assert_int_equal(world_call_fsync(folder), 0);
    assert_int_equal(world_call_close(folder), 0);
}

static int leave_things_behind(void)
{
    const int whole = make("whole", "all of it");
    assert_int_equal(world_call_fsync(whole), 0);
    assert_int_equal(world_call_write(whole, " and more", 9), 9);
    (void)make("empty", "not synced");
    sync_home();
    const int nameless = make("nameless", "synced");
    assert_int_equal(world_call_fsync(nameless), 0);
    const int part = make("part", "new");
    assert_int_equal(world_call_fsync(part), 0);
    assert_int_equal(world_call_rename("part", "old"), 0);
    assert_int_equal(world_call_unlink("removed"), 0);
    bench_pause(1000 * WORLD_S);
    return 0;
}

static void prepare_cut(void)
{
    world_disk_put(disk(), "/home/old", "old", 3);
    world_disk_put(disk(), "/home/removed", "x", 1);
    world_process *p = bench_start(leave_things_behind, NULL, NULL, NULL);
    bench_pause(WORLD_S);
    assert_false(p->has_ended);
}

static void run_cut(void)
{
    prepare_cut();
    world_host_power_cut(host, 0);
    has("/home/whole", "all of it");
    has("/home/empty", "");
    has("/home/old", "old");
    has("/home/removed", "x");
    assert_false(world_disk_has(disk(), "/home/nameless"));
    assert_false(world_disk_has(disk(), "/home/part"));
    assert_true(world_process_first()->has_ended);
}

static void run_kind_cut(void)
{
    prepare_cut();
    world_host_power_cut(host, 1.0);
    has("/home/whole", "all of it and more");
    has("/home/empty", "not synced");
    has("/home/nameless", "synced");
    has("/home/old", "new");
    assert_false(world_disk_has(disk(), "/home/removed"));
}

static int fail_to_sync(void)
{
    const int fd = make("a", "before");
    assert_int_equal(world_call_fsync(fd), 0);
    sync_home();
    assert_int_equal(world_call_pwrite64(fd, "AFTER!", 6, 0), 6);
    world_disk_fail_nth(disk(), WORLD_DISK_SYNC, 1, EIO);
    refuses(world_call_fsync(fd), EIO);
    assert_int_equal(world_call_fsync(fd), 0);
    return 0;
}

static void run_lost_sync(void)
{
    bench_do(fail_to_sync);
    has("/home/a", "AFTER!");
    world_host_power_cut(host, 0);
    has("/home/a", "before");
}

static void a_power_cut_keeps_what_was_synced(void **state)
{
    (void)state;
    bench_run(run_cut);
    bench_run(run_kind_cut);
}

static void a_sync_after_one_that_failed_promises_nothing(void **state)
{
    (void)state;
    bench_run(run_lost_sync);
}

/* --- who watches --- */

static char seen[512];

static void note(const world_name_event *event, void *argument)
{
    static const char *const words[] = {"made", "given", "removed", "lost"};
    char line[128];
    (void)snprintf(line, sizeof line, "%s %s %lld %s%s%s;",
                   words[event->change], event->path, (long long)event->size,
                   event->is_synced ? "synced" : "dirty",
                   event->from != NULL ? " from " : "",
                   event->from != NULL ? event->from : "");
    add(argument, sizeof seen, line);
}

static int change_names(void)
{
    const int a = make("a", "1");
    assert_int_equal(world_call_rename("a", "b"), 0);
    assert_int_equal(world_call_fsync(a), 0);
    assert_int_equal(world_call_rename("b", "c"), 0);
    assert_int_equal(world_call_mkdir("folder", 0777), 0);
    assert_int_equal(world_call_unlink("c"), 0);
    return 0;
}

static void run_watch(void)
{
    seen[0] = '\0';
    world_disk_watch(note, seen);
    bench_do(change_names);
    assert_string_equal(seen, "made /home/a 0 synced;"
                              "given /home/b 1 dirty from /home/a;"
                              "given /home/c 1 synced from /home/b;"
                              "removed /home/c 1 synced;");
}

static void whoever_watches_is_told_of_each_name(void **state)
{
    (void)state;
    bench_run(run_watch);
}

/* --- /dev and /proc --- */

static char *greet(world_host *of)
{
    char text[64];
    (void)snprintf(text, sizeof text, "of %s\n", of->name);
    return strdup(text);
}

static int look_at_system(void)
{
    char text[64] = "";
    const int made = world_call_open64("/proc/net/udp", O_RDONLY);
    assert_int_equal(world_call_read(made, text, sizeof text), 9);
    assert_memory_equal(text, "of bench\n", 9);
    const int comm = world_call_open64("/proc/self/comm", O_RDONLY);
    assert_int_equal(world_call_read(comm, text, sizeof text), 8);
    assert_memory_equal(text, "program\n", 8);
    const int again = world_call_open64("/dev/stdin", O_RDONLY);
    assert_int_equal(world_call_read(again, text, 2), 2);
    assert_memory_equal(text, "in", 2);
    int ends[2];
    assert_int_equal(world_call_pipe(ends), 0);
    DIR *folder = world_call_opendir("/proc/self/fd");
    assert_non_null(folder);
    (void)snprintf(text, sizeof text, "%d", ends[0]);
    char link[64] = "";
    assert_true(world_call_readlinkat(world_call_dirfd(folder), text, link,
                                      sizeof link - 1u) > 0);
    assert_memory_equal(link, "pipe:[", 6);
    bool is_listed = false;
    for (const struct dirent *e = world_call_readdir64(folder); e != NULL;
         e = world_call_readdir64(folder)) {
        is_listed = is_listed || strcmp(e->d_name, text) == 0;
    }
    assert_true(is_listed);
    assert_int_equal(world_call_closedir(folder), 0);
    refuses(world_call_open64("/proc/99999/comm", O_RDONLY), ENOENT);
    return 0;
}

static void run_system(void)
{
    world_disk_put_text(disk(), "/proc/net/udp", greet);
    world_disk_put(disk(), "/home/input", "input", 5);
    world_process *p = bench_start(
        look_at_system, world_disk_open(disk(), "/home/input", O_RDONLY), NULL,
        NULL);
    assert_int_equal(bench_wait(p), 0);
}

static void the_system_shows_its_processes(void **state)
{
    (void)state;
    bench_run(run_system);
}

/* --- names by chance --- */

static int make_temporaries(void)
{
    char first[] = "a.XXXXXX";
    char second[] = "a.XXXXXX";
    char folder[] = "/tmp/f-XXXXXX";
    assert_true(world_call_mkstemp64(first) >= 0);
    assert_true(world_call_mkstemp64(second) >= 0);
    assert_string_not_equal(first, second);
    assert_non_null(world_call_mkdtemp(folder));
    assert_int_equal(world_call_rmdir(folder), 0);
    refuses(world_call_mkstemp64((char[]){"short"}), EINVAL);
    const int fd = world_call_tmpfile_fd();
    struct stat status;
    assert_int_equal(world_call_fstat64(fd, &status), 0);
    assert_int_equal(status.st_nlink, 0);
    return 0;
}

static void run_temporaries(void)
{
    bench_do(make_temporaries);
}

static void temporary_names_are_new(void **state)
{
    (void)state;
    bench_run(run_temporaries);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_read_and_written_where_they_belong),
        cmocka_unit_test(what_was_never_written_is_zero),
        cmocka_unit_test(names_are_made_moved_and_removed),
        cmocka_unit_test(links_are_followed_unless_they_must_not),
        cmocka_unit_test(a_folder_is_read_in_the_order_of_its_making),
        cmocka_unit_test(what_belongs_to_root_is_kept_from_tools),
        cmocka_unit_test(a_lock_goes_with_its_process),
        cmocka_unit_test(a_disk_stalls_for_a_time_or_until_it_is_healed),
        cmocka_unit_test(a_full_disk_takes_a_part_and_then_nothing),
        cmocka_unit_test(calls_fail_as_they_are_told_to),
        cmocka_unit_test(a_power_cut_keeps_what_was_synced),
        cmocka_unit_test(a_sync_after_one_that_failed_promises_nothing),
        cmocka_unit_test(whoever_watches_is_told_of_each_name),
        cmocka_unit_test(the_system_shows_its_processes),
        cmocka_unit_test(temporary_names_are_new),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
