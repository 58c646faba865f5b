#define _POSIX_C_SOURCE 200809L
#include "thread.h"

#include "base/thread.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define SECOND_NS INT64_C(1000000000)

struct thread {
    pthread_t thread;
};

struct gate {
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

/* --- Gates --- */

struct gate *gate_new(void)
{
    struct gate *gate = malloc(sizeof *gate);
    if (gate != NULL) {
        (void)pthread_mutex_init(&gate->lock, NULL);
        (void)pthread_cond_init(&gate->news, NULL);
    }
    return gate;
}

void gate_free(struct gate *gate)
{
    if (gate != NULL) {
        (void)pthread_cond_destroy(&gate->news);
        (void)pthread_mutex_destroy(&gate->lock);
        free(gate);
    }
}

void gate_take(struct gate *gate)
{
    (void)pthread_mutex_lock(&gate->lock);
}

void gate_leave(struct gate *gate)
{
    (void)pthread_mutex_unlock(&gate->lock);
}

/* Not every system can wait by the monotonic clock. */
bool gate_wait(struct gate *gate, int64_t wait_ns)
{
    struct timespec until;
    (void)clock_gettime(CLOCK_REALTIME, &until);
    wait_ns += until.tv_nsec;
    until.tv_sec += (time_t)(wait_ns / SECOND_NS);
    until.tv_nsec = (long)(wait_ns % SECOND_NS);
    return pthread_cond_timedwait(&gate->news, &gate->lock, &until) == 0;
}

void gate_tell(struct gate *gate)
{
    (void)pthread_cond_broadcast(&gate->news);
}
