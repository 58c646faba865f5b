#define _POSIX_C_SOURCE 200809L
#include "same_file.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool find_file(const char *path, int standard, struct stat *out)
{
    return (strcmp(path, "-") == 0 ? fstat(standard, out) : stat(path, out)) ==
               0 &&
           S_ISREG(out->st_mode);
}

bool same_file(const char *input, const char *output)
{
    struct stat i;
    struct stat o;
    return find_file(input, STDIN_FILENO, &i) &&
           find_file(output, STDOUT_FILENO, &o) && i.st_dev == o.st_dev &&
           i.st_ino == o.st_ino;
}
