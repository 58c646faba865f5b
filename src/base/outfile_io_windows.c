/* Writes bytes to an output, on Windows. */
#include "outfile_io.h"
#include "outfile_parts.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <limits.h>
#include <windows.h>

/* Bytes of one WriteFile(): a slow reader blocks it only for the time that he
 * needs for this many. */
#define PIPE_BYTES 4096u

int lum_outfile_wait(const lum_outfile *file, int patience_ms)
{
    (void)file;
    (void)patience_ms;
    return 1;
}

void lum_outfile_never_wait(lum_outfile *file)
{
    (void)file;
}

int lum_outfile_code(unsigned long error)
{
    switch (error) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
        return ENOENT;
    case ERROR_ACCESS_DENIED:
    case ERROR_WRITE_PROTECT:
        return EACCES;
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
        return EBUSY;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS:
        return EEXIST;
    case ERROR_BROKEN_PIPE:
    case ERROR_NO_DATA:
    case ERROR_PIPE_NOT_CONNECTED:
        return EPIPE;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
        return ENOSPC;
    case ERROR_INVALID_NAME:
    case ERROR_BAD_PATHNAME:
        return EINVAL;
    case ERROR_OPERATION_ABORTED:
        return 0;
    default:
        return EIO;
    }
}

int lum_outfile_put(lum_outfile *file, const void *bytes, size_t n,
                    size_t *written)
{
    const HANDLE handle = (HANDLE)_get_osfhandle(file->fd);
    const size_t most = file->may_block && n > PIPE_BYTES ? PIPE_BYTES : n;
    DWORD done = 0;
    const BOOL is_good = WriteFile(
        handle, bytes, (DWORD)(most < INT_MAX ? most : INT_MAX), &done, NULL);
    *written = done;
    return is_good ? 0 : lum_outfile_code(GetLastError());
}

int lum_outfile_put_at(lum_outfile *file, uint64_t offset, const void *bytes,
                       size_t n)
{
    const char *from = bytes;
    int code = 0;
    if (_lseeki64(file->fd, file->base + (int64_t)offset, SEEK_SET) < 0) {
        return errno;
    }
    while (n > 0 && code == 0) {
        size_t written = 0;
        code = lum_outfile_put(file, from, n, &written);
        from += written;
        n -= written;
    }
    if (_lseeki64(file->fd, 0, SEEK_END) < 0 && code == 0) {
        code = errno;
    }
    return code;
}

/* The system starts writing by itself. */
void lum_outfile_wrote(lum_outfile *file, size_t n)
{
    (void)file;
    (void)n;
}

bool lum_outfile_is_unread(const lum_outfile *file)
{
    (void)file;
    return false;
}

int lum_outfile_copy(const lum_outfile *file)
{
    return file->path != NULL ? _dup(file->fd) : -1;
}

int lum_outfile_sync_copy(int copy)
{
    const BOOL is_done = FlushFileBuffers((HANDLE)_get_osfhandle(copy));
    const int code = is_done ? 0 : lum_outfile_code(GetLastError());
    (void)_close(copy);
    return code;
}

FILE *lum_outfile_stream(const lum_outfile *file)
{
    const int fd = _dup(file->fd);
    FILE *stream = fd >= 0 ? _fdopen(fd, "wb") : NULL;
    if (stream == NULL && fd >= 0) {
        const int code = errno;
        (void)_close(fd);
        errno = code;
    }
    return stream;
}

void lum_outfile_turn_away(FILE *stream)
{
    const int nowhere = _open("NUL", _O_WRONLY | _O_BINARY | _O_NOINHERIT);
    if (nowhere >= 0) {
        (void)_dup2(nowhere, _fileno(stream));
        (void)_close(nowhere);
    }
}
