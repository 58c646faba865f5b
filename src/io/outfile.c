#define _XOPEN_SOURCE 700 /* POSIX 2008 with realpath() */

#include "outfile.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int lum_outfile_fail(const lum_outfile *file, int code, const char *doing,
                     lum_error *error)
{
    char why[128];
    if (strerror_r(code, why, sizeof why) != 0) {
        (void)snprintf(why, sizeof why, "error %d", code);
    }
    lum_error_set(error, "%s: %s: %s%s", file->name, doing, why,
                  code == ENOSPC ? "; free some space or write elsewhere" : "");
    errno = code;
    return -1;
}

static char *join(const char *head, const char *tail)
{
    const size_t n = strlen(head);
    const size_t m = strlen(tail) + 1u;
    char *whole = malloc(n + m);
    if (whole != NULL) {
        memcpy(whole, head, n);
        memcpy(whole + n, tail, m);
    }
    return whole;
}

static int adopt(lum_outfile *file, int fd, const char *doing, lum_error *error)
{
    file->fd = fd;
    return fd >= 0 ? 0 : lum_outfile_fail(file, errno, doing, error);
}

static int fail_create(const lum_outfile *file, int code, lum_error *error)
{
    if (code == ENOENT) {
        lum_error_set(error,
                      "%s: cannot create it: the directory does not exist; "
                      "create it or write elsewhere",
                      file->name);
        errno = code;
        return -1;
    }
    return lum_outfile_fail(
        file, code, "cannot create it (with .part behind its name)", error);
}

/* Truncating a file that is there is slow, so the old one goes first. */
static int open_part(lum_outfile *file, lum_error *error)
{
    if (file->path == NULL) {
        return lum_outfile_fail(file, errno, "cannot use the name", error);
    }
    file->part = join(file->path, ".part");
    if (file->part == NULL) {
        return lum_outfile_fail(file, ENOMEM, "cannot open it", error);
    }
    if (unlink(file->part) != 0 && errno != ENOENT) {
        return fail_create(file, errno, error);
    }
    file->fd = open(file->part, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file->fd < 0) {
        const int code = errno;
        free(file->part);
        file->part = NULL;
        return fail_create(file, code, error);
    }
    return 0;
}

/* Links are followed, so that the file is replaced and not the link. */
static int open_over(lum_outfile *file, const char *path, lum_error *error)
{
    if (access(path, W_OK) != 0) {
        return lum_outfile_fail(file, errno, "cannot replace it", error);
    }
    file->path = realpath(path, NULL);
    return open_part(file, error);
}

static int open_new(lum_outfile *file, const char *path, lum_error *error)
{
    file->path = join(path, "");
    return open_part(file, error);
}

static int open_path(lum_outfile *file, const char *path, lum_error *error)
{
    struct stat status;
    if (strcmp(path, "-") == 0) {
        return adopt(file,
                     fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1),
                     "cannot be used as output", error);
    }
    if (stat(path, &status) != 0) {
        return lstat(path, &status) != 0
                   ? open_new(file, path, error)
                   : lum_outfile_fail(file, ENOENT,
                                      "is a link that leads nowhere", error);
    }
    if (S_ISDIR(status.st_mode)) {
        lum_error_set(error, "%s: is a directory; name a file in it", path);
        errno = EISDIR;
        return -1;
    }
    if (S_ISREG(status.st_mode)) {
        return open_over(file, path, error);
    }
    return adopt(file, open(path, O_WRONLY | O_CLOEXEC), "cannot open it",
                 error);
}

/* pwrite() on a file opened to append ignores the offset. */
static void learn_kind(lum_outfile *file)
{
    struct stat status;
    const int flags = fcntl(file->fd, F_GETFL);
    const off_t here = lseek(file->fd, 0, SEEK_CUR);
    file->may_block = fstat(file->fd, &status) != 0 || !S_ISREG(status.st_mode);
    file->seekable =
        !file->may_block && here >= 0 && flags >= 0 && (flags & O_APPEND) == 0;
    file->base = file->seekable ? (int64_t)here : 0;
}

int lum_outfile_open(const char *path, lum_outfile *out, lum_error *error)
{
    lum_outfile file = {NULL, NULL, NULL, -1, false, false, 0};
    file.name = join(strcmp(path, "-") == 0 ? "standard output" : path, "");
    if (file.name == NULL) {
        lum_error_set(error, "%s: no memory to open it", path);
        errno = ENOMEM;
        return -1;
    }
    if (open_path(&file, path, error) != 0) {
        const int code = errno;
        lum_outfile_discard(&file);
        errno = code;
        return -1;
    }
    learn_kind(&file);
    *out = file;
    return 0;
}

int lum_outfile_finish(lum_outfile *file, lum_error *error)
{
    const int fd = file->fd;
    file->fd = -1;
    if (close(fd) != 0 && errno != EINTR) {
        return lum_outfile_fail(file, errno, "cannot finish it", error);
    }
    if (file->part == NULL) {
        return 0;
    }
    if (rename(file->part, file->path) != 0) {
        return lum_outfile_fail(file, errno,
                                "cannot rename it (.part stands behind its "
                                "name while it grows)",
                                error);
    }
    free(file->part);
    file->part = NULL;
    return 0;
}

void lum_outfile_discard(lum_outfile *file)
{
    if (file->fd >= 0) {
        (void)close(file->fd);
    }
    if (file->part != NULL) {
        (void)unlink(file->part);
    }
    free(file->name);
    free(file->path);
    free(file->part);
}
