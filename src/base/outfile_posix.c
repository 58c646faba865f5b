/* Outputs opened, named and ended, on POSIX: a path comes in; what goes out is
 * a descriptor to write to, and at the end the whole file under that path. One
 * that is removed or renamed meanwhile is noticed, and its bytes get a name
 * again. */
#define _XOPEN_SOURCE    700 /* POSIX 2008 with realpath() */
#define _DARWIN_C_SOURCE     /* O_NOFOLLOW */

#include "outfile_io.h"
#include "outfile_parts.h"

#include "base/system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_BYTES 4096u

#define RECOVERED ".recovered"
#define COPY_SIZE ((size_t)1 << 16) /* bytes of memory that a copy takes */

#define TRIES 100 /* to find a name that is free */

/* --- The unfinished file --- */

/* Let only those read it who could read the file that it replaces. */
static void keep_mode(const lum_outfile *file, const struct stat *old)
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

/* Open it under a free number, or set part to NULL. No message. */
static int create_part(lum_outfile *file, mode_t mode)
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

/* Lock the file that is open, and note what it is known by. */
static int settle(lum_outfile *file, lum_error *error)
{
    struct stat status;
    if (lum_claim_lock(file->fd) != 0) {
        return refuse_busy(file, error);
    }
    if (fstat(file->fd, &status) != 0) {
        return lum_outfile_fail(file, errno, "cannot get its status", error);
    }
    file->device = status.st_dev;
    file->inode = status.st_ino;
    return 0;
}

/* Whether a name is that of the file that is open. */
static bool is_at(const lum_outfile *file, const char *name)
{
    struct stat status;
    return lstat(name, &status) == 0 && status.st_dev == file->device &&
           status.st_ino == file->inode;
}

void lum_outfile_part_drop(lum_outfile *file)
{
    if (file->part != NULL && is_at(file, file->part)) {
        (void)unlink(file->part);
    }
    if (file->fd >= 0) {
        (void)close(file->fd);
    }
    free(file->part);
}

/* --- What became of it --- */

static const char *present_name(const lum_outfile *file)
{
    return file->part != NULL ? file->part : file->path;
}

/* As Linux has it. */
static const char *name_descriptor(const lum_outfile *file, char out[64])
{
    (void)snprintf(out, 64, "/proc/self/fd/%d", file->fd);
    return out;
}

/* How its name is known now. 1: so; 0: it has none; -1: nobody says. */
static int find_name(const lum_outfile *file, char *out, size_t room)
{
    char self[64];
    const ssize_t n = readlink(name_descriptor(file, self), out, room - 1u);
    out[n > 0 ? n : 0] = '\0';
    return n <= 0 ? -1 : is_at(file, out);
}

/* The message what became of it, where (a name, or ""), rest: ENOENT; -1. */
static int fail_lost(const lum_outfile *file, const char *what,
                     const char *where, const char *rest, lum_error *error)
{
    errno = ENOENT;
    return lum_error_set(error, "%s: %s%s%s%s%s", file->name,
                         file->part != NULL ? file->part : "",
                         file->part != NULL ? ", where it is written, " : "",
                         what, where, rest);
}

static int fail_removed(const lum_outfile *file, const char *rest,
                        lum_error *error)
{
    return fail_lost(file, "was removed while it was written", "", rest, error);
}

int lum_outfile_check(const lum_outfile *file, lum_error *error)
{
    char name[PATH_BYTES];
    char fix[160];
    if (file->path == NULL || is_at(file, present_name(file))) {
        return 0;
    }
    switch (find_name(file, name, sizeof name)) {
    case 1:
        return fail_lost(file,
                         "was renamed while it was written; its data is in ",
                         name, "", error);
    case 0:
        (void)snprintf(
            fix, sizeof fix,
            "; its data is put back when the file ends, if its folder has "
            "room; to save it now: cp /proc/%ld/fd/%d NAME",
            (long)getpid(), file->fd);
        return fail_removed(file, fix, error);
    default:
        return fail_lost(file, "was removed or renamed while it was written",
                         "", "", error);
    }
}

/* --- A removed file is put back --- */

/* All bytes of a file to another one. 0 or an errno. */
static int copy_bytes(int from, lum_outfile *to)
{
    char *bytes = malloc(COPY_SIZE);
    int code = bytes != NULL ? 0 : ENOMEM;
    ssize_t n = 1;
    while (code == 0 && n != 0) {
        n = read(from, bytes, COPY_SIZE);
        code = n >= 0 || errno == EINTR ? 0 : errno;
        if (n > 0 && lum_outfile_put_all(to, bytes, (size_t)n, NULL) != 0) {
            code = errno;
        }
    }
    free(bytes);
    return code;
}

/* A new file beside it, on the disk. 0 or an errno. */
static int fill_copy(lum_outfile *copy, int from, const lum_claim *mark)
{
    struct stat status;
    if (fstat(from, &status) != 0 ||
        create_part(copy, S_IRUSR | S_IWUSR) != 0 || settle(copy, NULL) != 0) {
        return errno;
    }
    lum_claim_note(mark, copy->part);
    keep_mode(copy, &status);
    const int code = copy_bytes(from, copy);
    lum_outfile_release(copy);
    return code != 0 ? code : lum_system_sync(copy->fd);
}

/* Unless another writes the file of this name. */
static bool may_take_name(const lum_outfile *file, lum_claim *out)
{
    return lum_claim_take(file->path, file->name, out, NULL) == 0 ||
           errno != EBUSY;
}

/* Linux opens an open file once more, without a name of it. A copy that is
 * killed is removed by the next run, as any unfinished file. 0 or an errno. */
static int make_copy(const lum_outfile *file, const lum_claim *claim,
                     lum_outfile *copy)
{
    char self[64];
    const int from = open(name_descriptor(file, self), O_RDONLY | O_CLOEXEC);
    if (from < 0) {
        return errno;
    }
    const int code = fill_copy(copy, from, claim);
    (void)close(from);
    return code;
}

/* A link under its name, or beside it. Replaces nothing, also not what another
 * writes and gives this name later.
 * @return the link's name, to be freed; NULL with the reason in errno. */
static char *make_link(const lum_outfile *file, bool is_name_free,
                       const char *from)
{
    static const char *const endings[] = {"", RECOVERED};
    const size_t room = strlen(file->path) + sizeof RECOVERED;
    char *name = malloc(room);
    for (size_t i = is_name_free ? 0 : 1u; name != NULL && i < 2u; i++) {
        (void)snprintf(name, room, "%s%s", file->path, endings[i]);
        if (linkat(AT_FDCWD, from, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0) {
            return name;
        }
    }
    free(name);
    return NULL;
}

/* Others may remove the copy, too.
 * @return the copy's name, to be freed; NULL with the reason in errno. */
static char *copy_back(const lum_outfile *file, const lum_claim *claim,
                       bool is_name_free)
{
    char self[64];
    lum_outfile copy = {
        .path = file->path, .fd = -1, .grows = true, .claim = LUM_CLAIM_NONE};
    char *name = NULL;
    int code = make_copy(file, claim, &copy);
    if (code == 0) {
        name = make_link(file, is_name_free, name_descriptor(&copy, self));
        code = errno;
        if (name == NULL && copy.part != NULL && is_at(&copy, copy.part)) {
            name = copy.part; /* where there are no links */
            copy.part = NULL;
        }
    }
    lum_outfile_part_drop(&copy);
    errno = code;
    return name;
}

/* What it says of a file that lost all its names, and has one again. */
static int fail_put_back(const lum_outfile *file, const char *name,
                         lum_error *error)
{
    const bool is_safe = lum_system_sync_name(file->path) == 0;
    return fail_lost(
        file, "was removed while it was written; its data was put back as ",
        name, is_safe ? "" : ", a name that may not be on the disk", error);
}

static int fail_gone(const lum_outfile *file, int code, lum_error *error)
{
    char rest[192];
    (void)snprintf(rest, sizeof rest,
                   "; its data is lost, as it could not be put back: %s",
                   strerror(code));
    return fail_removed(file, rest, error);
}

/* A file with another link needs no copy. */
static int put_back(const lum_outfile *file, lum_error *error)
{
    char self[64];
    struct stat status;
    const bool has_link = fstat(file->fd, &status) == 0 && status.st_nlink > 0;
    lum_claim own = LUM_CLAIM_NONE;
    const bool has_claim = file->claim.fd >= 0;
    const bool is_free = has_claim || may_take_name(file, &own);
    char *name =
        has_link ? make_link(file, is_free, name_descriptor(file, self))
                 : copy_back(file, has_claim ? &file->claim : &own, is_free);
    const int code = errno;
    lum_claim_drop(&own);
    if (name != NULL) {
        (void)fail_put_back(file, name, error);
    } else if (has_link) {
        (void)fail_removed(file, "; its data now has an unknown name", error);
    } else {
        (void)fail_gone(file, code, error);
    }
    free(name);
    errno = ENOENT;
    return -1;
}

/* At the end: lum_outfile_check(), and a removed file is put back. */
static int recover(const lum_outfile *file, lum_error *error)
{
    char name[PATH_BYTES];
    if (lum_outfile_check(file, error) == 0) {
        return 0;
    }
    return find_name(file, name, sizeof name) == 0 ? put_back(file, error) : -1;
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
    return adopt(file, fd, "cannot open it", error) == 0 ? settle(file, error)
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
    if (create_part(file, old != NULL ? S_IRUSR | S_IWUSR : everyone) != 0) {
        return old != NULL && kind == LUM_OUTFILE_GROWS &&
                       (errno == EACCES || errno == EROFS)
                   ? take(file, error)
                   : fail_create(file, errno, error);
    }
    file->grows = kind == LUM_OUTFILE_GROWS;
    lum_claim_note(&file->claim, file->part);
    if (old != NULL) {
        keep_mode(file, old);
    }
    return settle(file, error);
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
            return lum_outfile_fail(file, ENOENT, "is a link to a missing file",
                                    error);
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
    if (!is_at(file, file->part)) {
        return fail_lost(file, "was removed or is another file now", "", "",
                         error);
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
        return lum_outfile_fail(file, code, "cannot write it to the disk",
                                error);
    }
    if (recover(file, error) != 0) {
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
