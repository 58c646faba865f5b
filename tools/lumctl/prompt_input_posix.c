/* Standard input without a wait, on POSIX. */
#define _POSIX_C_SOURCE 200809L
#include "prompt_input.h"

#include <errno.h>
#include <poll.h>
#include <unistd.h>

int prompt_input_read(char *out, size_t room)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    if (poll(&input, 1, 0) <= 0) {
        return 0;
    }
    const ssize_t n = read(STDIN_FILENO, out, room);
    if (n > 0) {
        return (int)n;
    }
    return n < 0 && (errno == EINTR || errno == EAGAIN) ? 0 : -1;
}

int prompt_descriptor(void)
{
    return STDIN_FILENO;
}
