#define _GNU_SOURCE /* sync_file_range, fallocate */
#include "writeback.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/vfs.h>

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
