#include "source_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

struct file {
    int fd;
};

static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    const struct file *file = context;
    const unsigned limit = room < INT_MAX ? (unsigned)room : INT_MAX;
    const int got = _read(file->fd, buffer, limit);
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

static void close_file(void *context)
{
    struct file *file = context;
    (void)_close(file->fd);
    free(file);
}

/* Standard input is read through a descriptor of its own, so that closing it
 * harms nobody. */
static int open_descriptor(const char *path)
{
    if (strcmp(path, "-") != 0) {
        return _open(path, _O_RDONLY | _O_BINARY | _O_NOINHERIT);
    }
    const int fd = _dup(0);
    if (fd >= 0) {
        (void)_setmode(fd, _O_BINARY);
    }
    return fd;
}

static uint64_t regular_bytes(int fd)
{
    struct _stati64 st;
    return _fstati64(fd, &st) == 0 && (st.st_mode & _S_IFMT) == _S_IFREG
               ? (uint64_t)st.st_size
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
        (void)_close(fd);
        errno = ENOMEM;
        return lum_error_set(error, "%s: not enough memory to read it", name);
    }
    *out = source;
    return 0;
}
