#define _GNU_SOURCE /* sync_file_range */
#include "writeback.h"

#include <fcntl.h>

void lum_writeback_begin(int fd)
{
    (void)sync_file_range(fd, 0, 0, SYNC_FILE_RANGE_WRITE);
}
