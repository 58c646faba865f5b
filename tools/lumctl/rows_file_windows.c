/* A file that several runs open, on Windows: share modes keep them apart. */
#include "rows_file.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdint.h>
#include <windows.h>

static int code_of(DWORD code)
{
    return code == ERROR_SHARING_VIOLATION ? EBUSY
           : code == ERROR_PATH_NOT_FOUND  ? ENOENT
           : code == ERROR_ACCESS_DENIED   ? EACCES
                                           : EIO;
}

int rows_file_open(const char *path, bool is_private)
{
    (void)is_private;
    const HANDLE file =
        CreateFileA(path, GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ, NULL,
                    OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        errno = code_of(GetLastError());
        return -1;
    }
    return _open_osfhandle((intptr_t)file,
                           _O_BINARY | _O_APPEND | _O_NOINHERIT);
}

int rows_file_cut(int fd, long long size)
{
    return _chsize_s(fd, size) == 0 ? 0 : -1;
}

int rows_file_put(int fd, const char *text, size_t len)
{
    while (len > 0) {
        const int n = _write(fd, text, (unsigned)len);
        if (n <= 0) {
            return -1;
        }
        text += n;
        len -= (size_t)n;
    }
    return 0;
}

int rows_file_replace(const char *from, const char *to)
{
    const bool is_done = MoveFileExA(from, to, MOVEFILE_REPLACE_EXISTING) != 0;
    errno = is_done ? errno : code_of(GetLastError());
    return is_done ? 0 : -1;
}
