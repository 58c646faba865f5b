#include "writeback.h"

void lum_writeback_begin(int fd)
{
    (void)fd;
}

void lum_writeback_forget(int fd, int64_t bytes)
{
    (void)fd;
    (void)bytes;
}

bool lum_writeback_can_reserve(int fd, int64_t n)
{
    (void)fd;
    (void)n;
    return false;
}

bool lum_writeback_reserve(int fd, int64_t from, int64_t n)
{
    (void)fd;
    (void)from;
    (void)n;
    return false;
}

int lum_writeback_open_pipe(int fd)
{
    (void)fd;
    return -1;
}
