/* Writes bytes to an output on POSIX: reserves disk space ahead, and starts
 * their way to the disk early. */
#define _POSIX_C_SOURCE 200809L

#include "outfile_io.h"
#include "outfile_parts.h"

#include "system.h"
#include "writeback.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <unistd.h>

#define BEGIN_SIZE   ((size_t)8 << 20)   /* bytes worth starting a write */
#define KEPT_SIZE    ((int64_t)64 << 20) /* for readers of a growing file */
#define RESERVE_SIZE ((int64_t)64 << 20) /* places on the disk at a time */

int lum_outfile_wait(const lum_outfile *file, int patience_ms)
{
    struct pollfd ready = {.fd = file->fd, .events = POLLOUT, .revents = 0};
    const int answer = poll(&ready, 1, patience_ms);
    return answer < 0 && errno == EINTR ? 0 : answer;
}

void lum_outfile_never_wait(lum_outfile *file)
{
    const int again = file->may_block ? lum_writeback_open_pipe(file->fd) : -1;
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

/* A recording of a day would push all else out of the memory, and fresh memory
 * for each of its pages takes longer than the copy into it. */
static void forget_old(const lum_outfile *file)
{
    if (file->grows && file->written > KEPT_SIZE) {
        lum_writeback_forget(file->fd, file->written - KEPT_SIZE);
    }
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
    if (!lum_writeback_can_reserve(file->fd, RESERVE_SIZE)) {
        file->takes_none = true;
        return;
    }
    file->reserved = from; /* what fails may have got some of them */
    if (lum_writeback_reserve(file->fd, from, RESERVE_SIZE)) {
        file->reserved += RESERVE_SIZE;
    } else {
        file->takes_none = true;
    }
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
        lum_writeback_begin(file->fd);
        forget_old(file);
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
