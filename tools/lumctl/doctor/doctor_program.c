#define _GNU_SOURCE

#include "doctor_program.h"

#include "lum/base/time.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#define READ_NS INT64_C(1500000000)

static const char *const folders[] = {"/usr/sbin", "/sbin", "/usr/bin", "/bin",
                                      "/usr/local/sbin"};

bool program_find(const char *name, char path[PROGRAM_PATH_BYTES])
{
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        (void)snprintf(path, PROGRAM_PATH_BYTES, "%s/%.32s", folders[i], name);
        if (access(path, X_OK) == 0) {
            return true;
        }
    }
    return false;
}

struct program program_none(void)
{
    return (struct program){0, -1, -1};
}

/* Runs in the new process. The kernel ends it when this program is killed; this
 * program may have been killed before the kernel was asked to do so. */
static void become(pid_t parent, const int to[2], const int from[2],
                   const char *path, char *const arguments[])
{
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() == parent &&
        dup2(to[0], STDIN_FILENO) >= 0 && dup2(from[1], STDOUT_FILENO) >= 0 &&
        dup2(from[1], STDERR_FILENO) >= 0) {
        (void)execv(path, arguments);
    }
    _exit(127);
}

static void close_both(const int ends[2])
{
    (void)close(ends[0]);
    (void)close(ends[1]);
}

bool program_start(struct program *p, char *const arguments[])
{
    char path[PROGRAM_PATH_BYTES];
    int to[2];
    int from[2];
    const pid_t parent = getpid();
    if (!program_find(arguments[0], path) || pipe2(to, O_CLOEXEC) != 0) {
        return false;
    }
    if (pipe2(from, O_CLOEXEC) != 0) {
        close_both(to);
        return false;
    }
    const pid_t child = fork();
    if (child == 0) {
        become(parent, to, from, path, arguments);
    }
    if (child < 0) {
        close_both(to);
        close_both(from);
        return false;
    }
    (void)close(to[0]);
    (void)close(from[1]);
    *p = (struct program){child, to[1], from[0]};
    return true;
}

bool program_read(struct program *p, FILE *out)
{
    const int64_t end = lum_time_monotonic_ns() + READ_NS;
    char bytes[4096];
    while (lum_time_monotonic_ns() < end) {
        struct pollfd wait = {.fd = p->out, .events = POLLIN};
        if (poll(&wait, 1, 100) <= 0) {
            continue;
        }
        const ssize_t n = read(p->out, bytes, sizeof bytes);
        if (n <= 0) {
            return n == 0;
        }
        if (fwrite(bytes, 1, (size_t)n, out) != (size_t)n) {
            return false;
        }
    }
    return false;
}

/* It is killed, because we would wait for one that hangs; the kernel still
 * removes what nft owns. */
void program_end(struct program *p)
{
    if (p->process > 0) {
        (void)close(p->in);
        (void)close(p->out);
        (void)kill(p->process, SIGKILL);
        while (waitpid(p->process, NULL, 0) < 0 && errno == EINTR) {
        }
    }
    *p = program_none();
}
