#define _POSIX_C_SOURCE 200809L
#include "thread_monitor.h"

#include "base/thread.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define SECOND_NS INT64_C(1000000000)

struct thread {
    pthread_t thread;
};

struct monitor {
    pthread_mutex_t lock;
    pthread_cond_t news;
};

/* --- Threads --- */

bool thread_exists(void)
{
    return true;
}

int thread_start(struct thread **out, void *(*run)(void *), void *argument,
                 lum_error *error)
{
    struct thread *thread = malloc(sizeof *thread);
    if (thread == NULL) {
        return lum_error_set(error, "out of memory");
    }
    const int code = lum_thread_start(&thread->thread, run, argument);
    if (code != 0) {
        free(thread);
        return lum_error_set(error, "cannot start a thread: %s",
                             strerror(code));
    }
    *out = thread;
    return 0;
}

void thread_join(struct thread *thread)
{
    if (thread != NULL) {
        (void)pthread_join(thread->thread, NULL);
        free(thread);
    }
}

/* --- Monitors --- */

struct monitor *monitor_new(void)
{
    struct monitor *monitor = malloc(sizeof *monitor);
    if (monitor != NULL) {
        (void)pthread_mutex_init(&monitor->lock, NULL);
        (void)pthread_cond_init(&monitor->news, NULL);
    }
    return monitor;
}

void monitor_free(struct monitor *monitor)
{
    if (monitor != NULL) {
        (void)pthread_cond_destroy(&monitor->news);
        (void)pthread_mutex_destroy(&monitor->lock);
        free(monitor);
    }
}

void monitor_lock(struct monitor *monitor)
{
    (void)pthread_mutex_lock(&monitor->lock);
}

void monitor_unlock(struct monitor *monitor)
{
    (void)pthread_mutex_unlock(&monitor->lock);
}

/* Not every system can wait by the monotonic clock. */
bool monitor_wait(struct monitor *monitor, int64_t wait_ns)
{
    struct timespec until;
    (void)clock_gettime(CLOCK_REALTIME, &until);
    wait_ns += until.tv_nsec;
    until.tv_sec += (time_t)(wait_ns / SECOND_NS);
    until.tv_nsec = (long)(wait_ns % SECOND_NS);
    return pthread_cond_timedwait(&monitor->news, &monitor->lock, &until) == 0;
}

void monitor_notify(struct monitor *monitor)
{
    (void)pthread_cond_broadcast(&monitor->news);
}
