#include "same_file.h"

#include <string.h>
#include <windows.h>

/* A handle to ask, which keeps nobody away from the file. */
static bool ask_path(const char *path, BY_HANDLE_FILE_INFORMATION *out)
{
    const HANDLE file = CreateFileA(
        path, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
        OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        return false;
    }
    const bool is_known = GetFileInformationByHandle(file, out) != 0;
    (void)CloseHandle(file);
    return is_known;
}

static bool find_file(const char *path, DWORD standard,
                      BY_HANDLE_FILE_INFORMATION *out)
{
    const HANDLE stream = GetStdHandle(standard);
    return strcmp(path, "-") != 0
               ? ask_path(path, out)
               : GetFileType(stream) == FILE_TYPE_DISK &&
                     GetFileInformationByHandle(stream, out) != 0;
}

bool same_file(const char *input, const char *output)
{
    BY_HANDLE_FILE_INFORMATION i;
    BY_HANDLE_FILE_INFORMATION o;
    return find_file(input, STD_INPUT_HANDLE, &i) &&
           find_file(output, STD_OUTPUT_HANDLE, &o) &&
           i.dwVolumeSerialNumber == o.dwVolumeSerialNumber &&
           i.nFileIndexHigh == o.nFileIndexHigh &&
           i.nFileIndexLow == o.nFileIndexLow;
}
