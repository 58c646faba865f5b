#include "source_file.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

int lum_source_file_open(const char *path)
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

int64_t lum_source_file_read(int fd, void *buffer, size_t room,
                             lum_error *error)
{
    const unsigned limit = room < INT_MAX ? (unsigned)room : INT_MAX;
    const int got = _read(fd, buffer, limit);
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

uint64_t lum_source_file_bytes(int fd)
{
    struct _stati64 st;
    return _fstati64(fd, &st) == 0 && (st.st_mode & _S_IFMT) == _S_IFREG
               ? (uint64_t)st.st_size
               : 0;
}

void lum_source_file_close(int fd)
{
    (void)_close(fd);
}
