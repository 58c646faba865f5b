#define _POSIX_C_SOURCE 200809L
#include "pump.h"

#include "thread.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CHUNK_BYTES 65536u

struct pump {
    int source;
    int read_end;
    int write_end; /* the thread's, which closes it */
    int stop_read; /* readable once it is to stop */
    int stop_write;
    char path[32];
    struct thread *thread;
    char chunk[CHUNK_BYTES];
};

/* Wait until a descriptor is ready. False: it is to stop. */
static bool wait_for(const struct pump *pump, int fd, short events)
{
    struct pollfd fds[2] = {{.fd = pump->stop_read, .events = POLLIN},
                            {.fd = fd, .events = events}};
    int ready = 0;
    do {
        ready = poll(fds, 2, -1);
    } while (ready < 0 && errno == EINTR);
    return ready > 0 && fds[0].revents == 0;
}

static bool hand_on(const struct pump *pump, size_t len)
{
    size_t done = 0;
    while (done < len) {
        if (!wait_for(pump, pump->write_end, POLLOUT)) {
            return false;
        }
        const ssize_t n =
            write(pump->write_end, pump->chunk + done, len - done);
        if (n < 0 && errno != EINTR && errno != EAGAIN) {
            return false;
        }
        done += n > 0 ? (size_t)n : 0;
    }
    return true;
}

static void *run(void *argument)
{
    struct pump *pump = argument;
    bool goes_on = true;
    while (goes_on && wait_for(pump, pump->source, POLLIN)) {
        const ssize_t n = read(pump->source, pump->chunk, CHUNK_BYTES);
        goes_on = n > 0 ? hand_on(pump, (size_t)n)
                        : n < 0 && (errno == EINTR || errno == EAGAIN);
    }
    (void)close(pump->write_end);
    return NULL;
}

static void close_if(int fd)
{
    if (fd >= 0) {
        (void)close(fd);
    }
}

static void release(struct pump *pump)
{
    if (pump->source != STDIN_FILENO) {
        close_if(pump->source);
    }
    close_if(pump->read_end);
    close_if(pump->stop_read);
    close_if(pump->stop_write);
    free(pump);
}

/* Own descriptors are nobody else's: the browser that is started is not to keep
 * a pipe open. */
static int make_pipe(int *read_end, int *write_end)
{
    int fds[2];
    if (pipe(fds) != 0) {
        return -1;
    }
    *read_end = fds[0];
    *write_end = fds[1];
    return fcntl(fds[0], F_SETFD, FD_CLOEXEC) == -1 ||
                   fcntl(fds[1], F_SETFD, FD_CLOEXEC) == -1
               ? -1
               : 0;
}

static int open_all(struct pump *pump, const char *source, lum_error *error)
{
    if (strcmp(source, "-") == 0) {
        pump->source = STDIN_FILENO;
    } else {
        pump->source = open(source, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    }
    if (pump->source < 0) {
        return lum_error_set(error, "%s: cannot be opened: %s", source,
                             strerror(errno));
    }
    if (make_pipe(&pump->read_end, &pump->write_end) != 0 ||
        make_pipe(&pump->stop_read, &pump->stop_write) != 0 ||
        fcntl(pump->write_end, F_SETFL, O_NONBLOCK) == -1) {
        return lum_error_set(error, "%s: cannot make a pipe: %s", source,
                             strerror(errno));
    }
    (void)snprintf(pump->path, sizeof pump->path, "/dev/fd/%d", pump->read_end);
    return thread_start(&pump->thread, run, pump, error);
}

int pump_start(const char *source, struct pump **out, lum_error *error)
{
    struct pump *pump = calloc(1, sizeof *pump);
    if (pump == NULL) {
        return lum_error_set(error, "out of memory");
    }
    pump->source = pump->read_end = pump->write_end = -1;
    pump->stop_read = pump->stop_write = -1;
    if (open_all(pump, source, error) != 0) {
        close_if(pump->write_end);
        release(pump);
        return -1;
    }
    *out = pump;
    return 0;
}

const char *pump_path(const struct pump *pump)
{
    return pump->path;
}

void pump_stop(struct pump *pump)
{
    if (pump != NULL) {
        (void)close(pump->stop_write);
        pump->stop_write = -1;
    }
}

void pump_end(struct pump *pump)
{
    if (pump == NULL) {
        return;
    }
    if (pump->stop_write >= 0) {
        pump_stop(pump);
    }
    thread_join(pump->thread);
    release(pump);
}
