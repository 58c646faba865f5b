#define _POSIX_C_SOURCE 200809L
#include "terminal.h"

#include <unistd.h>

bool terminal_is_foreground(FILE *stream)
{
    const int fd = fileno(stream);
    const pid_t foreground = tcgetpgrp(fd);
    return isatty(fd) == 1 && (foreground < 0 || foreground == getpgrp());
}
