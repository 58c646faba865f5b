/* Small facts of a POSIX system. */
#define _POSIX_C_SOURCE 200809L
#include "system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

const char *lum_system_base(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

long lum_system_process(void)
{
    return (long)getpid();
}

int lum_system_sync(int fd)
{
    int code = 0;
    do {
        code = fsync(fd) == 0 ? 0 : errno;
    } while (code == EINTR);
    return code == EINVAL || code == ENOSYS || code == ENOTSUP ? 0 : code;
}

/* NULL: no memory. */
static char *directory_of(const char *path)
{
    const size_t len = (size_t)(lum_system_base(path) - path);
    return len != 0 ? strndup(path, len) : strdup(".");
}

bool lum_system_free_bytes(const char *path, uint64_t *out)
{
    struct statvfs status;
    char *directory = directory_of(path);
    const bool is_known = directory != NULL && statvfs(directory, &status) == 0;
    *out = is_known ? (uint64_t)status.f_bavail * status.f_frsize : 0u;
    free(directory);
    return is_known;
}

int lum_system_sync_name(const char *path)
{
    char *directory = directory_of(path);
    if (directory == NULL) {
        return ENOMEM;
    }
    const int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const int code = fd >= 0 ? lum_system_sync(fd) : 0;
    if (fd >= 0) {
        (void)close(fd);
    }
    free(directory);
    return code;
}
