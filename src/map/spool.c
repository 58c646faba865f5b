#include "spool.h"

#include <errno.h>

int lum_map_spool_write(lum_map_spool *spool, const void *bytes, size_t n)
{
    const char *p = bytes;
    while (n > 0) {
        const int64_t done = lum_map_spool_put(spool->fd, spool->size, p, n);
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
        const int64_t done = lum_map_spool_get(spool->fd, from, p, n);
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
