#include "yscan_draw.h"

#include <windows.h>

unsigned yscan_columns(void)
{
    CONSOLE_SCREEN_BUFFER_INFO info;
    const HANDLE console = GetStdHandle(STD_ERROR_HANDLE);
    if (GetConsoleScreenBufferInfo(console, &info) == 0) {
        return 80u;
    }
    const int columns = info.srWindow.Right - info.srWindow.Left + 1;
    return columns > 0 ? (unsigned)columns : 80u;
}
