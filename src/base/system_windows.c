/* Small facts of Windows. */
#include "system.h"

#include <string.h>
#include <windows.h>

const char *lum_system_base(const char *path)
{
    const char *base = path;
    for (const char *p = path; *p != '\0'; p++) {
        if (*p == '/' || *p == '\\' || *p == ':') {
            base = p + 1;
        }
    }
    return base;
}

bool lum_system_free_bytes(const char *path, uint64_t *out)
{
    char directory[MAX_PATH] = ".";
    const size_t len = (size_t)(lum_system_base(path) - path);
    ULARGE_INTEGER bytes = {.QuadPart = 0};
    if (len >= sizeof directory) {
        return false;
    }
    if (len > 0) {
        memcpy(directory, path, len);
        directory[len] = '\0';
    }
    const bool is_known = GetDiskFreeSpaceExA(directory, &bytes, NULL, NULL);
    *out = bytes.QuadPart;
    return is_known;
}

long lum_system_process(void)
{
    return (long)GetCurrentProcessId();
}
