/* The right to write a file, on POSIX: a mark beside it that flock()
 * locks. */
#define _DEFAULT_SOURCE /* flock */
#include "claim.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define TRIES 100

/* --- Locks and marks --- */

int lum_claim_lock(int fd)
{
    return flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK ? 0 : -1;
}

bool lum_claim_is_locked(const char *path)
{
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0) {
        return false;
    }
    const bool is_locked =
        flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    (void)close(fd);
    return is_locked;
}

static bool is_same(int fd, const char *path)
{
    struct stat s;
    struct stat t;
    return fstat(fd, &s) == 0 && lstat(path, &t) == 0 && s.st_dev == t.st_dev &&
           s.st_ino == t.st_ino;
}

/* Whether it is one. */
static bool read_mark(int fd, lum_claim_mark *out)
{
    struct stat status;
    const ssize_t n = pread(fd, out->text, sizeof out->text - 1u, 0);
    out->text[n > 0 ? n : 0] = '\0';
    return n >= 0 && fstat(fd, &status) == 0 && S_ISREG(status.st_mode) &&
           lum_claim_is_mark(out);
}

/* What a run that was killed has left, unless somebody has locked it. */
static void remove_unfinished(const char *path, lum_claim_mark *mark)
{
    struct stat status;
    char *whole = lum_claim_unfinished(mark, path);
    if (whole != NULL && lstat(whole, &status) == 0 &&
        S_ISREG(status.st_mode) && !lum_claim_is_locked(whole)) {
        (void)unlink(whole);
    }
    free(whole);
}

/* --- Refusals --- */

static int fail(int code, const char *shown, const char *doing,
                lum_error *error)
{
    (void)lum_error_set(error, "%s: %s: %s", shown, doing, strerror(code));
    errno = code;
    return -1;
}

/* What became of one attempt; -1: it failed. */
enum {
    TAKEN,
    AGAIN
};

static void leave(int fd, const char *unfinished)
{
    lum_claim_mark mark;
    const size_t n = lum_claim_write_mark(&mark, unfinished);
    const ssize_t written = pwrite(fd, mark.text, n, 0);
    (void)written;
}

/* A new mark is empty, and another run may take it for the mark of a killed
 * run; then that run has the lock. */
static int make_mark(lum_claim *claim)
{
    if (lum_claim_lock(claim->fd) != 0 || !is_same(claim->fd, claim->mark)) {
        return AGAIN;
    }
    (void)fchmod(claim->fd, S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
    leave(claim->fd, NULL);
    return TAKEN;
}

/* An existing mark, of a running or a killed run. Nothing is removed before the
 * lock is known to work. */
static int look_at_mark(lum_claim *claim, const char *path, const char *shown,
                        lum_error *error)
{
    lum_claim_mark mark;
    const bool is_locked = flock(claim->fd, LOCK_EX | LOCK_NB) == 0;
    const int code = errno;
    const bool is_mark = read_mark(claim->fd, &mark);
    if (!is_mark) {
        return lum_claim_refuse_foreign(claim->mark, shown, error);
    }
    if (!is_locked && code == EWOULDBLOCK) {
        return lum_claim_refuse_busy(&mark, shown, error);
    }
    if (!is_locked || !is_same(claim->fd, claim->mark)) {
        return is_locked ? AGAIN : TAKEN;
    }
    remove_unfinished(path, &mark);
    return unlink(claim->mark) == 0 ? AGAIN : TAKEN;
}

static void release(lum_claim *claim)
{
    if (claim->fd >= 0) {
        (void)close(claim->fd);
        claim->fd = -1;
    }
}

/* Some network file systems lock only writable files; a mark of another user is
 * not writable. */
static int open_mark(const char *path)
{
    const int flags = O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
    int fd = open(path, O_RDWR | flags);
    if (fd < 0 && errno == EACCES) {
        fd = open(path, O_RDONLY | flags);
    }
    return fd;
}

static int attempt(lum_claim *claim, const char *path, const char *shown,
                   lum_error *error)
{
    claim->fd =
        open(claim->mark, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
             S_IRUSR | S_IWUSR);
    if (claim->fd >= 0) {
        return make_mark(claim);
    }
    if (errno != EEXIST) {
        return fail(errno, shown, "cannot create it", error);
    }
    claim->fd = open_mark(claim->mark);
    if (claim->fd >= 0) {
        return look_at_mark(claim, path, shown, error);
    }
    return errno == ENOENT
               ? AGAIN
               : lum_claim_refuse_foreign(claim->mark, shown, error);
}

static bool is_unwritable(int code)
{
    return code == EACCES || code == EPERM || code == EROFS;
}

static void forget(lum_claim *claim)
{
    const int code = errno;
    release(claim);
    free(claim->mark);
    *claim = LUM_CLAIM_NONE;
    errno = code;
}

/* --- Taking and dropping a name --- */

int lum_claim_take(const char *path, const char *shown, lum_claim *out,
                   lum_error *error)
{
    const lum_claim_place p = lum_claim_place_of(path);
    int result = AGAIN;
    *out = (lum_claim){lum_claim_compose(path, &p, ".", ".lumsdk"), -1};
    if (out->mark == NULL) {
        return fail(ENOMEM, shown, "cannot open it", error);
    }
    for (int i = 0; i < TRIES && result == AGAIN; i++) {
        release(out);
        result = attempt(out, path, shown, error);
    }
    if (result == TAKEN) {
        return 0;
    }
    if (result == AGAIN) {
        (void)lum_claim_refuse_busy(&(lum_claim_mark){""}, shown, error);
    }
    forget(out);
    return is_unwritable(errno) ? 0 : -1;
}

void lum_claim_note(const lum_claim *claim, const char *unfinished)
{
    if (claim->fd >= 0) {
        leave(claim->fd, unfinished);
    }
}

void lum_claim_drop(lum_claim *claim)
{
    if (claim->fd >= 0 && is_same(claim->fd, claim->mark)) {
        (void)unlink(claim->mark);
    }
    forget(claim);
}
