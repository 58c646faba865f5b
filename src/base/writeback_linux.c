#define _GNU_SOURCE /* sync_file_range, fallocate, F_SETPIPE_SZ */
#include "writeback.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

/* Four times the usual: its reader is woken less often. */
#define PIPE_ROOM (256 << 10)

void lum_writeback_begin(int fd)
{
    (void)sync_file_range(fd, 0, 0, SYNC_FILE_RANGE_WRITE);
}

/* Pages that are not on the disk yet stay, and are asked for again next time.
 */
void lum_writeback_forget(int fd, int64_t bytes)
{
    (void)posix_fadvise(fd, 0, (off_t)bytes, POSIX_FADV_DONTNEED);
}

/* Others would gain nothing: tmpfs fills the memory with zeros, btrfs would not
 * compress any more. */
bool lum_writeback_can_reserve(int fd, int64_t n)
{
    struct statfs status;
    return fstatfs(fd, &status) == 0 && status.f_type == EXT4_SUPER_MAGIC &&
           status.f_bsize > 0 &&
           status.f_bavail / 16u >= (uint64_t)n / (uint64_t)status.f_bsize;
}

bool lum_writeback_reserve(int fd, int64_t from, int64_t n)
{
    return fallocate(fd, FALLOC_FL_KEEP_SIZE, (off_t)from, (off_t)n) == 0;
}

/* O_NONBLOCK belongs to an opening. Descriptors of standard streams stay free,
 * where they are closed. */
int lum_writeback_open_pipe(int fd)
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
