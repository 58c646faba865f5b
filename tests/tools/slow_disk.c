/* Loaded before the C library (LD_PRELOAD), for tests of live tools: a disk
 * that takes its time, and threads that cannot be had. LUM_HOLD=PATH   while
 * that file is there, fsync() does not come back, and PATH.held tells that one
 * waits; while PATH.broken is there, it fails LUM_THREADS=N   only the first N
 * threads can be started */
#define _GNU_SOURCE /* RTLD_NEXT, syscall */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define LOOK_NS 5000000L

typedef int create_thread(pthread_t *thread, const pthread_attr_t *attributes,
                          void *(*run)(void *), void *argument);

static const char *beside(const char *path, const char *after, char out[4096])
{
    (void)snprintf(out, 4096, "%s%s", path, after);
    return out;
}

/* In the place of the C library's. */
int fsync(int fd)
{
    const struct timespec look = {.tv_nsec = LOOK_NS};
    char name[4096];
    const char *hold = getenv("LUM_HOLD");
    if (hold != NULL && access(hold, F_OK) == 0) {
        const int held =
            open(beside(hold, ".held", name), O_WRONLY | O_CREAT | O_CLOEXEC,
                 S_IRUSR | S_IWUSR);
        if (held >= 0) {
            (void)close(held);
        }
        while (access(hold, F_OK) == 0) {
            (void)nanosleep(&look, NULL);
        }
    }
    if (hold != NULL && access(beside(hold, ".broken", name), F_OK) == 0) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fsync, fd);
}

/* Tools start their first threads from one. */
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes,
                   void *(*run)(void *), void *argument)
{
    static long started;
    create_thread *real = NULL;
    const char *most = getenv("LUM_THREADS");
    void *found = dlsym(RTLD_NEXT, "pthread_create");
    if (most != NULL && started++ >= strtol(most, NULL, 10)) {
        return EAGAIN;
    }
    memcpy(&real, &found, sizeof real);
    return real(thread, attributes, run, argument);
}
