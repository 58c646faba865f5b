/* Files as a source reads them, on Windows. */
#define WIN32_LEAN_AND_MEAN
#include "source_file.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <windows.h>

int lum_source_file_open(const char *path)
{
    if (strcmp(path, "-") != 0) {
        return _open(path, _O_RDONLY | _O_BINARY | _O_NOINHERIT);
    }
    const int fd = _dup(0);
    if (fd >= 0) {
        (void)_setmode(fd, _O_BINARY);
    }
    return fd;
}

int64_t lum_source_file_read(int fd, void *buffer, size_t room,
                             lum_error *error)
{
    const unsigned limit = room < INT_MAX ? (unsigned)room : INT_MAX;
    const int got = _read(fd, buffer, limit);
    return got >= 0 ? got : lum_error_set(error, "%s", strerror(errno));
}

int64_t lum_source_file_read_at(int fd, uint64_t offset, void *buffer,
                                size_t room, lum_error *error)
{
    return lum_source_file_seek(fd, offset, error) == 0
               ? lum_source_file_read(fd, buffer, room, error)
               : -1;
}

/* Pipes cannot be waited for here, so they are looked at again and again. */
bool lum_source_file_wait(int fd, int ms)
{
    const HANDLE handle = (HANDLE)_get_osfhandle(fd);
    const ULONGLONG end = GetTickCount64() + (ULONGLONG)ms;
    DWORD bytes = 0;
    if (handle == INVALID_HANDLE_VALUE ||
        GetFileType(handle) != FILE_TYPE_PIPE) {
        return true;
    }
    while (PeekNamedPipe(handle, NULL, 0, NULL, &bytes, NULL) && bytes == 0) {
        if (GetTickCount64() >= end) {
            return false;
        }
        Sleep(1);
    }
    return true;
}

uint64_t lum_source_file_bytes(int fd)
{
    struct _stati64 st;
    return _fstati64(fd, &st) == 0 && (st.st_mode & _S_IFMT) == _S_IFREG
               ? (uint64_t)st.st_size
               : 0;
}

int lum_source_file_seek(int fd, uint64_t offset, lum_error *error)
{
    return offset <= INT64_MAX && _lseeki64(fd, (int64_t)offset, SEEK_SET) >= 0
               ? 0
               : lum_error_set(error, "%s", strerror(errno));
}

void lum_source_file_close(int fd)
{
    (void)_close(fd);
}
