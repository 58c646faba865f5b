#define _DEFAULT_SOURCE /* flock() */
#include "store.h"

#include "rows_file.h"

#include "lum/base/time.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define LOOK_NS INT64_C(10000000)

/* Room for the suffix of a name while its file is written. */
#define TEMPORARY_BYTES (STORE_PATH_BYTES + 32)

int store_folder(char out[STORE_PATH_BYTES], lum_error *error)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *home = getenv("HOME");
    int n = 0;
    if (state != NULL && *state == '/') {
        n = snprintf(out, STORE_PATH_BYTES, "%s/lumsdk/sensors", state);
    } else if (home != NULL && *home == '/') {
        n = snprintf(out, STORE_PATH_BYTES, "%s/.local/state/lumsdk/sensors",
                     home);
    }
    if (n <= 0 || n >= STORE_PATH_BYTES) {
        return lum_error_set(error, "neither XDG_STATE_HOME nor HOME names a "
                                    "folder where it could be kept");
    }
    return 0;
}

static int fail(const char *path, const char *doing, lum_error *error)
{
    return lum_error_set(error, "%s: %s: %s", path, doing, strerror(errno));
}

/* Makes a folder and all above it. */
static int make_folder(const char *folder, lum_error *error)
{
    char path[STORE_PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s", folder);
    for (char *at = path + 1;; at++) {
        const char was = *at;
        if (was != '/' && was != '\0') {
            continue;
        }
        *at = '\0';
        if (mkdir(path, 0700) != 0 && errno != EEXIST && errno != EROFS &&
            errno != EACCES) {
            return fail(path, "cannot be made", error);
        }
        if (was == '\0') {
            return 0;
        }
        *at = was;
    }
}

/* The lock of a program that was stopped is not waited for without end; where a
 * file system has no locks, it goes without. */
static int take_lock(int fd, int64_t wait_ns, const char *path,
                     lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ns;
    while (flock(fd, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK && errno != EINTR) {
            return 0;
        }
        if (lum_time_monotonic_ns() >= end) {
            return lum_error_set(error, "%s: another lumctl holds it", path);
        }
        lum_time_sleep_until(lum_time_monotonic_ns() + LOOK_NS);
    }
    return 0;
}

int store_lock(const char *folder, int64_t wait_ns, struct store_lock *out,
               lum_error *error)
{
    char path[TEMPORARY_BYTES];
    if (make_folder(folder, error) != 0) {
        return -1;
    }
    (void)snprintf(path, sizeof path, "%s/.lock", folder);
    const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0) {
        return fail(path, "cannot be opened", error);
    }
    if (take_lock(fd, wait_ns, path, error) != 0) {
        (void)close(fd);
        return -1;
    }
    out->handle = fd;
    return 0;
}

void store_unlock(const struct store_lock *lock)
{
    (void)close((int)lock->handle);
}

/* Not forced to the disk: one that is slow must not hold up the heartbeats of a
 * shell, and a file that a power failure has spoilt is passed over. */
int store_write(const char *path, const char *text, size_t len,
                lum_error *error)
{
    char part[TEMPORARY_BYTES];
    (void)snprintf(part, sizeof part, "%s.XXXXXX", path);
    const int fd = mkstemp(part);
    if (fd < 0) {
        return fail(path, "cannot be written", error);
    }
    const int written = rows_file_put(fd, text, len);
    const int code = errno;
    if (close(fd) == 0 && written == 0 && rename(part, path) == 0) {
        return 0;
    }
    errno = written != 0 ? code : errno;
    (void)fail(path, "cannot be written", error);
    (void)unlink(part);
    return -1;
}

void store_remove(const char *path)
{
    (void)unlink(path);
}
