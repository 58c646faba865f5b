#include "say_system.h"

#include <io.h>
#include <stdio.h>
#include <windows.h>

#define COLUMNS_DEFAULT 80u

bool say_write(const char *bytes, size_t n, size_t *gone)
{
    const int written = _write(_fileno(stderr), bytes, (unsigned)n);
    *gone = written < 0 ? n : (size_t)written;
    return true;
}

size_t say_columns(void)
{
    CONSOLE_SCREEN_BUFFER_INFO facts;
    if (!GetConsoleScreenBufferInfo(GetStdHandle(STD_ERROR_HANDLE), &facts)) {
        return COLUMNS_DEFAULT;
    }
    const int columns = facts.srWindow.Right - facts.srWindow.Left + 1;
    return columns > 1 ? (size_t)columns : COLUMNS_DEFAULT;
}

void say_clock(char out[SAY_CLOCK_BYTES])
{
    SYSTEMTIME now;
    GetLocalTime(&now);
    (void)snprintf(out, SAY_CLOCK_BYTES, "%02u:%02u:%02u", now.wHour,
                   now.wMinute, now.wSecond);
}
