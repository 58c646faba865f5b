/* Outputs opened, named and ended, on Windows: a path comes in; what goes out
 * is a descriptor to write to, and at the end the whole file under that path.
 */
#include "outfile_parts.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

#define TRIES 100 /* to find a name that is free */

static int refuse_busy(const lum_outfile *file, lum_error *error)
{
    return lum_outfile_refuse(
        EBUSY, file->name,
        "another program has it open: wait for its end, or choose another name",
        error);
}

/* The system's error of the last call. */
static int fail_last(const lum_outfile *file, const char *doing,
                     lum_error *error)
{
    const int code = lum_outfile_code(GetLastError());
    if (code == EBUSY) {
        return refuse_busy(file, error);
    }
    if (code == ENOENT) {
        return lum_outfile_refuse_directory(file, error);
    }
    return lum_outfile_fail(file, code, doing, error);
}

static int adopt(lum_outfile *file, HANDLE handle, lum_error *error)
{
    file->fd = _open_osfhandle((intptr_t)handle, _O_BINARY | _O_NOINHERIT);
    if (file->fd < 0) {
        (void)CloseHandle(handle);
        return lum_outfile_fail(file, EMFILE, "cannot open it", error);
    }
    return 0;
}

/* Others may read it, and it may get another name while it is open. */
static HANDLE create(const char *path, DWORD creation)
{
    return CreateFileA(path, GENERIC_WRITE | DELETE,
                       FILE_SHARE_READ | FILE_SHARE_DELETE, NULL, creation,
                       FILE_ATTRIBUTE_NORMAL, NULL);
}

static int create_part(lum_outfile *file, lum_error *error)
{
    HANDLE handle = INVALID_HANDLE_VALUE;
    DWORD code = ERROR_FILE_EXISTS;
    for (int i = 0; i < TRIES && code == ERROR_FILE_EXISTS; i++) {
        free(file->part);
        file->part = lum_claim_beside(file->path);
        if (file->part == NULL) {
            return lum_outfile_fail(file, ENOMEM, "cannot create it", error);
        }
        handle = create(file->part, CREATE_NEW);
        code = handle == INVALID_HANDLE_VALUE ? GetLastError() : 0;
    }
    if (code != 0) {
        free(file->part);
        file->part = NULL;
        SetLastError(code);
        return fail_last(file, "cannot create it", error);
    }
    return adopt(file, handle, error);
}

static int make(lum_outfile *file, const char *path, lum_error *error)
{
    lum_claim taken;
    file->path = _fullpath(NULL, path, 0);
    if (file->path == NULL) {
        return lum_outfile_fail(file, errno, "cannot use the name", error);
    }
    const int result = lum_claim_take(file->path, file->name, &taken, error);
    file->claim = taken;
    if (result != 0) {
        return errno == ENOENT ? lum_outfile_refuse_directory(file, error) : -1;
    }
    if (lum_claim_is_locked(file->path)) {
        return refuse_busy(file, error);
    }
    if (create_part(file, error) != 0) {
        return -1;
    }
    lum_claim_note(&file->claim, file->part);
    return 0;
}

static int open_standard_output(lum_outfile *file, lum_error *error)
{
    file->fd = _dup(_fileno(stdout));
    if (file->fd < 0) {
        return lum_outfile_fail(file, errno, "cannot be used as output", error);
    }
    (void)_setmode(file->fd, _O_BINARY);
    return 0;
}

/* A pipe or a device also has a path, but gets no name. */
static int open_in_place(lum_outfile *file, const char *path, lum_error *error)
{
    const HANDLE handle =
        CreateFileA(path, GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE,
                    NULL, OPEN_EXISTING, 0, NULL);
    return handle != INVALID_HANDLE_VALUE
               ? adopt(file, handle, error)
               : fail_last(file, "cannot open it", error);
}

static bool is_device(const char *path)
{
    return strncmp(path, "\\\\.\\", 4) == 0 || _stricmp(path, "NUL") == 0 ||
           _stricmp(path, "CON") == 0;
}

int lum_outfile_system_open(lum_outfile *file, lum_outfile_kind kind,
                            const char *path, lum_error *error)
{
    (void)kind;
    if (strcmp(path, "-") == 0) {
        return open_standard_output(file, error);
    }
    if (is_device(path)) {
        return open_in_place(file, path, error);
    }
    const DWORD attributes = GetFileAttributesA(path);
    if (attributes == INVALID_FILE_ATTRIBUTES) {
        return make(file, path, error);
    }
    if ((attributes & FILE_ATTRIBUTE_DIRECTORY) != 0) {
        return lum_outfile_refuse(EISDIR, path,
                                  "is a directory; name a file in it", error);
    }
    if ((attributes & FILE_ATTRIBUTE_READONLY) != 0) {
        return lum_outfile_refuse(EACCES, path,
                                  "cannot replace it: it is read-only", error);
    }
    return make(file, path, error);
}

void lum_outfile_system_learn(lum_outfile *file)
{
    const HANDLE handle = (HANDLE)_get_osfhandle(file->fd);
    const int64_t here = _lseeki64(file->fd, 0, SEEK_CUR);
    file->may_block = GetFileType(handle) != FILE_TYPE_DISK;
    file->seekable = !file->may_block && here >= 0;
    file->base = file->seekable ? here : 0;
}

static int give_name(lum_outfile *file, lum_error *error)
{
    if (file->part == NULL || file->path == NULL) {
        return 0;
    }
    if (!MoveFileExA(file->part, file->path,
                     MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH)) {
        const int code = lum_outfile_code(GetLastError());
        return code == EBUSY
                   ? refuse_busy(file, error)
                   : lum_outfile_fail(file, code, "cannot get its name", error);
    }
    free(file->part);
    file->part = NULL;
    file->owes_name = true;
    return 0;
}

/* Its share mode keeps other writers away as the claim did. */
int lum_outfile_show(lum_outfile *file, lum_error *error)
{
    const int result = give_name(file, error);
    if (file->owes_name) {
        lum_claim_drop(&file->claim);
    }
    return result;
}

/* The system keeps the name of a file that is open. */
int lum_outfile_check(const lum_outfile *file, lum_error *error)
{
    (void)file;
    (void)error;
    return 0;
}

/* The call that renames also writes the name to the disk. */
int lum_outfile_finish(lum_outfile *file, lum_error *error)
{
    const int fd = file->fd;
    if (file->path != NULL && !FlushFileBuffers((HANDLE)_get_osfhandle(fd))) {
        return lum_outfile_fail(file, lum_outfile_code(GetLastError()),
                                "cannot write it to the disk", error);
    }
    file->fd = -1;
    if (_close(fd) != 0) {
        return lum_outfile_fail(file, errno, "cannot finish it", error);
    }
    return give_name(file, error);
}

void lum_outfile_part_drop(lum_outfile *file)
{
    if (file->fd >= 0) {
        (void)_close(file->fd);
    }
    if (file->part != NULL) {
        (void)DeleteFileA(file->part);
    }
    free(file->part);
}
