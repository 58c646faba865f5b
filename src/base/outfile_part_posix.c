/* The unfinished file beside an output: creates it under a free numbered
 * name, locks it, recognises it later, and removes it. */
#define _POSIX_C_SOURCE  200809L
#define _DARWIN_C_SOURCE /* O_NOFOLLOW */

#include "outfile_parts.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#define TRIES 100 /* to find a name that is free */

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

int lum_outfile_part_refuse_busy(const lum_outfile *file, lum_error *error)
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
        return lum_outfile_part_refuse_busy(file, error);
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
