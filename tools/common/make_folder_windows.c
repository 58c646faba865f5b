/* A new folder, on Windows. */
#include "make_folder.h"

#include <direct.h>

int make_folder(const char *path)
{
    return _mkdir(path);
}

int make_private_folder(const char *path)
{
    return _mkdir(path);
}

void remove_folder(const char *path)
{
    (void)_rmdir(path);
}
