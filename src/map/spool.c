#define _GNU_SOURCE       /* O_TMPFILE */
#define _FILE_OFFSET_BITS 64

#include "spool.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

#if defined(_WIN32)

#include <io.h>
#include <process.h>
#include <stdio.h>

#define TRIES      100
#define ENDING     40u        /* bytes that a name gets behind it */
#define BYTES_ONCE (1u << 28) /* that a call takes */
#define CLOSE      _close

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

static int64_t put_some(int fd, uint64_t at, const void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _write(fd, bytes, at_once(n));
}

static int64_t get_some(int fd, uint64_t at, void *bytes, size_t n)
{
    return _lseeki64(fd, (int64_t)at, SEEK_SET) < 0
               ? -1
               : _read(fd, bytes, at_once(n));
}

#else

#include <unistd.h>

#define CLOSE close

/* Without a name from the start, where the file system can do that.
 * name: room for a folder; of its own are the first n bytes. */
static int open_nameless(char *name, size_t n)
{
#if defined(O_TMPFILE)
    while (n > 0 && name[n - 1u] != '/') {
        n--;
    }
    name[n] = '.'; /* the folder itself */
    name[n + 1u] = '\0';
    return open(name, O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
#else
    (void)name;
    (void)n;
    return -1;
#endif
}

int lum_map_spool_open(lum_map_spool *spool, const char *beside)
{
    static const char ending[] = ".spool.XXXXXX";
    const size_t n = strlen(beside);
    char *name = malloc(n + sizeof ending);
    if (name == NULL) {
        return ENOMEM;
    }
    memcpy(name, beside, n);
    spool->size = 0;
    spool->fd = open_nameless(name, n);
    int code = 0;
    if (spool->fd < 0) {
        memcpy(name, beside, n);
        memcpy(name + n, ending, sizeof ending);
        spool->fd = mkstemp(name);
        code = spool->fd < 0 || unlink(name) != 0 ? errno : 0;
    }
    free(name);
    return code;
}

static int64_t put_some(int fd, uint64_t at, const void *bytes, size_t n)
{
    return pwrite(fd, bytes, n, (off_t)at);
}

static int64_t get_some(int fd, uint64_t at, void *bytes, size_t n)
{
    return pread(fd, bytes, n, (off_t)at);
}

#endif

/* --- On every system --- */

int lum_map_spool_write(lum_map_spool *spool, const void *bytes, size_t n)
{
    const char *p = bytes;
    while (n > 0) {
        const int64_t done = put_some(spool->fd, spool->size, p, n);
        if (done == 0 || (done < 0 && errno != EINTR)) {
            return done == 0 ? ENOSPC : errno;
        }
        if (done > 0) {
            p += done;
            n -= (size_t)done;
            spool->size += (uint64_t)done;
        }
    }
    return 0;
}

int lum_map_spool_read(const lum_map_spool *spool, uint64_t from, void *bytes,
                       size_t n)
{
    char *p = bytes;
    while (n > 0) {
        const int64_t done = get_some(spool->fd, from, p, n);
        if (done == 0 || (done < 0 && errno != EINTR)) {
            return done == 0 ? EIO : errno;
        }
        if (done > 0) {
            p += done;
            n -= (size_t)done;
            from += (uint64_t)done;
        }
    }
    return 0;
}

void lum_map_spool_close(lum_map_spool *spool)
{
    const int code = errno;
    if (spool->fd >= 0) {
        (void)CLOSE(spool->fd);
    }
    spool->fd = -1;
    errno = code;
}
