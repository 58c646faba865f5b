#define _POSIX_C_SOURCE 200809L
#include "source_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct file {
    int fd;
};

/* Of a descriptor that somebody else made not to block. */
static bool wait_for_input(int fd)
{
    struct pollfd look = {.fd = fd, .events = POLLIN};
    return poll(&look, 1, -1) > 0;
}

/* A signal ends the waiting: the caller decides what it means. */
static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    const struct file *file = context;
    ssize_t got = 0;
    do {
        got = read(file->fd, buffer, room);
    } while (got < 0 && errno == EAGAIN && wait_for_input(file->fd));
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

static void close_file(void *context)
{
    struct file *file = context;
    (void)close(file->fd);
    free(file);
}

/* Standard input is read through a descriptor of its own, so that closing it
 * harms nobody. */
static int open_descriptor(const char *path)
{
    return strcmp(path, "-") == 0 ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                  : open(path, O_RDONLY | O_CLOEXEC);
}

static uint64_t regular_bytes(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 && S_ISREG(st.st_mode) ? (uint64_t)st.st_size
                                                      : 0;
}

static lum_source *from_descriptor(const char *name, int fd)
{
    struct file *file = malloc(sizeof *file);
    if (file == NULL) {
        return NULL;
    }
    file->fd = fd;
    const lum_source_functions functions = {read_some, close_file, file,
                                            regular_bytes(fd)};
    lum_source *source = lum_source_from_functions(name, &functions);
    if (source == NULL) {
        free(file);
    }
    return source;
}

int lum_source_open(const char *path, lum_source **out, lum_error *error)
{
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    const int fd = open_descriptor(path);
    if (fd < 0) {
        return lum_error_set(
            error,
            "%s: cannot be opened: %s; a pcap or pcapng file is expected", name,
            strerror(errno));
    }
    lum_source *source = from_descriptor(name, fd);
    if (source == NULL) {
        (void)close(fd);
        errno = ENOMEM;
        return lum_error_set(error, "%s: not enough memory to read it", name);
    }
    *out = source;
    return 0;
}
