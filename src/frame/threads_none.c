/* Builds without threads: nobody waits for a lock, and the caller makes all
 * points. */
#include "threads.h"

#include <stdlib.h>

struct lum_lock {
    char unused;
};

lum_lock *lum_lock_new(void)
{
    return calloc(1, sizeof(lum_lock));
}

void lum_lock_free(lum_lock *lock)
{
    free(lock);
}

void lum_lock_take(lum_lock *lock)
{
    (void)lock;
}

void lum_lock_leave(lum_lock *lock)
{
    (void)lock;
}

bool lum_line_threads_new(unsigned threads, size_t words,
                          lum_line_threads **out)
{
    (void)threads;
    (void)words;
    *out = NULL;
    return true;
}

void lum_line_threads_free(lum_line_threads *threads)
{
    (void)threads;
}

bool lum_line_threads_give(lum_line_threads *threads, const lum_line_task *task)
{
    (void)threads;
    (void)task;
    return false;
}

void lum_line_threads_settle(lum_line_threads *threads)
{
    (void)threads;
}
