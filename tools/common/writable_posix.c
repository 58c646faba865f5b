#define _POSIX_C_SOURCE 200809L
#include "writable.h"

#include <poll.h>

bool writable(FILE *stream, int patience_ms)
{
    struct pollfd ready = {.fd = fileno(stream), .events = POLLOUT};
    return poll(&ready, 1, patience_ms) > 0;
}
