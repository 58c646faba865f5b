#include "system.h"

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

long lum_system_process(void)
{
    return (long)GetCurrentProcessId();
}
