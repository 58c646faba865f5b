/* A file that several runs open, on POSIX: flock() keeps them apart. */
#define _POSIX_C_SOURCE 200809L
#include "rows_file.h"

#include "base/claim.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

int rows_file_open(const char *path, bool is_private)
{
    const int fd = open(path, O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC,
                        is_private ? 0600 : 0666);
    if (fd >= 0 && lum_claim_lock(fd) != 0) {
        (void)close(fd);
        errno = EBUSY;
        return -1;
    }
    return fd;
}

int rows_file_cut(int fd, long long size)
{
    return ftruncate(fd, (off_t)size);
}

int rows_file_put(int fd, const char *text, size_t len)
{
    while (len > 0) {
        const ssize_t n = write(fd, text, len);
        if (n < 0 && errno != EINTR) {
            return -1;
        }
        text += n > 0 ? n : 0;
        len -= n > 0 ? (size_t)n : 0;
    }
    return 0;
}

int rows_file_replace(const char *from, const char *to)
{
    return rename(from, to);
}
