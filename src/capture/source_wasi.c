/* Files of a browser's page, which have a length and never make anybody wait;
 * there is no standard input. */
#define _POSIX_C_SOURCE 200809L
#include "source_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail(lum_error *error)
{
    return lum_error_set(error, "%s", strerror(errno));
}

int lum_source_file_open(const char *path)
{
    return open(path, O_RDONLY);
}

int64_t lum_source_file_read(int fd, void *buffer, size_t room,
                             lum_error *error)
{
    const ssize_t got = read(fd, buffer, room);
    return got >= 0 ? got : fail(error);
}

int64_t lum_source_file_read_at(int fd, uint64_t offset, void *buffer,
                                size_t room, lum_error *error)
{
    const ssize_t got = pread(fd, buffer, room, (off_t)offset);
    return got >= 0 ? got : fail(error);
}

bool lum_source_file_wait(int fd, int ms)
{
    (void)fd;
    (void)ms;
    return true;
}

uint64_t lum_source_file_bytes(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 ? (uint64_t)st.st_size : 0;
}

/* Files that have bytes are read at their own place. */
int lum_source_file_seek(int fd, uint64_t offset, lum_error *error)
{
    (void)fd;
    (void)offset;
    errno = ESPIPE;
    return fail(error);
}

void lum_source_file_close(int fd)
{
    (void)close(fd);
}
