#define _DEFAULT_SOURCE /* flock */
#include "claim.h"

#include "lum/base/time.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAGIC      "lumsdk\n"
#define PROCESS    "process "
#define UNFINISHED "unfinished "
#define PART       ".part"

#define STEM_BYTES  200u /* of a longer name its beginning and a hash */
#define HASH_DIGITS 16u
#define UNIQUE      12u /* digits that no other run has */
#define MARK_BYTES  512u
#define TRIES       100

/* A path's directory, with its slash, and what its last part is called in names
 * beside it. */
struct place {
    size_t directory_len;
    char stem[STEM_BYTES + 1u];
};

static uint64_t hash_text(const char *text)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (; *text != '\0'; text++) {
        hash = (hash ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
    }
    return hash;
}

static struct place place_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *base = slash != NULL ? slash + 1 : path;
    struct place p = {.directory_len = (size_t)(base - path)};
    if (strlen(base) <= STEM_BYTES) {
        (void)snprintf(p.stem, sizeof p.stem, "%s", base);
    } else {
        (void)snprintf(p.stem, sizeof p.stem, "%.*s~%016" PRIx64,
                       (int)(STEM_BYTES - HASH_DIGITS - 1u), base,
                       hash_text(base));
    }
    return p;
}

/* directory/ before stem after */
static char *compose(const char *path, const struct place *p,
                     const char *before, const char *after)
{
    const size_t size = p->directory_len + strlen(before) + strlen(p->stem) +
                        strlen(after) + 1u;
    char *whole = malloc(size);
    if (whole != NULL) {
        (void)snprintf(whole, size, "%.*s%s%s%s", (int)p->directory_len, path,
                       before, p->stem, after);
    }
    return whole;
}

/* Others are kept away by O_EXCL; this need only be new most of the time. */
static uint64_t make_unique(void)
{
    uint64_t x = (uint64_t)lum_time_utc_ns() + ((uint64_t)getpid() << 40);
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

char *lum_claim_beside(const char *path)
{
    char after[UNIQUE + sizeof "." PART];
    const struct place p = place_of(path);
    (void)snprintf(after, sizeof after, ".%0*" PRIx64 PART, (int)UNIQUE,
                   make_unique() >> (64u - 4u * UNIQUE));
    return compose(path, &p, "", after);
}

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

/* What a mark says. */
struct mark {
    char text[MARK_BYTES];
};

/* Whether it is one; a run that was killed early has left it empty. */
static bool read_mark(int fd, struct mark *out)
{
    struct stat status;
    const ssize_t n = pread(fd, out->text, sizeof out->text - 1u, 0);
    out->text[n > 0 ? n : 0] = '\0';
    return n >= 0 && fstat(fd, &status) == 0 && S_ISREG(status.st_mode) &&
           (n == 0 || strncmp(out->text, MAGIC, strlen(MAGIC)) == 0);
}

/* The rest of the line that begins with a key, in place; NULL: there is none.
 */
static char *line_of(struct mark *mark, const char *key)
{
    char *at = strstr(mark->text, key);
    if (at == NULL || at == mark->text || at[-1] != '\n') {
        return NULL;
    }
    at += strlen(key);
    char *end = strchr(at, '\n');
    if (end == NULL) {
        return NULL;
    }
    *end = '\0';
    return at;
}

static bool is_unfinished_name(const char *name, const char *stem)
{
    const size_t len = strlen(stem);
    return strncmp(name, stem, len) == 0 && name[len] == '.' &&
           strspn(name + len + 1u, "0123456789abcdef") == UNIQUE &&
           strcmp(name + len + 1u + UNIQUE, PART) == 0;
}

/* What a run that was killed has left. A mark may say anything, so only what
 * bears such a name, beside the mark, and is locked by nobody goes. */
static void remove_unfinished(const char *path, const struct place *p,
                              struct mark *mark)
{
    struct stat status;
    const char *name = line_of(mark, UNFINISHED);
    if (name == NULL || !is_unfinished_name(name, p->stem)) {
        return;
    }
    char *whole = compose(path, p, "", name + strlen(p->stem));
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

static int refuse_busy(struct mark *mark, const char *shown, lum_error *error)
{
    const char *text = line_of(mark, PROCESS);
    const long process = text != NULL ? strtol(text, NULL, 10) : 0;
    if (process == (long)getpid()) {
        (void)lum_error_set(error,
                            "%s: this run is writing it already: choose "
                            "another name",
                            shown);
    } else if (process > 0) {
        (void)lum_error_set(error,
                            "%s: another run is writing it (process %ld): wait "
                            "for its end, or choose another name",
                            shown, process);
    } else {
        (void)lum_error_set(error,
                            "%s: another run is writing it: wait for its end, "
                            "or choose another name",
                            shown);
    }
    errno = EBUSY;
    return -1;
}

static int refuse_foreign(const char *path, const char *shown, lum_error *error)
{
    (void)lum_error_set(error,
                        "%s: cannot be written while %s is there, which would "
                        "mark that it is being written: rename that one, or "
                        "choose another name",
                        shown, path);
    errno = EEXIST;
    return -1;
}

/* What became of one attempt. */
enum attempt {
    TAKEN,
    AGAIN,
    FAILED
};

static void leave_process(int fd)
{
    char text[64];
    const int n =
        snprintf(text, sizeof text, MAGIC PROCESS "%ld\n", (long)getpid());
    const ssize_t written = pwrite(fd, text, (size_t)n, 0);
    (void)written;
}

/* One that was just made is empty, and another run may take it for one of a run
 * that was killed; then the lock is that one's. */
static enum attempt make_mark(lum_claim *claim)
{
    if (lum_claim_lock(claim->fd) != 0 || !is_same(claim->fd, claim->mark)) {
        return AGAIN;
    }
    (void)fchmod(claim->fd, S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
    leave_process(claim->fd);
    return TAKEN;
}

/* One that is there: of a run that lives, or of one that was killed. The lock
 * is known to work before anything is removed. */
static enum attempt look_at_mark(lum_claim *claim, const char *path,
                                 const char *shown, lum_error *error)
{
    struct mark mark;
    const struct place p = place_of(path);
    const bool is_locked = flock(claim->fd, LOCK_EX | LOCK_NB) == 0;
    const int code = errno;
    const bool is_mark = read_mark(claim->fd, &mark);
    if (!is_mark) {
        (void)refuse_foreign(claim->mark, shown, error);
        return FAILED;
    }
    if (!is_locked && code == EWOULDBLOCK) {
        (void)refuse_busy(&mark, shown, error);
        return FAILED;
    }
    if (!is_locked || !is_same(claim->fd, claim->mark)) {
        return is_locked ? AGAIN : TAKEN;
    }
    remove_unfinished(path, &p, &mark);
    return unlink(claim->mark) == 0 ? AGAIN : TAKEN;
}

static void release(lum_claim *claim)
{
    if (claim->fd >= 0) {
        (void)close(claim->fd);
        claim->fd = -1;
    }
}

/* To lock it, some network file systems want it writable; one of another user
 * is not. */
static int open_mark(const char *path)
{
    const int flags = O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
    int fd = open(path, O_RDWR | flags);
    if (fd < 0 && errno == EACCES) {
        fd = open(path, O_RDONLY | flags);
    }
    return fd;
}

static enum attempt attempt(lum_claim *claim, const char *path,
                            const char *shown, lum_error *error)
{
    claim->fd =
        open(claim->mark, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
             S_IRUSR | S_IWUSR);
    if (claim->fd >= 0) {
        return make_mark(claim);
    }
    if (errno != EEXIST) {
        (void)fail(errno, shown, "cannot create it", error);
        return FAILED;
    }
    claim->fd = open_mark(claim->mark);
    if (claim->fd >= 0) {
        return look_at_mark(claim, path, shown, error);
    }
    if (errno == ENOENT) {
        return AGAIN;
    }
    (void)refuse_foreign(claim->mark, shown, error);
    return FAILED;
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
    *claim = (lum_claim)LUM_CLAIM_NONE;
    errno = code;
}

/* --- Taking and dropping a name --- */

int lum_claim_take(const char *path, const char *shown, lum_claim *out,
                   lum_error *error)
{
    const struct place p = place_of(path);
    enum attempt result = AGAIN;
    *out = (lum_claim){compose(path, &p, ".", ".lumsdk"), -1};
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
        (void)refuse_busy(&(struct mark){""}, shown, error);
    }
    forget(out);
    return is_unwritable(errno) ? 0 : -1;
}

void lum_claim_note(const lum_claim *claim, const char *unfinished)
{
    char text[MARK_BYTES];
    const char *slash = strrchr(unfinished, '/');
    const int n =
        snprintf(text, sizeof text, MAGIC PROCESS "%ld\n" UNFINISHED "%s\n",
                 (long)getpid(), slash != NULL ? slash + 1 : unfinished);
    if (claim->fd >= 0 && n > 0 && (size_t)n < sizeof text) {
        const ssize_t written = pwrite(claim->fd, text, (size_t)n, 0);
        (void)written;
    }
}

void lum_claim_drop(lum_claim *claim)
{
    if (claim->fd >= 0 && is_same(claim->fd, claim->mark)) {
        (void)unlink(claim->mark);
    }
    forget(claim);
}
