/* Names that one process at a time holds, on Windows: mutexes. */
#include "net/winsock.h"

#include "net/owner.h"

#include <stdio.h>
#include <stdlib.h>

/* The right is the existence of the mutex, which ends with its last handle. The
 * process number is in separate memory that the desktop session shares. */
typedef struct holding {
    HANDLE mutex;
    HANDLE note;
} holding;

typedef struct object_name {
    char text[LUM_OWNER_NAME_BYTES + 64];
} object_name;

/* Names of objects have no backslash except after their namespace. */
static object_name name_of(const char *room, const char *name)
{
    object_name out;
    const int start =
        snprintf(out.text, sizeof out.text, "%s\\lumsdk-session-", room);
    (void)snprintf(out.text + start, sizeof out.text - (size_t)start, "%.99s",
                   name);
    for (char *c = out.text + start; *c != '\0'; c++) {
        *c = (char)(*c == '\\' ? '_' : *c);
    }
    return out;
}

/* Without the note, the message of a second session only says less. */
static HANDLE leave_process(const char *name)
{
    const object_name note = name_of("Local", name);
    const HANDLE handle =
        CreateFileMappingA(INVALID_HANDLE_VALUE, NULL, PAGE_READWRITE, 0,
                           sizeof(DWORD), note.text);
    DWORD *process = handle != NULL ? MapViewOfFile(handle, FILE_MAP_WRITE, 0,
                                                    0, sizeof *process)
                                    : NULL;
    if (process != NULL) {
        *process = GetCurrentProcessId();
        (void)UnmapViewOfFile(process);
    }
    return handle;
}

static long read_process(const char *name)
{
    const object_name note = name_of("Local", name);
    long found = 0;
    const HANDLE handle = OpenFileMappingA(FILE_MAP_READ, FALSE, note.text);
    if (handle == NULL) {
        return 0;
    }
    const DWORD *process =
        MapViewOfFile(handle, FILE_MAP_READ, 0, 0, sizeof *process);
    if (process != NULL) {
        found = (long)*process;
        (void)UnmapViewOfFile(process);
    }
    (void)CloseHandle(handle);
    return found;
}

/* The mutex if it was not there; else NULL, and whether another has it. */
static HANDLE make_mutex(const char *name, DWORD *code)
{
    const object_name global = name_of("Global", name);
    const HANDLE mutex = CreateMutexA(NULL, FALSE, global.text);
    *code = GetLastError();
    if (mutex != NULL && *code == ERROR_ALREADY_EXISTS) {
        (void)CloseHandle(mutex);
        return NULL;
    }
    return mutex;
}

lum_net_result lum_owner_system_hold(const char *name, intptr_t *held,
                                     long *process, lum_error *error)
{
    DWORD code = 0;
    holding *out = malloc(sizeof *out);
    if (out == NULL) {
        (void)lum_error_set(error, "no memory left for a session");
        return LUM_NET_FAILED;
    }
    out->mutex = make_mutex(name, &code);
    if (out->mutex != NULL) {
        out->note = leave_process(name);
        *held = (intptr_t)out;
        return LUM_NET_OK;
    }
    free(out);
    if (code == ERROR_ALREADY_EXISTS || code == ERROR_ACCESS_DENIED) {
        *process = read_process(name);
        return LUM_NET_BUSY;
    }
    (void)lum_error_set(error,
                        "cannot mark the session with %s as taken by a mutex: "
                        "Windows error %lu",
                        name, code);
    return LUM_NET_FAILED;
}

/* Opening makes nothing. */
bool lum_owner_system_look(const char *name, long *process)
{
    const object_name global = name_of("Global", name);
    const HANDLE mutex = OpenMutexA(SYNCHRONIZE, FALSE, global.text);
    const bool is_there =
        mutex != NULL || GetLastError() == ERROR_ACCESS_DENIED;
    if (mutex != NULL) {
        (void)CloseHandle(mutex);
    }
    if (is_there) {
        *process = read_process(name);
    }
    return is_there;
}

void lum_owner_system_drop(intptr_t held)
{
    holding *out = (holding *)held;
    (void)CloseHandle(out->mutex);
    if (out->note != NULL) {
        (void)CloseHandle(out->note);
    }
    free(out);
}
