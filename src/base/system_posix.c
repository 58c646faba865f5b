#define _POSIX_C_SOURCE 200809L
#include "system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
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

int lum_system_sync_name(const char *path)
{
    const size_t len = (size_t)(lum_system_base(path) - path);
    char *directory = len != 0 ? strndup(path, len) : strdup(".");
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
