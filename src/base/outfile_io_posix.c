/* Writes bytes to an output on POSIX: reserves disk space ahead, and starts
 * their way to the disk early. */
#define _POSIX_C_SOURCE 200809L
#define _GNU_SOURCE     /* sync_file_range, fallocate, F_SETPIPE_SZ */

#include "outfile_io.h"
#include "outfile_parts.h"

#include "system.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#if defined(__linux__)
#include <linux/magic.h>
#include <sys/vfs.h>
#endif

#define BEGIN_SIZE   ((size_t)8 << 20)   /* bytes worth starting a write */
#define KEPT_SIZE    ((int64_t)64 << 20) /* for readers of a growing file */
#define RESERVE_SIZE ((int64_t)64 << 20) /* places on the disk at a time */

/* Of a pipe, four times the usual: its reader is woken less often. */
#define PIPE_ROOM (256 << 10)

/* --- What makes writing quicker, on Linux --- */

#if defined(__linux__)

/* Open a pipe again, so that a write takes what there is room for and does not
 * wait, and make more room in it. Others that hold the pipe do not notice:
 * O_NONBLOCK belongs to an opening. Descriptors of standard streams stay free,
 * where they are closed.
 * Returns a second descriptor; -1: it is no pipe, or the system cannot. */
static int open_pipe(int fd)
{
    char name[32];
    struct stat status;
    if (fstat(fd, &status) != 0 || !S_ISFIFO(status.st_mode)) {
        return -1;
    }
    (void)snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    const int opened = open(name, O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (opened < 0) {
        return -1;
    }
    const int again = fcntl(opened, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    (void)close(opened);
    if (fcntl(again, F_GETPIPE_SZ) < PIPE_ROOM) {
        (void)fcntl(again, F_SETPIPE_SZ, PIPE_ROOM);
    }
    return again;
}

/* Whether places on the disk, reserved, make writing quicker and nobody misses
 * them: on ext4 each write() would look for places itself, and there is room
 * for many times as much. tmpfs would fill the memory with zeros, btrfs would
 * not compress any more. */
static bool can_reserve(int fd)
{
    struct statfs status;
    return fstatfs(fd, &status) == 0 && status.f_type == EXT4_SUPER_MAGIC &&
           status.f_bsize > 0 &&
           status.f_bavail / 16u >=
               (uint64_t)RESERVE_SIZE / (uint64_t)status.f_bsize;
}

/* Have places for what is written next. Only of a file that is removed if this
 * process ends before its time: others would keep them. */
static void reserve(lum_outfile *file)
{
    const int64_t near = (int64_t)BEGIN_SIZE;
    const int64_t from =
        file->reserved > file->written ? file->reserved : file->written;
    if (file->part == NULL || file->takes_none || file->written < near ||
        from - file->written > near) {
        return;
    }
    if (!can_reserve(file->fd)) {
        file->takes_none = true;
        return;
    }
    file->reserved = from; /* what fails may have got some of them */
    if (fallocate(file->fd, FALLOC_FL_KEEP_SIZE, (off_t)from,
                  (off_t)RESERVE_SIZE) == 0) {
        file->reserved += RESERVE_SIZE;
    } else {
        file->takes_none = true;
    }
}

/* Let the system start to write, without waiting, and reuse the memory of what
 * is old: a recording of a day would push all else out of it, and fresh memory
 * for each of its pages takes longer than the copy into it. Pages that are not
 * on the disk yet stay, and are asked for again next time. */
static void start_write(const lum_outfile *file)
{
    (void)sync_file_range(file->fd, 0, 0, SYNC_FILE_RANGE_WRITE);
    if (file->grows && file->written > KEPT_SIZE) {
        (void)posix_fadvise(file->fd, 0, (off_t)(file->written - KEPT_SIZE),
                            POSIX_FADV_DONTNEED);
    }
}

#else

static int open_pipe(int fd)
{
    (void)fd;
    return -1;
}

static void reserve(lum_outfile *file)
{
    file->takes_none = true;
}

static void start_write(const lum_outfile *file)
{
    (void)file;
}

#endif

/* --- Bytes --- */

int lum_outfile_wait(const lum_outfile *file, int patience_ms)
{
    struct pollfd ready = {.fd = file->fd, .events = POLLOUT, .revents = 0};
    const int answer = poll(&ready, 1, patience_ms);
    return answer < 0 && errno == EINTR ? 0 : answer;
}

void lum_outfile_never_wait(lum_outfile *file)
{
    const int again = file->may_block ? open_pipe(file->fd) : -1;
    if (again >= 0) {
        (void)close(file->fd);
        file->fd = again;
        file->never_waits = true;
    }
}

/* The meaning of a result of write(): 0 to continue, or an errno. */
static int judge_write(ssize_t written)
{
    if (written > 0) {
        return 0;
    }
    if (written == 0) {
        return EIO;
    }
    return errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK ? 0
                                                                     : errno;
}

/* A writable pipe takes PIPE_BUF bytes without blocking; more may block. */
int lum_outfile_put(lum_outfile *file, const void *bytes, size_t n,
                    size_t *written)
{
    const bool may_wait = file->may_block && !file->never_waits;
    const size_t most = may_wait && n > PIPE_BUF ? PIPE_BUF : n;
    const ssize_t result = write(file->fd, bytes, most);
    *written = result > 0 ? (size_t)result : 0;
    return judge_write(result);
}

int lum_outfile_put_at(lum_outfile *file, uint64_t offset, const void *bytes,
                       size_t n)
{
    const char *from = bytes;
    off_t at = (off_t)file->base + (off_t)offset;
    while (n > 0) {
        const ssize_t written = pwrite(file->fd, from, n, at);
        const int code = judge_write(written);
        if (code != 0) {
            return code;
        }
        if (written > 0) {
            from += written;
            at += written;
            n -= (size_t)written;
        }
    }
    return 0;
}

void lum_outfile_release(const lum_outfile *file)
{
    struct stat status;
    if (file->reserved > 0 && fstat(file->fd, &status) == 0) {
        (void)!ftruncate(file->fd, status.st_size);
    }
}

void lum_outfile_wrote(lum_outfile *file, size_t n)
{
    file->unstarted += n;
    file->written += (int64_t)n;
    reserve(file);
    if (file->path != NULL && file->unstarted >= BEGIN_SIZE) {
        file->unstarted = 0;
        start_write(file);
    }
}

bool lum_outfile_is_unread(const lum_outfile *file)
{
    struct pollfd look = {.fd = file->fd};
    return poll(&look, 1, 0) > 0 && (look.revents & POLLERR) != 0;
}

int lum_outfile_copy(const lum_outfile *file)
{
    return file->path != NULL
               ? fcntl(file->fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)
               : -1;
}

int lum_outfile_sync_copy(int copy)
{
    const int code = lum_system_sync(copy);
    (void)close(copy);
    return code;
}

FILE *lum_outfile_stream(const lum_outfile *file)
{
    const int fd = fcntl(file->fd, F_DUPFD_CLOEXEC, 0);
    FILE *stream = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (stream == NULL && fd >= 0) {
        const int code = errno;
        (void)close(fd);
        errno = code;
    }
    return stream;
}

void lum_outfile_turn_away(FILE *stream)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere >= 0) {
        (void)dup2(nowhere, fileno(stream));
        (void)close(nowhere);
    }
}
