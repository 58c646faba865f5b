#define _POSIX_C_SOURCE 200809L
#include "lock.h"

#include <pthread.h>
#include <stdlib.h>

struct lum_lock {
    pthread_mutex_t mutex;
};

lum_lock *lum_lock_new(void)
{
    lum_lock *lock = malloc(sizeof *lock);
    if (lock != NULL && pthread_mutex_init(&lock->mutex, NULL) != 0) {
        free(lock);
        lock = NULL;
    }
    return lock;
}

void lum_lock_free(lum_lock *lock)
{
    if (lock != NULL) {
        (void)pthread_mutex_destroy(&lock->mutex);
        free(lock);
    }
}

void lum_lock_take(lum_lock *lock)
{
    (void)pthread_mutex_lock(&lock->mutex);
}

void lum_lock_leave(lum_lock *lock)
{
    (void)pthread_mutex_unlock(&lock->mutex);
}
