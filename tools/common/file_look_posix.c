/* What kind of file a name is, by stat(). */
#define _POSIX_C_SOURCE 200809L
#include "file_look.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum file_kind kind_of(mode_t mode)
{
    if (S_ISREG(mode)) {
        return FILE_REGULAR;
    }
    if (S_ISDIR(mode)) {
        return FILE_DIRECTORY;
    }
    return S_ISFIFO(mode) ? FILE_PIPE : FILE_DEVICE;
}

static struct file_look look_of(const struct stat *s)
{
    return (struct file_look){.kind = kind_of(s->st_mode),
                              .volume = (uint64_t)s->st_dev,
                              .number = (uint64_t)s->st_ino,
                              .bytes = (uint64_t)s->st_size,
                              .modified_s = (int64_t)s->st_mtime};
}

static bool look(const char *name, int standard, struct file_look *out)
{
    struct stat s;
    if ((strcmp(name, "-") == 0 ? fstat(standard, &s) : stat(name, &s)) != 0) {
        return false;
    }
    *out = look_of(&s);
    return true;
}

bool file_look_itself(const char *name, struct file_look *out)
{
    struct stat s;
    if (lstat(name, &s) != 0) {
        return false;
    }
    *out = look_of(&s);
    return true;
}

bool file_look(const char *name, struct file_look *out)
{
    return look(name, STDOUT_FILENO, out);
}

bool file_look_input(const char *name, struct file_look *out)
{
    return look(name, STDIN_FILENO, out);
}

bool file_look_is_same(const struct file_look *a, const struct file_look *b)
{
    return a->volume == b->volume && a->number == b->number;
}

/* A file that may not be opened is reported at once. */
bool file_look_opens_late(const char *name)
{
    struct file_look l;
    return strcmp(name, "-") != 0 && file_look(name, &l) &&
           l.kind == FILE_PIPE && access(name, W_OK) == 0;
}

bool file_look_is_dangling(const char *name)
{
    struct stat s;
    return strcmp(name, "-") != 0 && stat(name, &s) != 0 &&
           lstat(name, &s) == 0;
}
