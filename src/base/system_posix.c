#define _POSIX_C_SOURCE 200809L
#include "system.h"

#include <errno.h>
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
