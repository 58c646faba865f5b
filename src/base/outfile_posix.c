/* Outputs opened, named and ended, on POSIX: a path comes in; what goes out is
 * a descriptor to write to, and at the end the whole file under that path. */
#define _XOPEN_SOURCE    700 /* POSIX 2008 with realpath() */
#define _DARWIN_C_SOURCE     /* O_NOFOLLOW */

#include "outfile_parts.h"

#include "base/system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRIES 100 /* to find a name that is free */

/* --- The unfinished file --- */

void lum_outfile_part_keep_mode(const lum_outfile *file, const struct stat *old)
{
    struct stat now;
    mode_t mode = old->st_mode & (S_IRWXU | S_IRWXG | S_IRWXO);
    if (fchown(file->fd, old->st_uid, old->st_gid) != 0 &&
        (fchown(file->fd, (uid_t)-1, old->st_gid) != 0) &&
        fstat(file->fd, &now) == 0 && now.st_gid != old->st_gid) {
        mode &= ~(mode_t)S_IRWXG | (mode_t)((mode & S_IRWXO) << 3u);
    }
    (void)fchmod(file->fd, mode);
}

int lum_outfile_part_create(lum_outfile *file, mode_t mode)
{
    int code = EEXIST;
    for (int i = 0; i < TRIES && code == EEXIST; i++) {
        free(file->part);
        file->part = lum_claim_beside(file->path);
        if (file->part == NULL) {
            errno = ENOMEM;
            return -1;
        }
        file->fd =
            open(file->part,
                 O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        code = file->fd < 0 ? errno : 0;
    }
    if (code != 0) {
        free(file->part);
        file->part = NULL;
    }
    errno = code;
    return code == 0 ? 0 : -1;
}

static int refuse_busy(const lum_outfile *file, lum_error *error)
{
    return lum_outfile_refuse(EBUSY, file->name,
                              "another program is writing it, or has locked "
                              "it: wait for its end, or choose another name",
                              error);
}

int lum_outfile_part_settle(lum_outfile *file, lum_error *error)
{
    struct stat status;
    if (lum_claim_lock(file->fd) != 0) {
        return refuse_busy(file, error);
    }
    if (fstat(file->fd, &status) != 0) {
        return lum_outfile_fail(file, errno, "cannot look at it", error);
    }
    file->device = status.st_dev;
    file->inode = status.st_ino;
    return 0;
}

bool lum_outfile_part_is_at(const lum_outfile *file, const char *name)
{
    struct stat status;
    return lstat(name, &status) == 0 && status.st_dev == file->device &&
           status.st_ino == file->inode;
}

void lum_outfile_part_drop(lum_outfile *file)
{
    if (file->part != NULL && lum_outfile_part_is_at(file, file->part)) {
        (void)unlink(file->part);
    }
    if (file->fd >= 0) {
        (void)close(file->fd);
    }
    free(file->part);
}

/* --- The file that is filled --- */

static int fail_create(const lum_outfile *file, int code, lum_error *error)
{
    if (code == ENOENT) {
        return lum_outfile_refuse_directory(file, error);
    }
    if (code == EACCES || code == EROFS) {
        return lum_outfile_fail(
            file, code, "cannot begin a new file in its directory", error);
    }
    return lum_outfile_fail(file, code, "cannot create it", error);
}

static int adopt(lum_outfile *file, int fd, const char *doing, lum_error *error)
{
    file->fd = fd;
    return fd >= 0 ? 0 : lum_outfile_fail(file, errno, doing, error);
}

/* Opens an existing file that cannot be replaced. */
static int take(lum_outfile *file, lum_error *error)
{
    const int fd = open(file->path, O_WRONLY | O_CLOEXEC);
    file->is_older = true;
    return adopt(file, fd, "cannot open it", error) == 0
               ? lum_outfile_part_settle(file, error)
               : -1;
}

/* If a claim fails, but not because another process has it, the file would fail
 * in the same way. */
static int claim(lum_outfile *file, lum_error *error)
{
    lum_claim taken;
    int result = lum_claim_take(file->path, file->name, &taken, error);
    file->claim = taken;
    if (result != 0 && errno != EBUSY && errno != EEXIST) {
        result = fail_create(file, errno, error);
    }
    return result;
}

/* old: the file to be replaced; NULL: none. */
static int make(lum_outfile *file, lum_outfile_kind kind,
                const struct stat *old, lum_error *error)
{
    const mode_t everyone = 0666;
    if (file->path == NULL) {
        return lum_outfile_fail(file, errno, "cannot use the name", error);
    }
    if (claim(file, error) != 0) {
        return -1;
    }
    if (old != NULL && lum_claim_is_locked(file->path)) {
        return refuse_busy(file, error);
    }
    if (lum_outfile_part_create(file, old != NULL ? S_IRUSR | S_IWUSR
                                                  : everyone) != 0) {
        return old != NULL && kind == LUM_OUTFILE_GROWS &&
                       (errno == EACCES || errno == EROFS)
                   ? take(file, error)
                   : fail_create(file, errno, error);
    }
    file->grows = kind == LUM_OUTFILE_GROWS;
    lum_claim_note(&file->claim, file->part);
    if (old != NULL) {
        lum_outfile_part_keep_mode(file, old);
    }
    return lum_outfile_part_settle(file, error);
}

/* --- Opening --- */

/* Links are followed, so that the file is replaced and not the link. */
static int open_over(lum_outfile *file, lum_outfile_kind kind, const char *path,
                     const struct stat *old, lum_error *error)
{
    if (access(path, W_OK) != 0) {
        return lum_outfile_fail(file, errno, "cannot replace it", error);
    }
    file->path = realpath(path, NULL);
    return make(file, kind, old, error);
}

int lum_outfile_system_open(lum_outfile *file, lum_outfile_kind kind,
                            const char *path, lum_error *error)
{
    struct stat status;
    if (strcmp(path, "-") == 0) {
        return adopt(file,
                     fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1),
                     "cannot be used as output", error);
    }
    if (stat(path, &status) != 0) {
        if (lstat(path, &status) == 0) {
            return lum_outfile_fail(file, ENOENT,
                                    "is a link that leads nowhere", error);
        }
        file->path = strdup(path);
        return make(file, kind, NULL, error);
    }
    if (S_ISDIR(status.st_mode)) {
        return lum_outfile_refuse(EISDIR, path,
                                  "is a directory; name a file in it", error);
    }
    if (S_ISREG(status.st_mode)) {
        return open_over(file, kind, path, &status, error);
    }
    return adopt(file, open(path, O_WRONLY | O_CLOEXEC), "cannot open it",
                 error);
}

/* pwrite() on a file opened to append ignores the offset. */
void lum_outfile_system_learn(lum_outfile *file)
{
    struct stat status;
    const int flags = fcntl(file->fd, F_GETFL);
    const off_t here = lseek(file->fd, 0, SEEK_CUR);
    file->may_block = fstat(file->fd, &status) != 0 || !S_ISREG(status.st_mode);
    file->seekable =
        !file->may_block && here >= 0 && flags >= 0 && (flags & O_APPEND) == 0;
    file->base = file->seekable ? (int64_t)here : 0;
}

/* --- Its name, and the end --- */

/* Give it its name; the disk may get the name later. */
static int give_name(lum_outfile *file, lum_error *error)
{
    if (file->part == NULL || file->path == NULL) {
        return 0;
    }
    if (!lum_outfile_part_is_at(file, file->part)) {
        return lum_outfile_lost_fail(file, "was removed or is another file now",
                                     "", "", error);
    }
    if (lum_claim_is_locked(file->path)) {
        return refuse_busy(file, error);
    }
    if (rename(file->part, file->path) != 0) {
        return lum_outfile_fail(file, errno, "cannot get its name", error);
    }
    free(file->part);
    file->part = NULL;
    file->owes_name = true;
    return 0;
}

/* The file's own lock replaces the claim. */
int lum_outfile_show(lum_outfile *file, lum_error *error)
{
    if (file->is_older) {
        if (ftruncate(file->fd, 0) != 0) {
            return lum_outfile_fail(file, errno, "cannot empty it", error);
        }
        file->is_older = false;
    }
    const int result = give_name(file, error);
    if (file->owes_name) {
        lum_claim_drop(&file->claim);
    }
    return result;
}

int lum_outfile_finish(lum_outfile *file, lum_error *error)
{
    const int fd = file->fd;
    lum_outfile_release(file);
    const int code = file->path != NULL ? lum_system_sync(fd) : 0;
    if (code != 0) {
        return lum_outfile_fail(file, code, "cannot bring it to the disk",
                                error);
    }
    if (lum_outfile_lost_recover(file, error) != 0) {
        return -1;
    }
    file->fd = -1;
    if (close(fd) != 0 && errno != EINTR) {
        return lum_outfile_fail(file, errno, "cannot finish it", error);
    }
    if (give_name(file, error) != 0) {
        return -1;
    }
    const int late = file->owes_name ? lum_system_sync_name(file->path) : 0;
    return late == 0
               ? 0
               : lum_outfile_fail(file, late, "its name may not be on the disk",
                                  error);
}
