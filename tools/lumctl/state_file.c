#define _POSIX_C_SOURCE 200809L
#include "state_file.h"

#include "../common/make_folder.h"
#include "rows_file.h"

#include "lum/base/time.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LOOK_NS INT64_C(10000000)

/* Room for a name in the folder, or a suffix. */
#define LONG_PATH_BYTES (STATE_PATH_BYTES + 8)

static int fail(const char *path, const char *doing, lum_error *error)
{
    return lum_error_set(error, "%s: %s: %s", path, doing, strerror(errno));
}

/* Else a relative one would be another folder for each present folder. */
static bool is_absolute(const char *path)
{
    return path != NULL &&
           (*path == '/' || *path == '\\' || (*path != '\0' && path[1] == ':'));
}

int state_folder(char out[STATE_PATH_BYTES], lum_error *error)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *local = getenv("LOCALAPPDATA");
    const char *home = getenv("HOME");
    const char *base = is_absolute(state) ? state : local;
    int n = 0;
    if (is_absolute(base)) {
        n = snprintf(out, STATE_PATH_BYTES, "%s/lumsdk/sensors", base);
    } else if (is_absolute(home)) {
        n = snprintf(out, STATE_PATH_BYTES, "%s/.local/state/lumsdk/sensors",
                     home);
    }
    return n > 0 && n < STATE_PATH_BYTES
               ? 0
               : lum_error_set(error,
                               "neither XDG_STATE_HOME nor HOME (on Windows: "
                               "LOCALAPPDATA) names a folder where it could "
                               "be kept");
}

/* And all above it. Whether they could be made shows when the lock is opened.
 */
static void make_folders(const char *folder)
{
    char path[STATE_PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s", folder);
    for (char *at = path + 1;; at++) {
        const char was = *at;
        if (was == '/' || was == '\\' || was == '\0') {
            *at = '\0';
            (void)make_private_folder(path);
            *at = was;
        }
        if (was == '\0') {
            return;
        }
    }
}

/* The lock of a program that was stopped is not waited for without end. */
int state_lock(const char *folder, int64_t wait_ns, lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ns;
    char path[LONG_PATH_BYTES];
    make_folders(folder);
    (void)snprintf(path, sizeof path, "%s/.lock", folder);
    int lock = rows_file_open(path, true);
    while (lock < 0 && errno == EBUSY && lum_time_monotonic_ns() < end) {
        lum_time_sleep_until(lum_time_monotonic_ns() + LOOK_NS);
        lock = rows_file_open(path, true);
    }
    if (lock < 0) {
        (void)(errno == EBUSY
                   ? lum_error_set(error, "%s: another lumctl is using it",
                                   path)
                   : fail(path, "cannot be opened", error));
    }
    return lock;
}

void state_unlock(int lock)
{
    (void)close(lock);
}

int state_read(const char *path, char *out, size_t size, lum_error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return errno == ENOENT || errno == ENOTDIR
                   ? 0
                   : fail(path, "cannot be read", error);
    }
    errno = 0;
    const size_t len = fread(out, 1, size, file);
    const int result =
        ferror(file) != 0 ? fail(path, "cannot be read", error) : 1;
    (void)fclose(file);
    if (result == 1 && (len == size || memchr(out, '\0', len) != NULL)) {
        return lum_error_set(error, "%s: is not a state file of lumctl", path);
    }
    out[len < size ? len : 0] = '\0';
    return result;
}

/* Not forced to the disk: one that is slow must not hold up the heartbeats of a
 * shell, and a file that a power failure has spoilt is passed over. */
int state_write(const char *path, const char *text, size_t len,
                lum_error *error)
{
    char part[LONG_PATH_BYTES];
    (void)snprintf(part, sizeof part, "%s.part", path);
    const int fd = rows_file_open(part, true);
    if (fd < 0) {
        return fail(path, "cannot be written", error);
    }
    int code = rows_file_cut(fd, 0) == 0 && rows_file_put(fd, text, len) == 0
                   ? 0
                   : errno;
    code = close(fd) != 0 && code == 0 ? errno : code;
    if (code == 0 && rows_file_replace(part, path) == 0) {
        return 0;
    }
    errno = code != 0 ? code : errno;
    (void)fail(path, "cannot be written", error);
    (void)unlink(part);
    return -1;
}
