#define _POSIX_C_SOURCE 200809L
#include "system.h"

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
