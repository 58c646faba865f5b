#define WIN32_LEAN_AND_MEAN
#include "store.h"

#include "lum/base/time.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

#define LOOK_NS INT64_C(10000000)

/* Room for the suffix of a name while its file is written. */
#define TEMPORARY_BYTES (STORE_PATH_BYTES + 32)

int store_folder(char out[STORE_PATH_BYTES], lum_error *error)
{
    const char *state = getenv("XDG_STATE_HOME");
    const char *home = getenv("LOCALAPPDATA");
    const char *base = state != NULL && *state != '\0' ? state : home;
    const int n =
        base != NULL && *base != '\0'
            ? snprintf(out, STORE_PATH_BYTES, "%s\\lumsdk\\sensors", base)
            : 0;
    if (n <= 0 || n >= STORE_PATH_BYTES) {
        return lum_error_set(error, "neither XDG_STATE_HOME nor LOCALAPPDATA "
                                    "names a folder where it could be kept");
    }
    return 0;
}

static int fail(const char *path, const char *doing, lum_error *error)
{
    return lum_error_set(error, "%s: %s: error %lu", path, doing,
                         GetLastError());
}

static bool is_separator(char c)
{
    return c == '\\' || c == '/' || c == '\0';
}

/* Makes a folder and all above it. A folder that cannot be made, for example a
 * drive, may exist; opening the lock shows it. */
static void make_folder(const char *folder)
{
    char path[STORE_PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s", folder);
    for (char *at = path + 1;; at++) {
        const char was = *at;
        if (!is_separator(was)) {
            continue;
        }
        *at = '\0';
        (void)CreateDirectoryA(path, NULL);
        if (was == '\0') {
            return;
        }
        *at = was;
    }
}

/* A file that is open without sharing is the lock. */
int store_lock(const char *folder, int64_t wait_ns, struct store_lock *out,
               lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ns;
    char path[TEMPORARY_BYTES];
    make_folder(folder);
    (void)snprintf(path, sizeof path, "%s\\.lock", folder);
    for (;;) {
        const HANDLE file =
            CreateFileA(path, GENERIC_READ | GENERIC_WRITE, 0, NULL,
                        OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, NULL);
        if (file != INVALID_HANDLE_VALUE) {
            out->handle = (intptr_t)file;
            return 0;
        }
        if (GetLastError() != ERROR_SHARING_VIOLATION) {
            return fail(path, "cannot be opened", error);
        }
        if (lum_time_monotonic_ns() >= end) {
            return lum_error_set(error, "%s: another lumctl holds it", path);
        }
        lum_time_sleep_until(lum_time_monotonic_ns() + LOOK_NS);
    }
}

void store_unlock(const struct store_lock *lock)
{
    (void)CloseHandle((HANDLE)lock->handle);
}

/* Not forced to the disk: one that is slow must not hold up the heartbeats of a
 * shell, and a file that a power failure has spoilt is passed over. */
int store_write(const char *path, const char *text, size_t len,
                lum_error *error)
{
    char part[TEMPORARY_BYTES];
    DWORD written = 0;
    (void)snprintf(part, sizeof part, "%s.%lu", path, GetCurrentProcessId());
    const HANDLE file = CreateFileA(part, GENERIC_WRITE, 0, NULL, CREATE_ALWAYS,
                                    FILE_ATTRIBUTE_NORMAL, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        return fail(path, "cannot be written", error);
    }
    const bool good = WriteFile(file, text, (DWORD)len, &written, NULL) &&
                      written == (DWORD)len;
    (void)CloseHandle(file);
    if (good && MoveFileExA(part, path, MOVEFILE_REPLACE_EXISTING)) {
        return 0;
    }
    (void)fail(path, "cannot be written", error);
    (void)DeleteFileA(part);
    return -1;
}

void store_remove(const char *path)
{
    (void)DeleteFileA(path);
}
