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

int64_t lum_map_spool_put(int fd, uint64_t at, const void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _write(fd, bytes, at_once(n));
}

int64_t lum_map_spool_get(int fd, uint64_t at, void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _read(fd, bytes, at_once(n));
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
