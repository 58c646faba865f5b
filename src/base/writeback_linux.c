#define _GNU_SOURCE /* sync_file_range */
#include "writeback.h"

#include <fcntl.h>

void lum_writeback_begin(int fd)
{
    (void)sync_file_range(fd, 0, 0, SYNC_FILE_RANGE_WRITE);
}

/* Pages that are not on the disk yet stay, and are asked for again next time.
 */
void lum_writeback_forget(int fd, uint64_t bytes)
{
    (void)posix_fadvise(fd, 0, (off_t)bytes, POSIX_FADV_DONTNEED);
}
