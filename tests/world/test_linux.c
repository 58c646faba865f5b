/* The same calls, by chance, to the world and to the system that this test runs
 * on: both give the same, with the same errno. */
#define _GNU_SOURCE
#include "bench.h"

#include "kernel/disk_calls.h"
#include "kernel/file_calls.h"
#include "kernel/signal_calls.h"
#include "kernel/stdio_calls.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define RUNS  40
#define STEPS 400
#define SLOTS 6

#ifndef __linux__
#error "the world is a Linux"
#endif

/* --- two systems --- */

typedef struct system_calls {
    int (*open)(const char *path, int flags, ...);
    int (*close)(int fd);
    ssize_t (*read)(int fd, void *out, size_t size);
    ssize_t (*write)(int fd, const void *bytes, size_t size);
    ssize_t (*pread)(int fd, void *out, size_t size, off_t at);
    ssize_t (*pwrite)(int fd, const void *bytes, size_t size, off_t at);
    off_t (*lseek)(int fd, off_t offset, int whence);
    int (*ftruncate)(int fd, off_t size);
    int (*fsync)(int fd);
    int (*dup2)(int from, int to);
    int (*fcntl)(int fd, int command, ...);
    int (*ioctl)(int fd, unsigned long request, ...);
    int (*pipe2)(int ends[2], int flags);
    int (*poll)(struct pollfd *set, nfds_t count, int wait_ms);
    int (*flock)(int fd, int operation);
    int (*fstat)(int fd, struct stat *out);
    int (*stat)(const char *path, struct stat *out);
    int (*lstat)(const char *path, struct stat *out);
    int (*access)(const char *path, int rights);
    int (*mkdir)(const char *path, mode_t mode);
    int (*rmdir)(const char *path);
    int (*rename)(const char *from, const char *to);
    int (*unlink)(const char *path);
    ssize_t (*readlink)(const char *path, char *out, size_t room);
    char *(*realpath)(const char *path, char *out);
    DIR *(*opendir)(const char *path);
    struct dirent *(*readdir)(DIR *folder);
    int (*closedir)(DIR *folder);
    FILE *(*fopen)(const char *path, const char *mode);
    int (*fclose)(FILE *file);
    size_t (*fwrite)(const void *bytes, size_t size, size_t count, FILE *file);
    size_t (*fread)(void *out, size_t size, size_t count, FILE *file);
    char *(*fgets)(char *out, int room, FILE *file);
    int (*fputc)(int c, FILE *file);
    int (*fflush)(FILE *file);
    int (*fseek)(FILE *file, long offset, int whence);
    long (*ftell)(FILE *file);
    int (*feof)(FILE *file);
    int (*ferror)(FILE *file);
} system_calls;

static const system_calls of_host = {
    open,     close,   read,    write,    pread, pwrite, lseek,  ftruncate,
    fsync,    dup2,    fcntl,   ioctl,    pipe2, poll,   flock,  fstat,
    stat,     lstat,   access,  mkdir,    rmdir, rename, unlink, readlink,
    realpath, opendir, readdir, closedir, fopen, fclose, fwrite, fread,
    fgets,    fputc,   fflush,  fseek,    ftell, feof,   ferror};

static const system_calls of_world = {
    world_call_open64,   world_call_close,       world_call_read,
    world_call_write,    world_call_pread64,     world_call_pwrite64,
    world_call_lseek64,  world_call_ftruncate64, world_call_fsync,
    world_call_dup2,     world_call_fcntl64,     world_call_ioctl,
    world_call_pipe2,    world_call_poll,        world_call_flock,
    world_call_fstat64,  world_call_stat64,      world_call_lstat64,
    world_call_access,   world_call_mkdir,       world_call_rmdir,
    world_call_rename,   world_call_unlink,      world_call_readlink,
    world_call_realpath, world_call_opendir,     world_call_readdir64,
    world_call_closedir, world_call_fopen64,     world_call_fclose,
    world_call_fwrite,   world_call_fread,       world_call_fgets,
    world_call_fputc,    world_call_fflush,      world_call_fseek,
    world_call_ftell,    world_call_feof,        world_call_ferror};

/* What a run did, line by line. */
typedef struct diary {
    const system_calls *calls;
    uint64_t chance;
    int slots[SLOTS];
    char *text;
    size_t len, room;
} diary;

static uint64_t run_seed;

/* --- chance and record --- */

static unsigned below(diary *d, unsigned n)
{
    d->chance = d->chance * UINT64_C(6364136223846793005) +
                UINT64_C(1442695040888963407);
    return (unsigned)(d->chance >> 33) % n;
}

__attribute__((format(printf, 2, 3))) static void note(diary *d,
                                                       const char *format, ...)
{
    va_list arguments;
    if (d->room - d->len < 512) {
        d->room += 65536;
        d->text = realloc(d->text, d->room);
        assert_non_null(d->text);
    }
    va_start(arguments, format);
    d->len += (size_t)vsnprintf(d->text + d->len, d->room - d->len, format,
                                arguments);
    va_end(arguments);
}

/* A result as it is; errno where it is below 0. */
static void note_result(diary *d, const char *call, long long result)
{
    const int code = errno;
    if (result < 0) {
        note(d, "%s: %s\n", call, strerrorname_np(code));
    } else {
        note(d, "%s: %lld\n", call, result);
    }
}

static void note_done(diary *d, const char *call, int result)
{
    note_result(d, call, result < 0 ? -1 : 0);
}

static void note_status(diary *d, const char *call, int result,
                        const struct stat *s)
{
    note_done(d, call, result);
    if (result == 0) {
        const bool is_file = S_ISREG(s->st_mode);
        note(d, "  %o size %lld links %d\n", s->st_mode & (unsigned)S_IFMT,
             is_file ? (long long)s->st_size : 0,
             is_file ? (int)s->st_nlink : 0);
    }
}

static const char *path(diary *d)
{
    static const char *const paths[] = {
        "a",    "b",  "d",    "d/a",    "d/e",    "d/e/a", "a/x",
        "link", "ld", "ld/a", "loop",   "lost",   "d/..",  "d/../a",
        "",     "d/", "a/",   "none/x", "./a",    "d//a",  "d/e/f",
        ".",    "p",  "ld/",  "loop/a", "lost/a", "d/./e", "link/x"};
    return paths[below(d, sizeof paths / sizeof paths[0])];
}

static int *slot(diary *d)
{
    return &d->slots[below(d, SLOTS)];
}

/* --- steps --- */

static void step_open(diary *d)
{
    static const int flags[] = {O_RDONLY,
                                O_WRONLY,
                                O_RDWR,
                                O_RDWR | O_CREAT,
                                O_WRONLY | O_CREAT | O_EXCL,
                                O_WRONLY | O_CREAT | O_TRUNC,
                                O_WRONLY | O_APPEND,
                                O_RDWR | O_CREAT | O_APPEND,
                                O_RDONLY | O_NOFOLLOW,
                                O_RDWR | O_CREAT | O_NOFOLLOW,
                                O_RDONLY | O_DIRECTORY,
                                O_WRONLY | O_TRUNC,
                                O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW};
    int *to = slot(d);
    const int with = flags[below(d, sizeof flags / sizeof flags[0])];
    const char *name = path(d);
    if (*to >= 0) {
        note_done(d, "close", d->calls->close(*to));
    }
    *to = d->calls->open(name, with | O_NONBLOCK | O_CLOEXEC, 0666);
    note(d, "%s %o ", name, (unsigned)with);
    note_done(d, "open", *to);
}

static void step_close(diary *d)
{
    int *of = slot(d);
    note_done(d, "close", d->calls->close(*of));
    *of = -1;
}

static unsigned some_bytes(diary *d)
{
    static const unsigned sizes[] = {0, 1, 10, 100, 4095, 4096, 5000, 20000};
    return sizes[below(d, sizeof sizes / sizeof sizes[0])];
}

static void note_bytes(diary *d, const char *bytes, ssize_t n)
{
    unsigned sum = 0;
    for (ssize_t i = 0; i < n; i++) {
        sum = sum * 31u + (unsigned char)bytes[i];
    }
    note(d, "  sum %u\n", sum);
}

static void step_read(diary *d)
{
    static char bytes[20000];
    const int fd = *slot(d);
    const unsigned size = some_bytes(d);
    const ssize_t n = below(d, 2) == 0 ? d->calls->read(fd, bytes, size)
                                       : d->calls->pread(fd, bytes, size,
                                                         (off_t)below(d, 9000));
    note_result(d, "read", n);
    note_bytes(d, bytes, n);
}

static void step_write(diary *d)
{
    static char bytes[20000];
    const int fd = *slot(d);
    const unsigned size = some_bytes(d);
    memset(bytes, 'a' + (int)below(d, 26), size);
    note_result(d, "write",
                below(d, 2) == 0
                    ? d->calls->write(fd, bytes, size)
                    : d->calls->pwrite(fd, bytes, size, (off_t)below(d, 9000)));
}

static void step_seek(diary *d)
{
    static const int whences[] = {SEEK_SET, SEEK_CUR, SEEK_END};
    struct stat status;
    const int fd = *slot(d);
    const off_t by = (off_t)below(d, 9000) - 1000;
    const int whence = whences[below(d, 3)];
    /* Positions in folders are the file system's own. */
    const bool is_folder =
        fd >= 0 && d->calls->fstat(fd, &status) == 0 && S_ISDIR(status.st_mode);
    if (!is_folder) {
        note_result(d, "lseek", d->calls->lseek(fd, by, whence));
    }
}

static void step_size(diary *d)
{
    const int fd = *slot(d);
    note_done(d, "ftruncate",
              d->calls->ftruncate(fd, (off_t)below(d, 9000) - 10));
    note_done(d, "fsync", d->calls->fsync(fd));
}

static void step_copy(diary *d)
{
    const int from = *slot(d);
    int *to = slot(d);
    if (*to >= 0 && *to != from) {
        note_done(d, "dup2", d->calls->dup2(from, *to));
    } else if (*to < 0) {
        *to = d->calls->fcntl(from, F_DUPFD_CLOEXEC, 10);
        note_done(d, "dup", *to);
    }
}

static void step_flags(diary *d)
{
    const int fd = *slot(d);
    int held = -1;
    const int seen = d->calls->fcntl(fd, F_GETFL);
    const int shown = O_ACCMODE | O_NONBLOCK | O_APPEND;
    note_result(d, "flags", seen < 0 ? -1 : seen & shown);
    note_result(d, "fdflags", d->calls->fcntl(fd, F_GETFD));
    (void)held;
}

static void step_pipe(diary *d)
{
    int *in = &d->slots[below(d, SLOTS / 2)];
    int *out = in + SLOTS / 2;
    int ends[2] = {-1, -1};
    note_done(d, "close", *in < 0 ? 0 : d->calls->close(*in));
    note_done(d, "close", *out < 0 ? 0 : d->calls->close(*out));
    note_done(d, "pipe", d->calls->pipe2(ends, O_NONBLOCK | O_CLOEXEC));
    *in = ends[0];
    *out = ends[1];
}

static void step_poll(diary *d)
{
    struct pollfd set[SLOTS];
    for (int i = 0; i < SLOTS; i++) {
        set[i] = (struct pollfd){.fd = d->slots[i], .events = POLLIN | POLLOUT};
    }
    note_result(d, "poll", d->calls->poll(set, SLOTS, 0));
    for (int i = 0; i < SLOTS; i++) {
        note(d, "  %d", set[i].revents);
    }
    note(d, "\n");
}

static void step_lock(diary *d)
{
    static const int operations[] = {LOCK_SH, LOCK_EX, LOCK_UN};
    struct stat status;
    const int fd = *slot(d);
    const int operation = operations[below(d, 3)] | LOCK_NB;
    const bool is_pipe = fd >= 0 && d->calls->fstat(fd, &status) == 0 &&
                         S_ISFIFO(status.st_mode);
    if (!is_pipe) { /* the world has no locks of pipes */
        note_done(d, "flock", d->calls->flock(fd, operation));
    }
}

static void step_look(diary *d)
{
    struct stat s;
    const char *name = path(d);
    const int fd = *slot(d);
    note(d, "%s ", name);
    note_status(d, "stat", d->calls->stat(name, &s), &s);
    note_status(d, "lstat", d->calls->lstat(name, &s), &s);
    note_done(d, "access", d->calls->access(name, F_OK));
    note_status(d, "fstat", d->calls->fstat(fd, &s), &s);
}

static void step_name(diary *d)
{
    const char *name = path(d);
    note(d, "%s ", name);
    switch (below(d, 4)) {
    case 0:
        note_done(d, "mkdir", d->calls->mkdir(name, 0777));
        break;
    case 1:
        note_done(d, "rmdir", d->calls->rmdir(name));
        break;
    default:
        note_done(d, "unlink", d->calls->unlink(name));
        break;
    }
}

static void step_rename(diary *d)
{
    const char *from = path(d);
    const char *to = path(d);
    note(d, "%s to %s ", from, to);
    note_done(d, "rename", d->calls->rename(from, to));
}

static void step_link(diary *d)
{
    char text[PATH_MAX];
    const char *name = path(d);
    const ssize_t n = d->calls->readlink(name, text, 4);
    note(d, "%s ", name);
    note_result(d, "readlink", n);
    const char *whole = d->calls->realpath(name, text);
    note_done(d, "realpath", whole == NULL ? -1 : 0);
    const char *last = whole != NULL ? strrchr(whole, '/') : NULL;
    note(d, "  %s\n",
         last == NULL || strcmp(name, ".") == 0 || strcmp(name, "d/..") == 0
             ? ""
             : last);
}

/* Names as bits: their order is the file system's. */
static void step_folder(diary *d)
{
    const char *name = path(d);
    DIR *folder = d->calls->opendir(name);
    unsigned sum = 0;
    note(d, "%s ", name);
    note_done(d, "opendir", folder == NULL ? -1 : 0);
    for (const struct dirent *e = NULL;
         folder != NULL && (e = d->calls->readdir(folder)) != NULL;) {
        sum += (unsigned char)e->d_name[0] + (unsigned)strlen(e->d_name) +
               (e->d_type == DT_DIR ? 1000u : 0);
    }
    note(d, "  sum %u\n", sum);
    if (folder != NULL) {
        note_done(d, "closedir", d->calls->closedir(folder));
    }
}

/* --- streams --- */

static void read_stream(diary *d, FILE *f)
{
    static char bytes[20000];
    if (below(d, 2) == 0) {
        const unsigned size = some_bytes(d);
        note_result(d, "fread", (long long)d->calls->fread(bytes, 1, size, f));
    } else {
        bytes[0] = '\0';
        note(d, "fgets %d %.50s\n",
             d->calls->fgets(bytes, 50, f) != NULL ? 0 : 1, bytes);
    }
}

static void write_stream(diary *d, FILE *f)
{
    static char bytes[20000];
    const unsigned size = some_bytes(d);
    memset(bytes, 'A' + (int)below(d, 26), size);
    if (size > 0) {
        bytes[below(d, size)] = '\n';
    }
    switch (below(d, 3)) {
    case 0:
        note_result(d, "fwrite",
                    (long long)d->calls->fwrite(bytes, 1, size, f));
        break;
    case 1:
        note_result(d, "fputc", d->calls->fputc('c', f));
        break;
    default:
        note_done(d, "fflush", d->calls->fflush(f));
        break;
    }
}

static void use_stream(diary *d, FILE *f, const char *mode)
{
    if (below(d, 4) == 0) {
        const int whence = below(d, 2) == 0 ? SEEK_SET : SEEK_END;
        note_done(d, "fseek", d->calls->fseek(f, (long)below(d, 9000), whence));
    } else if (mode[0] == 'r') {
        read_stream(d, f);
    } else {
        write_stream(d, f);
    }
    note_result(d, "feof", d->calls->feof(f) != 0);
    note_result(d, "ferror", d->calls->ferror(f) != 0);
    if (mode[0] != 'a') { /* where it is before it has written is its own */
        note_result(d, "ftell", d->calls->ftell(f));
    }
}

static void step_stream(diary *d)
{
    static const char *const modes[] = {"r", "w", "a"};
    const char *mode = modes[below(d, 3)];
    FILE *f = d->calls->fopen("s", mode);
    note(d, "%s ", mode);
    note_done(d, "fopen", f != NULL ? 0 : -1);
    for (int i = 0; f != NULL && i < 12; i++) {
        use_stream(d, f, mode);
    }
    if (f != NULL) {
        note_done(d, "fclose", d->calls->fclose(f));
    }
}

/* --- a run --- */

static void (*const steps[])(diary *d) = {
    step_open,  step_open,   step_open, step_close,  step_read,  step_read,
    step_write, step_write,  step_seek, step_size,   step_copy,  step_flags,
    step_pipe,  step_poll,   step_lock, step_look,   step_look,  step_name,
    step_name,  step_rename, step_link, step_folder, step_stream};

static void run_steps(diary *d, const system_calls *calls)
{
    *d = (diary){.calls = calls, .chance = run_seed};
    memset(d->slots, -1, sizeof d->slots);
    for (int i = 0; i < STEPS; i++) {
        note(d, "%d ", i);
        steps[below(d, sizeof steps / sizeof steps[0])](d);
    }
    for (int i = 0; i < SLOTS; i++) {
        if (d->slots[i] >= 0) {
            (void)calls->close(d->slots[i]);
        }
    }
}

static diary in_world, in_host;

static int do_in_world(void)
{
    const struct sigaction action = {.sa_handler = SIG_IGN};
    assert_int_equal(world_call_sigaction(SIGPIPE, &action, NULL), 0);
    run_steps(&in_world, &of_world);
    return 0;
}

static void run_world(void)
{
    world_disk *disk = world_disk_of(host);
    world_disk_make_folder(disk, "/home/d");
    world_disk_make_link(disk, "/home/link", "d/a");
    world_disk_make_link(disk, "/home/ld", "d");
    world_disk_make_link(disk, "/home/loop", "loop");
    world_disk_make_link(disk, "/home/lost", "nowhere");
    world_disk_make_fifo(disk, "/home/p");
    bench_do(do_in_world);
}

static int remove_one(const char *name, const struct stat *status, int kind,
                      struct FTW *place)
{
    (void)status;
    (void)kind;
    (void)place;
    return remove(name);
}

static void run_host(void)
{
    /* In memory, where there is such a place: each fsync() costs. */
    const bool has_memory = access("/dev/shm", W_OK) == 0;
    char folder[64];
    (void)snprintf(folder, sizeof folder, "%s/lum-world-XXXXXX",
                   has_memory ? "/dev/shm" : "/tmp");
    assert_non_null(mkdtemp(folder));
    const int before = open(".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    assert_true(before >= 0);
    assert_int_equal(chdir(folder), 0);
    assert_int_equal(mkdir("d", 0777), 0);
    assert_int_equal(symlink("d/a", "link") | symlink("d", "ld") |
                         symlink("loop", "loop") | symlink("nowhere", "lost") |
                         mkfifo("p", 0644),
                     0);
    run_steps(&in_host, &of_host);
    assert_int_equal(fchdir(before), 0);
    assert_int_equal(close(before), 0);
    assert_int_equal(nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS), 0);
}

/* Up to the first line that differs, with what led to it. */
static void show_difference(void)
{
    const char *a = in_host.text;
    const char *b = in_world.text;
    size_t i = 0;
    while (a[i] != '\0' && a[i] == b[i]) {
        i++;
    }
    const size_t from = i > 600 ? i - 600 : 0;
    print_message("run %llu: ...%.*s\n--- Linux: %.60s\n--- world: %.60s\n",
                  (unsigned long long)run_seed, (int)(i - from), a + from,
                  a + i, b + i);
}

static void the_world_answers_as_linux_does(void **state)
{
    (void)state;
    (void)signal(SIGPIPE, SIG_IGN);
    unsigned differing = 0;
    for (run_seed = 1; run_seed <= RUNS; run_seed++) {
        bench_run(run_world);
        run_host();
        if (strcmp(in_host.text, in_world.text) != 0) {
            differing++;
            show_difference();
        }
        free(in_host.text);
        free(in_world.text);
        if (differing == 5) {
            break;
        }
    }
    assert_int_equal(differing, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_world_answers_as_linux_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
