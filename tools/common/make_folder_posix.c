/* A new folder, by mkdir() of POSIX. */
#define _POSIX_C_SOURCE 200809L
#include "make_folder.h"

#include <sys/stat.h>
#include <unistd.h>

int make_folder(const char *path)
{
    return mkdir(path, 0777);
}

int make_private_folder(const char *path)
{
    return mkdir(path, 0700);
}

void remove_folder(const char *path)
{
    (void)rmdir(path);
}
