/* Terminals and pipes of POSIX. */
#define _DEFAULT_SOURCE /* TIOCGWINSZ */
#define _DARWIN_C_SOURCE
#include "terminal.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

bool terminal_is_foreground(FILE *stream)
{
    const int fd = fileno(stream);
    const pid_t foreground = tcgetpgrp(fd);
    return isatty(fd) == 1 && (foreground < 0 || foreground == getpgrp());
}

size_t terminal_columns(void)
{
    struct winsize size = {0, 0, 0, 0};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1
               ? size.ws_col
               : 80u;
}

bool writable(FILE *stream, int patience_ms)
{
    struct pollfd ready = {.fd = fileno(stream), .events = POLLOUT};
    return poll(&ready, 1, patience_ms) > 0;
}
