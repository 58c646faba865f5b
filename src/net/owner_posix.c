/* Names that one process at a time holds, on POSIX: locked files in /tmp. */
#define _DEFAULT_SOURCE
#include "net/owner.h"

#include "lum/base/time.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define LOOKS_MS 5000 /* to wait for those who look */

/* A file with an exclusive lock, which is gone with the last descriptor. The
 * file stays, since two processes could lock a name that comes and goes. Who
 * only looks has a shared lock for some microseconds. */
typedef struct lock_path {
    char text[LUM_OWNER_NAME_BYTES + 32];
} lock_path;

static lock_path path_of(const char *name)
{
    static const char before[] = "/tmp/lumsdk-session-";
    lock_path out;
    (void)snprintf(out.text, sizeof out.text, "%s%s", before, name);
    for (char *c = out.text + sizeof before - 1u; *c != '\0'; c++) {
        *c = (char)(*c == '/' ? '_' : *c);
    }
    return out;
}

/* The umask must not apply: other users lock the file too. Only the owner may
 * do this. */
static int open_for_all(const char *path)
{
    const mode_t everyone = 0666;
    const int fd =
        open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, everyone);
    if (fd >= 0) {
        (void)fchmod(fd, everyone);
    }
    return fd;
}

/* For a second session; without it, its message only says less. */
static void leave_process(int fd)
{
    char text[32];
    const int n = snprintf(text, sizeof text, "%ld\n", (long)getpid());
    if (ftruncate(fd, 0) == 0) {
        const ssize_t written = pwrite(fd, text, (size_t)n, 0);
        (void)written;
    }
}

static long read_process(int fd)
{
    char text[32];
    const ssize_t n = pread(fd, text, sizeof text - 1u, 0);
    text[n > 0 ? n : 0] = '\0';
    return strtol(text, NULL, 10);
}

/* 0, or an errno. Those who only look do not count. */
static int lock(int fd)
{
    int code = flock(fd, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    for (int i = 0; i < LOOKS_MS && code == EWOULDBLOCK &&
                    flock(fd, LOCK_SH | LOCK_NB) == 0;
         i++) {
        (void)flock(fd, LOCK_UN);
        lum_time_sleep_until(lum_time_monotonic_ns() + 1000000);
        code = flock(fd, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    }
    return code;
}

lum_net_result lum_owner_system_hold(const char *name, intptr_t *held,
                                     long *process, lum_error *error)
{
    const lock_path path = path_of(name);
    lum_net_result result = LUM_NET_FAILED;
    const int fd = open_for_all(path.text);
    const int code = fd >= 0 ? lock(fd) : errno;
    if (code == 0) {
        leave_process(fd);
        *held = fd;
        return LUM_NET_OK;
    }
    if (code == EWOULDBLOCK) {
        *process = read_process(fd);
        result = LUM_NET_BUSY;
    } else {
        (void)lum_error_set(error,
                            "cannot mark the session as taken by a lock on "
                            "%s: %s",
                            path.text, strerror(code));
    }
    if (fd >= 0) {
        (void)close(fd);
    }
    return result;
}

bool lum_owner_system_look(const char *name, long *process)
{
    const lock_path path = path_of(name);
    const int fd = open(path.text, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    const bool is_there =
        fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (is_there) {
        *process = read_process(fd);
    }
    if (fd >= 0) {
        (void)close(fd);
    }
    return is_there;
}

void lum_owner_system_drop(intptr_t held)
{
    (void)close((int)held);
}
