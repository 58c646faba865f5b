#define _POSIX_C_SOURCE 200809L
#include "line_input.h"

#include "line.h"

#include <errno.h>
#include <poll.h>
#include <unistd.h>

bool line_input_is_terminal(void)
{
    return isatty(STDIN_FILENO) != 0;
}

bool line_input_is_ready(void)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    return poll(&input, 1, 0) > 0;
}

int line_input_read(char *out, size_t room)
{
    if (!line_input_is_ready()) {
        return 0;
    }
    const ssize_t n = read(STDIN_FILENO, out, room);
    if (n > 0) {
        return (int)n;
    }
    return n < 0 && (errno == EINTR || errno == EAGAIN) ? 0 : -1;
}

int line_descriptor(void)
{
    return STDIN_FILENO;
}
