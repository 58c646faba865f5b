/* A wait that another thread or a signal handler can end, on POSIX. */
#define _POSIX_C_SOURCE 200809L
#include "net/socket_system.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A pipe, which is raised while there is a byte in it: no memory is shared, so
 * that threads and signal handlers need no lock. */
struct lum_cancel {
    int read_end;
    int write_end;
};

static int make_gentle(int fd)
{
    const int flags = fcntl(fd, F_GETFL);
    if (flags < 0 || fcntl(fd, F_SETFL, flags | O_NONBLOCK) < 0) {
        return -1;
    }
    return fcntl(fd, F_SETFD, FD_CLOEXEC);
}

int lum_cancel_new(lum_cancel **out, lum_error *error)
{
    int ends[2] = {-1, -1};
    lum_cancel *cancel = malloc(sizeof *cancel);
    if (cancel == NULL) {
        return lum_error_set(error, "no memory left for a cancel");
    }
    if (pipe(ends) != 0) {
        free(cancel);
        return lum_error_set(error, "cannot make a pipe for a cancel: %s",
                             strerror(errno));
    }
    *cancel = (lum_cancel){.read_end = ends[0], .write_end = ends[1]};
    if (make_gentle(ends[0]) != 0 || make_gentle(ends[1]) != 0) {
        (void)lum_error_set(error, "cannot set up a cancel's pipe: %s",
                            strerror(errno));
        lum_cancel_free(cancel);
        return -1;
    }
    *out = cancel;
    return 0;
}

void lum_cancel_free(lum_cancel *cancel)
{
    if (cancel != NULL) {
        (void)close(cancel->read_end);
        (void)close(cancel->write_end);
        free(cancel);
    }
}

/* A pipe that is full is raised too. */
void lum_cancel_raise(lum_cancel *cancel)
{
    if (cancel != NULL) {
        const int kept = errno;
        const ssize_t written = write(cancel->write_end, "", 1);
        (void)written;
        errno = kept;
    }
}

bool lum_cancel_is_raised(const lum_cancel *cancel)
{
    if (cancel == NULL) {
        return false;
    }
    struct pollfd look = {.fd = cancel->read_end, .events = POLLIN};
    int ready = 0;
    do {
        ready = poll(&look, 1, 0);
    } while (ready < 0 && errno == EINTR);
    return ready > 0;
}

void lum_cancel_reset(lum_cancel *cancel)
{
    char bytes[256];
    ssize_t got = 0;
    do {
        got = read(cancel->read_end, bytes, sizeof bytes);
    } while (got > 0 || (got < 0 && errno == EINTR));
}

intptr_t lum_cancel_handle(const lum_cancel *cancel)
{
    return cancel->read_end;
}
