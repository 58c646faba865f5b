#define _GNU_SOURCE       /* O_TMPFILE */
#define _FILE_OFFSET_BITS 64

#include "spool.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

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

int64_t lum_map_spool_put(int fd, uint64_t at, const void *bytes, size_t n)
{
    return pwrite(fd, bytes, n, (off_t)at);
}

int64_t lum_map_spool_get(int fd, uint64_t at, void *bytes, size_t n)
{
    return pread(fd, bytes, n, (off_t)at);
}

void lum_map_spool_close(lum_map_spool *spool)
{
    const int code = errno;
    if (spool->fd >= 0) {
        (void)close(spool->fd);
    }
    spool->fd = -1;
    errno = code;
}
