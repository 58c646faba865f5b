#define _POSIX_C_SOURCE 200809L
#include "thread_calls.h"

#include "host.h"
#include "process_internal.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#define CREATE_NS (20 * WORLD_US)
#define LOCK_NS   50

/* The calendar's clock may be set while a thread waits by it: it looks again
 * this often. */
#define LOOK_NS WORLD_S

/* What a tool's pthread_mutex_t and pthread_cond_t lead to. It stands
 * elsewhere, because static data of a process is not always in its place. */
struct lock {
    world_task *owner;
    world_queue queue;
};

/* Those that were initialized without a call are all 0. */
static struct lock *lock_of(void *object)
{
    struct lock *lock = NULL;
    memcpy(&lock, object, sizeof(struct lock *));
    if (lock == NULL) {
        lock = world_calloc(1, sizeof *lock);
        memcpy(object, &lock, sizeof(struct lock *));
    }
    return lock;
}

static void init(void *object)
{
    const struct lock *none = NULL;
    memcpy(object, &none, sizeof(struct lock *));
}

static void destroy(void *object)
{
    struct lock *lock = lock_of(object);
    if (lock->owner != NULL || lock->queue.first != NULL) {
        world_fail("a mutex or a condition is destroyed that is in use");
    }
    world_free(lock);
    init(object);
}

/* --- threads --- */

int world_call_pthread_create(pthread_t *out, const pthread_attr_t *attributes,
                              void *(*run)(void *argument), void *argument)
{
    world_call(CREATE_NS);
    (void)attributes;
    const world_thread *thread =
        world_thread_begin(world_process_self(), run, argument);
    *out = (pthread_t)(uintptr_t)thread;
    WORLD_TRACE("begins a thread");
    return 0;
}

int world_call_pthread_join(pthread_t joined, void **result)
{
    world_call(CREATE_NS);
    world_thread *thread = (world_thread *)(uintptr_t)joined;
    void *returned = world_task_join(thread->task);
    world_thread_free(thread);
    if (result != NULL) {
        *result = returned;
    }
    return 0;
}

/* What is kept of it goes when the process ends. */
int world_call_pthread_detach(pthread_t thread)
{
    world_call(CREATE_NS);
    (void)thread;
    return 0;
}

/* --- mutexes --- */

int world_call_pthread_mutex_init(pthread_mutex_t *mutex,
                                  const pthread_mutexattr_t *attributes)
{
    (void)attributes;
    init(mutex);
    return 0;
}

int world_call_pthread_mutex_destroy(pthread_mutex_t *mutex)
{
    destroy(mutex);
    return 0;
}

static void take(pthread_mutex_t *mutex)
{
    struct lock *lock = lock_of(mutex);
    if (lock->owner == world_task_self()) {
        world_fail("a thread locks a mutex that it has locked");
    }
    while (lock->owner != NULL) {
        world_wait_deaf(&lock->queue, WORLD_NEVER);
    }
    lock->owner = world_task_self();
}

static void give(pthread_mutex_t *mutex)
{
    struct lock *lock = lock_of(mutex);
    if (lock->owner != world_task_self()) {
        world_fail("a thread unlocks a mutex that it has not locked");
    }
    lock->owner = NULL;
    world_wake_one(&lock->queue);
}

int world_call_pthread_mutex_lock(pthread_mutex_t *mutex)
{
    world_call(LOCK_NS);
    take(mutex);
    return 0;
}

int world_call_pthread_mutex_trylock(pthread_mutex_t *mutex)
{
    world_call(LOCK_NS);
    if (lock_of(mutex)->owner != NULL) {
        return EBUSY;
    }
    take(mutex);
    return 0;
}

int world_call_pthread_mutex_unlock(pthread_mutex_t *mutex)
{
    give(mutex);
    world_call(LOCK_NS);
    return 0;
}

/* --- conditions --- */

int world_call_pthread_cond_init(pthread_cond_t *cond,
                                 const pthread_condattr_t *attributes)
{
    (void)attributes;
    init(cond);
    return 0;
}

int world_call_pthread_cond_destroy(pthread_cond_t *cond)
{
    destroy(cond);
    return 0;
}

/* A handler of a signal may end it early, as a spurious wake. */
static world_wake wait_unlocked(pthread_cond_t *cond, pthread_mutex_t *mutex,
                                int64_t until_ns)
{
    struct lock *lock = lock_of(cond);
    give(mutex);
    const world_wake wake = world_wait(&lock->queue, until_ns);
    take(mutex);
    return wake;
}

int world_call_pthread_cond_wait(pthread_cond_t *cond, pthread_mutex_t *mutex)
{
    world_call(LOCK_NS);
    (void)wait_unlocked(cond, mutex, WORLD_NEVER);
    return 0;
}

int world_call_pthread_cond_timedwait(pthread_cond_t *cond,
                                      pthread_mutex_t *mutex,
                                      const struct timespec *until)
{
    world_call(LOCK_NS);
    const world_host *host = world_process_self()->host;
    const int64_t until_ns =
        (int64_t)until->tv_sec * WORLD_S + (int64_t)until->tv_nsec;
    world_wake wake = WORLD_TIMED_OUT;
    for (int64_t left_ns = until_ns - world_host_utc_ns(host);
         wake == WORLD_TIMED_OUT && left_ns > 0;
         left_ns = until_ns - world_host_utc_ns(host)) {
        const int64_t look_ns = left_ns < LOOK_NS ? left_ns : LOOK_NS;
        wake = wait_unlocked(
            cond, mutex,
            world_host_true_ns(host, world_host_mono_ns(host) + look_ns));
    }
    return wake == WORLD_TIMED_OUT ? ETIMEDOUT : 0;
}

int world_call_pthread_cond_signal(pthread_cond_t *cond)
{
    world_call(LOCK_NS);
    world_wake_one(&lock_of(cond)->queue);
    return 0;
}

int world_call_pthread_cond_broadcast(pthread_cond_t *cond)
{
    world_call(LOCK_NS);
    world_wake_all(&lock_of(cond)->queue);
    return 0;
}
