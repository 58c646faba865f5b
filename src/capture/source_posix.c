/* Files as a source reads them, on POSIX systems. */
#define _POSIX_C_SOURCE 200809L
#include "source_file.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A pipe without a writer makes nobody wait who opens it, but who reads it.
 * Elsewhere than on Linux it would look like a pipe at its end. */
#ifdef __linux__
#define NO_WAIT O_NONBLOCK
#else
#define NO_WAIT 0
#endif

/* Also on a descriptor that somebody else made not to block. */
static bool wait_for_input(int fd)
{
    struct pollfd look = {.fd = fd, .events = POLLIN};
    return poll(&look, 1, -1) > 0;
}

int lum_source_file_open(const char *path)
{
    return strcmp(path, "-") == 0 ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                  : open(path, O_RDONLY | O_CLOEXEC | NO_WAIT);
}

int64_t lum_source_file_read(int fd, void *buffer, size_t room,
                             lum_error *error)
{
    ssize_t got = -1;
    do {
        got = wait_for_input(fd) ? read(fd, buffer, room) : -1;
    } while (got < 0 && errno == EAGAIN);
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

int64_t lum_source_file_read_at(int fd, uint64_t offset, void *buffer,
                                size_t room, lum_error *error)
{
    const ssize_t got = pread(fd, buffer, room, (off_t)offset);
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

bool lum_source_file_wait(int fd, int ms)
{
    struct pollfd look = {.fd = fd, .events = POLLIN};
    const int ready = poll(&look, 1, ms);
    return ready > 0 || (ready < 0 && errno != EINTR);
}

uint64_t lum_source_file_bytes(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 && S_ISREG(st.st_mode) ? (uint64_t)st.st_size
                                                      : 0;
}

int lum_source_file_seek(int fd, uint64_t offset, lum_error *error)
{
    const off_t to = (off_t)offset;
    if (to < 0 || (uint64_t)to != offset) {
        return lum_error_set(error, "%s", strerror(EOVERFLOW));
    }
    return lseek(fd, to, SEEK_SET) >= 0
               ? 0
               : lum_error_set(error, "%s", strerror(errno));
}

void lum_source_file_close(int fd)
{
    (void)close(fd);
}
