/* Consoles and pipes of Windows. */
#include "terminal.h"

#include <io.h>
#include <windows.h>

/* A console has no background. */
bool terminal_is_foreground(FILE *stream)
{
    return _isatty(_fileno(stream)) != 0;
}

size_t terminal_columns(void)
{
    CONSOLE_SCREEN_BUFFER_INFO facts;
    if (!GetConsoleScreenBufferInfo(GetStdHandle(STD_ERROR_HANDLE), &facts)) {
        return 80u;
    }
    const int columns = facts.srWindow.Right - facts.srWindow.Left + 1;
    return columns > 1 ? (size_t)columns : 80u;
}

/* Windows has no such question to a pipe or a console. */
bool writable(FILE *stream, int patience_ms)
{
    (void)stream;
    (void)patience_ms;
    return true;
}
