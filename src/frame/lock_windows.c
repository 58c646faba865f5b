#include "lock.h"

#include <stdlib.h>
#include <windows.h>

struct lum_lock {
    SRWLOCK lock;
};

lum_lock *lum_lock_new(void)
{
    lum_lock *lock = malloc(sizeof *lock);
    if (lock != NULL) {
        InitializeSRWLock(&lock->lock);
    }
    return lock;
}

void lum_lock_free(lum_lock *lock)
{
    free(lock);
}

void lum_lock_take(lum_lock *lock)
{
    AcquireSRWLockExclusive(&lock->lock);
}

void lum_lock_leave(lum_lock *lock)
{
    ReleaseSRWLockExclusive(&lock->lock);
}
