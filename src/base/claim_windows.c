/* The right to write a file, on Windows: a mark beside it that nobody else
 * can open for writing. */
#include "claim.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

/* The system's share modes are the locks: only one process can open a mark for
 * writing, and others may read in it which process that is. */

static HANDLE open_mark(const char *path, DWORD access, DWORD share,
                        DWORD creation)
{
    return CreateFileA(path, access, share, NULL, creation,
                       FILE_ATTRIBUTE_NORMAL, NULL);
}

static bool read_mark(HANDLE file, lum_claim_mark *out)
{
    DWORD n = 0;
    const bool is_read =
        ReadFile(file, out->text, sizeof out->text - 1u, &n, NULL) != 0;
    out->text[n] = '\0';
    return is_read && lum_claim_is_mark(out);
}

/* errno: EBUSY. */
static int refuse_other(const char *mark_path, const char *shown,
                        lum_error *error)
{
    lum_claim_mark mark = {""};
    const HANDLE file = open_mark(
        mark_path, GENERIC_READ,
        FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, OPEN_EXISTING);
    if (file != INVALID_HANDLE_VALUE) {
        (void)read_mark(file, &mark);
        (void)CloseHandle(file);
    }
    return lum_claim_refuse_busy(&mark, shown, error);
}

static int fail(DWORD code, const char *mark_path, const char *shown,
                lum_error *error)
{
    switch (code) {
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
        return refuse_other(mark_path, shown, error);
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
        errno = ENOENT;
        break;
    case ERROR_INVALID_NAME:
        errno = EINVAL;
        break;
    default:
        errno = EIO;
        break;
    }
    return lum_error_set(error, "%s: cannot create it: %s", shown,
                         strerror(errno));
}

/* DeleteFile() refuses one that another has open. */
static void remove_unfinished(const char *path, lum_claim_mark *mark)
{
    char *whole = lum_claim_unfinished(mark, path);
    if (whole != NULL) {
        (void)DeleteFileA(whole);
    }
    free(whole);
}

static void leave(HANDLE file, const char *unfinished)
{
    lum_claim_mark mark;
    DWORD written = 0;
    const size_t n = lum_claim_write_mark(&mark, unfinished);
    (void)SetFilePointer(file, 0, NULL, FILE_BEGIN);
    (void)WriteFile(file, mark.text, (DWORD)n, &written, NULL);
    (void)SetEndOfFile(file);
}

/* The mark is open and belongs to nobody else: it is of a killed run, or
 * new. */
static int settle(HANDLE file, const char *path, const char *shown,
                  lum_claim *claim, lum_error *error)
{
    lum_claim_mark mark;
    if (!read_mark(file, &mark)) {
        (void)CloseHandle(file);
        return lum_claim_refuse_foreign(claim->mark, shown, error);
    }
    remove_unfinished(path, &mark);
    leave(file, NULL);
    claim->fd = _open_osfhandle((intptr_t)file, _O_BINARY | _O_NOINHERIT);
    if (claim->fd < 0) {
        (void)CloseHandle(file);
        return fail(ERROR_TOO_MANY_OPEN_FILES, claim->mark, shown, error);
    }
    return 0;
}

static void forget(lum_claim *claim)
{
    const int code = errno;
    if (claim->fd >= 0) {
        (void)_close(claim->fd);
    }
    free(claim->mark);
    *claim = LUM_CLAIM_NONE;
    errno = code;
}

static int take(const char *path, const char *shown, lum_claim *claim,
                lum_error *error)
{
    const HANDLE file = open_mark(claim->mark, GENERIC_READ | GENERIC_WRITE,
                                  FILE_SHARE_READ, OPEN_ALWAYS);
    if (file != INVALID_HANDLE_VALUE) {
        return settle(file, path, shown, claim, error);
    }
    const DWORD code = GetLastError();
    if (code == ERROR_ACCESS_DENIED || code == ERROR_WRITE_PROTECT) {
        errno = EACCES;
        return -1;
    }
    return fail(code, claim->mark, shown, error);
}

int lum_claim_take(const char *path, const char *shown, lum_claim *out,
                   lum_error *error)
{
    const lum_claim_place p = lum_claim_place_of(path);
    *out = (lum_claim){lum_claim_compose(path, &p, ".", ".lumsdk"), -1};
    if (out->mark == NULL) {
        errno = ENOMEM;
        return lum_error_set(error, "%s: cannot open it: %s", shown,
                             strerror(errno));
    }
    if (take(path, shown, out, error) == 0) {
        return 0;
    }
    forget(out);
    return errno == EACCES ? 0 : -1;
}

void lum_claim_note(const lum_claim *claim, const char *unfinished)
{
    if (claim->fd >= 0) {
        leave((HANDLE)_get_osfhandle(claim->fd), unfinished);
    }
}

/* If another process opens it in between, it cannot be removed. */
void lum_claim_drop(lum_claim *claim)
{
    if (claim->fd >= 0) {
        (void)_close(claim->fd);
        claim->fd = -1;
        (void)DeleteFileA(claim->mark);
    }
    forget(claim);
}

/* A process that writes a file does not share it with other writers. */
bool lum_claim_is_locked(const char *path)
{
    const HANDLE file =
        CreateFileA(path, GENERIC_WRITE,
                    FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                    NULL, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        return GetLastError() == ERROR_SHARING_VIOLATION;
    }
    (void)CloseHandle(file);
    return false;
}

/* It was opened so. */
int lum_claim_lock(int fd)
{
    (void)fd;
    return 0;
}
