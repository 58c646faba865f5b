#define _GNU_SOURCE /* F_DUPFD_CLOEXEC, struct winsize */
#include "file_calls.h"

#include "file.h"
#include "host.h"
#include "pipe.h"
#include "process.h"
#include "signals.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#define CALL_NS WORLD_US

static int refuse(int code)
{
    errno = code;
    return -1;
}

static bool may_read(const world_file *file)
{
    return (file->flags & O_ACCMODE) != O_WRONLY;
}

static bool may_write(const world_file *file)
{
    return (file->flags & O_ACCMODE) != O_RDONLY;
}

/* --- Reading and writing --- */

static ssize_t read_file(world_file *file, void *out, size_t size)
{
    if (file->kind->read != NULL) {
        return may_read(file) ? file->kind->read(file, out, size)
                              : refuse(EBADF);
    }
    if (file->kind->recvmsg != NULL) {
        struct iovec part = {.iov_base = out, .iov_len = size};
        struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
        return file->kind->recvmsg(file, &message, 0);
    }
    return refuse(may_read(file) ? EINVAL : EBADF);
}

ssize_t world_call_read(int fd, void *out, size_t size)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const ssize_t n = read_file(file, out, size);
    world_fd_release(file);
    return n;
}

/* Only what was taken: the rest is written again. */
static ssize_t with_digest(const void *bytes, ssize_t taken)
{
    if (taken > 0) {
        world_digest_bytes(bytes, (size_t)taken);
    }
    return taken;
}

static ssize_t write_file(world_file *file, const void *bytes, size_t size)
{
    if (file->kind->write != NULL) {
        return may_write(file)
                   ? with_digest(bytes, file->kind->write(file, bytes, size))
                   : refuse(EBADF);
    }
    if (file->kind->sendmsg != NULL) {
        struct iovec part = {.iov_len = size};
        const struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
        part.iov_base = (void *)(uintptr_t)bytes; /* only read */
        return file->kind->sendmsg(file, &message, 0);
    }
    return refuse(may_write(file) ? EINVAL : EBADF);
}

ssize_t world_call_write(int fd, const void *bytes, size_t size)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const ssize_t n = write_file(file, bytes, size);
    world_fd_release(file);
    return n;
}

ssize_t world_call_pread64(int fd, void *out, size_t size, int64_t at)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const ssize_t n = file->kind->pread == NULL ? refuse(ESPIPE)
                      : !may_read(file)         ? refuse(EBADF)
                      : at < 0                  ? refuse(EINVAL)
                               : file->kind->pread(file, out, size, at);
    world_fd_release(file);
    return n;
}

ssize_t world_call_pwrite64(int fd, const void *bytes, size_t size, int64_t at)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const ssize_t n =
        file->kind->pwrite == NULL ? refuse(ESPIPE)
        : !may_write(file)         ? refuse(EBADF)
        : at < 0
            ? refuse(EINVAL)
            : with_digest(bytes, file->kind->pwrite(file, bytes, size, at));
    world_fd_release(file);
    return n;
}

int64_t world_call_lseek64(int fd, int64_t offset, int whence)
{
    world_call(CALL_NS);
    world_file *file = world_fd_file(world_process_self(), fd);
    if (file == NULL) {
        return -1;
    }
    return file->kind->seek != NULL ? file->kind->seek(file, offset, whence)
                                    : refuse(ESPIPE);
}

int world_call_fsync(int fd)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const int result =
        file->kind->sync != NULL ? file->kind->sync(file) : refuse(EINVAL);
    world_fd_release(file);
    return result;
}

int world_call_fdatasync(int fd)
{
    return world_call_fsync(fd);
}

/* Only begins it: nothing is promised after a power cut. */
int world_call_sync_file_range(int fd, int64_t offset, int64_t size,
                               unsigned flags)
{
    (void)offset;
    (void)size;
    (void)flags;
    world_call(CALL_NS);
    const world_file *file = world_fd_file(world_process_self(), fd);
    return file == NULL ? -1 : file->kind->seek == NULL ? refuse(ESPIPE) : 0;
}

/* What is read of a file does not depend on where its pages are. */
int world_call_posix_fadvise64(int fd, int64_t offset, int64_t size, int advice)
{
    (void)offset;
    (void)size;
    (void)advice;
    world_call(CALL_NS);
    const world_file *file = world_fd_file(world_process_self(), fd);
    return file == NULL ? EBADF : file->kind->seek == NULL ? ESPIPE : 0;
}

/* A file system without a name that any program knows. */
int world_call_fstatfs64(int fd, struct statfs *status)
{
    world_call(CALL_NS);
    if (world_fd_file(world_process_self(), fd) == NULL) {
        return refuse(EBADF);
    }
    memset(status, 0, sizeof *status);
    return 0;
}

/* As where a file system cannot reserve places. */
int world_call_fallocate64(int fd, int mode, int64_t offset, int64_t size)
{
    (void)mode;
    (void)offset;
    (void)size;
    world_call(CALL_NS);
    const world_file *file = world_fd_file(world_process_self(), fd);
    return refuse(file == NULL ? EBADF : EOPNOTSUPP);
}

/* As where nobody knows what is free. */
int world_call_statvfs64(const char *path, struct statvfs *out)
{
    (void)path;
    (void)out;
    world_call(CALL_NS);
    return refuse(ENOSYS);
}

int world_call_ftruncate64(int fd, int64_t size)
{
    world_call(CALL_NS);
    if (size < 0) {
        return refuse(EINVAL);
    }
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    const int result = file->kind->truncate == NULL || !may_write(file)
                           ? refuse(EINVAL)
                           : file->kind->truncate(file, size);
    world_fd_release(file);
    return result;
}

/* --- Descriptors --- */

/* As Linux, the descriptor is gone also where the close fails. */
int world_call_close(int fd)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    process->fds[fd].file = NULL;
    const int result = file->kind->flush != NULL ? file->kind->flush(file) : 0;
    const int code = errno;
    world_file_drop(file);
    world_fd_release(file);
    errno = code;
    return result;
}

/* The lowest free one from a number on. */
static int duplicate(world_process *process, int from, int lowest, int flags)
{
    world_file *file = world_fd_file(process, from);
    if (file == NULL) {
        return -1;
    }
    if (lowest < 0 || lowest >= WORLD_FDS) {
        return refuse(EINVAL);
    }
    for (int fd = lowest; fd < WORLD_FDS; fd++) {
        if (process->fds[fd].file == NULL) {
            process->fds[fd].file = world_file_use(file);
            process->fds[fd].flags = flags;
            return fd;
        }
    }
    return refuse(EMFILE);
}

int world_call_dup(int fd)
{
    world_call(CALL_NS);
    return duplicate(world_process_self(), fd, 0, 0);
}

int world_call_dup2(int from, int to)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    world_file *file = world_fd_file(process, from);
    if (file == NULL) {
        return -1;
    }
    if (to < 0 || to >= WORLD_FDS) {
        return refuse(EBADF);
    }
    if (from != to) {
        world_file *old = process->fds[to].file;
        process->fds[to].file = world_file_use(file);
        process->fds[to].flags = 0;
        if (old != NULL) {
            world_file_drop(old);
        }
    }
    return to;
}

/* Only these flags can be changed after the open. */
static int set_flags(world_file *file, int flags)
{
    const int settable = O_NONBLOCK | O_APPEND;
    file->flags = (file->flags & ~settable) | (flags & settable);
    return 0;
}

int world_call_fcntl64(int fd, int command, ...)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    world_file *file = world_fd_file(process, fd);
    va_list arguments;
    va_start(arguments, command);
    const int argument =
        command == F_GETFD || command == F_GETFL ? 0 : va_arg(arguments, int);
    va_end(arguments);
    if (file == NULL) {
        return -1;
    }
    switch (command) {
    case F_DUPFD:
        return duplicate(process, fd, argument, 0);
    case F_DUPFD_CLOEXEC:
        return duplicate(process, fd, argument, FD_CLOEXEC);
    case F_GETFD:
        return process->fds[fd].flags;
    case F_SETFD:
        process->fds[fd].flags = argument & FD_CLOEXEC;
        return 0;
    case F_GETFL:
        return file->flags;
    case F_SETFL:
        return set_flags(file, argument);
    default:
        return refuse(EINVAL);
    }
}

/* Without O_CLOEXEC and O_NONBLOCK in flags: neither. */
int world_call_pipe2(int ends[2], int flags)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    world_file *read_end = NULL;
    world_file *write_end = NULL;
    const int of_fd = (flags & O_CLOEXEC) != 0 ? FD_CLOEXEC : 0;
    world_pipe_make(&read_end, &write_end, flags & O_NONBLOCK);
    const int in = world_fd_take(process, read_end, of_fd);
    if (in < 0) {
        world_file_drop(write_end);
        return refuse(EMFILE);
    }
    const int out = world_fd_take(process, write_end, of_fd);
    if (out < 0) {
        process->fds[in].file = NULL;
        world_file_drop(read_end);
        return refuse(EMFILE);
    }
    ends[0] = in;
    ends[1] = out;
    return 0;
}

int world_call_pipe(int ends[2])
{
    return world_call_pipe2(ends, 0);
}

/* --- What they are --- */

int world_call_fstat64(int fd, struct stat *out)
{
    world_call(CALL_NS);
    world_file *file = world_fd_file(world_process_self(), fd);
    if (file == NULL) {
        return -1;
    }
    *out = (struct stat){0};
    if (file->kind->stat != NULL) {
        return file->kind->stat(file, out);
    }
    out->st_mode = S_IFSOCK | S_IRWXU | S_IRWXG | S_IRWXO;
    out->st_ino = file->number;
    out->st_nlink = 1;
    out->st_blksize = 4096;
    return 0;
}

static int control(int fd, unsigned long request, void *argument)
{
    world_file *file = world_fd_file(world_process_self(), fd);
    if (file == NULL) {
        return -1;
    }
    return file->kind->ioctl != NULL
               ? file->kind->ioctl(file, request, argument)
               : refuse(ENOTTY);
}

int world_call_ioctl(int fd, unsigned long request, ...)
{
    world_call(CALL_NS);
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    return control(fd, request, argument);
}

int world_call_isatty(int fd)
{
    struct winsize size;
    world_call(CALL_NS);
    return control(fd, TIOCGWINSZ, &size) == 0 ? 1 : 0;
}

pid_t world_call_tcgetpgrp(int fd)
{
    pid_t group = 0;
    world_call(CALL_NS);
    return control(fd, TIOCGPGRP, &group) == 0 ? group : -1;
}

int world_call_tcsetpgrp(int fd, pid_t group)
{
    world_call(CALL_NS);
    return control(fd, TIOCSPGRP, &group);
}

/* --- Waiting for several --- */

static short events_of(world_file *file, short asked)
{
    const short always = POLLERR | POLLHUP;
    const short now = file->kind->poll != NULL
                          ? file->kind->poll(file)
                          : (short)(POLLIN | POLLOUT | POLLRDNORM | POLLWRNORM);
    return (short)(now & (asked | always));
}

/* How many of the set have events. Descriptors below 0 are left out. */
static int look(struct pollfd *set, nfds_t count, world_file *const *files)
{
    int ready = 0;
    for (nfds_t i = 0; i < count; i++) {
        set[i].revents = 0;
        if (files[i] != NULL) {
            set[i].revents = events_of(files[i], set[i].events);
        } else if (set[i].fd >= 0) {
            set[i].revents = POLLNVAL;
        }
        ready += set[i].revents != 0 ? 1 : 0;
    }
    return ready;
}

static int wait_for(struct pollfd *set, nfds_t count, world_file *const *files,
                    int64_t until_ns)
{
    world_queue *queues[WORLD_WAITS];
    world_queue nothing = {NULL, NULL};
    unsigned n = 0;
    for (nfds_t i = 0; i < count; i++) {
        if (files[i] != NULL) {
            queues[n++] = files[i]->changed;
        }
    }
    if (n == 0) {
        queues[n++] = &nothing;
    }
    world_wake woken = WORLD_WOKEN;
    int ready = look(set, count, files);
    while (ready == 0 && woken == WORLD_WOKEN && until_ns > world_now()) {
        woken = world_wait_any(queues, n, until_ns);
        if (woken == WORLD_INTERRUPTED) {
            return refuse(EINTR); /* whatever the handler made ready */
        }
        ready = look(set, count, files);
    }
    return ready;
}

static int poll_until(struct pollfd *set, nfds_t count, int64_t until_ns)
{
    world_file *files[WORLD_WAITS];
    if (count > WORLD_WAITS) {
        world_fail("poll() of %lu descriptors: the world takes %d",
                   (unsigned long)count, WORLD_WAITS);
        return refuse(EINVAL);
    }
    for (nfds_t i = 0; i < count; i++) {
        files[i] = set[i].fd >= 0 ? world_fd_hold(set[i].fd) : NULL;
    }
    const int result = wait_for(set, count, files, until_ns);
    for (nfds_t i = 0; i < count; i++) {
        if (files[i] != NULL) {
            world_fd_release(files[i]);
        }
    }
    return result;
}

/* The moment of true time after a wait by the host's clock. Waits of 0 do not
 * wait; those below it have no end. */
static int64_t end_of(int64_t wait_ns)
{
    const world_host *host = world_process_self()->host;
    return wait_ns == 0
               ? world_now()
               : world_host_true_ns(host, world_host_mono_ns(host) + wait_ns);
}

int world_call_poll(struct pollfd *set, nfds_t count, int wait_ms)
{
    world_call(CALL_NS);
    return poll_until(set, count,
                      wait_ms < 0 ? WORLD_NEVER : end_of(wait_ms * WORLD_MS));
}

int world_call_ppoll(struct pollfd *set, nfds_t count,
                     const struct timespec *wait, const sigset_t *mask)
{
    world_call(CALL_NS);
    if (wait != NULL &&
        (wait->tv_sec < 0 || wait->tv_nsec < 0 || wait->tv_nsec >= WORLD_S)) {
        return refuse(EINVAL);
    }
    const int64_t most_s = INT64_C(1000000000);
    const bool is_endless = wait == NULL || wait->tv_sec > most_s;
    sigset_t before;
    if (mask != NULL) {
        world_signal_mask(mask, &before);
    }
    const int result =
        poll_until(set, count,
                   is_endless ? WORLD_NEVER
                              : end_of(wait->tv_sec * WORLD_S + wait->tv_nsec));
    if (mask != NULL) {
        world_signal_mask(&before, NULL);
    }
    return result;
}
