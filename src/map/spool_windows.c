#include "spool.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define TRIES      100
#define ENDING     40u        /* bytes that a name gets behind it */
#define BYTES_ONCE (1u << 28) /* that a call takes */

int lum_map_spool_open(lum_map_spool *spool, const char *beside)
{
    const size_t room = strlen(beside) + ENDING;
    char *name = malloc(room);
    int code = name == NULL ? ENOMEM : EEXIST;
    spool->size = 0;
    for (int i = 0; i < TRIES && code == EEXIST; i++) {
        (void)snprintf(name, room, "%s.spool.%d-%d", beside, _getpid(), i);
        spool->fd = _open(name,
                          _O_RDWR | _O_CREAT | _O_EXCL | _O_BINARY |
                              _O_TEMPORARY | _O_NOINHERIT,
                          _S_IREAD | _S_IWRITE);
        code = spool->fd < 0 ? errno : 0;
    }
    free(name);
    return code;
}

static unsigned at_once(size_t n)
{
    return n < BYTES_ONCE ? (unsigned)n : BYTES_ONCE;
}

int lum_map_spool_write(lum_map_spool *spool, const void *bytes, size_t n)
{
    const char *p = bytes;
    if (_lseeki64(spool->fd, (int64_t)spool->size, SEEK_SET) < 0) {
        return errno;
    }
    while (n > 0) {
        const int written = _write(spool->fd, p, at_once(n));
        if (written <= 0) {
            return written == 0 ? ENOSPC : errno;
        }
        p += written;
        n -= (size_t)written;
        spool->size += (uint64_t)written;
    }
    return 0;
}

int lum_map_spool_read(const lum_map_spool *spool, uint64_t from, void *bytes,
                       size_t n)
{
    char *p = bytes;
    if (_lseeki64(spool->fd, (int64_t)from, SEEK_SET) < 0) {
        return errno;
    }
    while (n > 0) {
        const int got = _read(spool->fd, p, at_once(n));
        if (got <= 0) {
            return got == 0 ? EIO : errno;
        }
        p += got;
        n -= (size_t)got;
    }
    return 0;
}

void lum_map_spool_close(lum_map_spool *spool)
{
    const int code = errno;
    if (spool->fd >= 0) {
        (void)_close(spool->fd);
    }
    spool->fd = -1;
    errno = code;
}
