/* An output file that is removed or renamed while it is written: notices it,
 * and at the end gives its bytes a name again. */
#define _XOPEN_SOURCE 700

#include "outfile_io.h"
#include "outfile_parts.h"

#include "base/system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PATH_BYTES 4096u

#define RECOVERED ".recovered"
#define COPY_SIZE ((size_t)1 << 16) /* bytes of memory that a copy takes */

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
    return n <= 0 ? -1 : lum_outfile_part_is_at(file, out);
}

int lum_outfile_lost_fail(const lum_outfile *file, const char *what,
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
    return lum_outfile_lost_fail(file, "was removed while it was written", "",
                                 rest, error);
}

int lum_outfile_check(const lum_outfile *file, lum_error *error)
{
    char name[PATH_BYTES];
    char remedy[160];
    if (file->path == NULL ||
        lum_outfile_part_is_at(file, present_name(file))) {
        return 0;
    }
    switch (find_name(file, name, sizeof name)) {
    case 1:
        return lum_outfile_lost_fail(
            file, "was renamed while it was written; its data is in ", name, "",
            error);
    case 0:
        (void)snprintf(remedy, sizeof remedy,
                       "; its data is put back when the file ends, if its "
                       "folder has room; to save it now: "
                       "cp /proc/%ld/fd/%d NAME",
                       (long)getpid(), file->fd);
        return fail_removed(file, remedy, error);
    default:
        return lum_outfile_lost_fail(
            file, "was removed or renamed while it was written", "", "", error);
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
        lum_outfile_part_create(copy, S_IRUSR | S_IWUSR) != 0 ||
        lum_outfile_part_settle(copy, NULL) != 0) {
        return errno;
    }
    lum_claim_note(mark, copy->part);
    lum_outfile_part_keep_mode(copy, &status);
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
        if (name == NULL && copy.part != NULL &&
            lum_outfile_part_is_at(&copy, copy.part)) {
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
    return lum_outfile_lost_fail(
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
        (void)fail_removed(
            file, "; its data has another name, which is not known", error);
    } else {
        (void)fail_gone(file, code, error);
    }
    free(name);
    errno = ENOENT;
    return -1;
}

int lum_outfile_lost_recover(const lum_outfile *file, lum_error *error)
{
    char name[PATH_BYTES];
    if (lum_outfile_check(file, error) == 0) {
        return 0;
    }
    return find_name(file, name, sizeof name) == 0 ? put_back(file, error) : -1;
}
