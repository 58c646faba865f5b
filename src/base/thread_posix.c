/* Starts threads that get no signal, on POSIX. */
#define _POSIX_C_SOURCE 200809L
#include "base/thread.h"

#include <signal.h>

/* A thread inherits the mask of who starts it. */
int lum_thread_start(pthread_t *thread, void *(*run)(void *), void *argument)
{
    sigset_t all;
    sigset_t mine;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &mine);
    const int code = pthread_create(thread, NULL, run, argument);
    (void)pthread_sigmask(SIG_SETMASK, &mine, NULL);
    return code;
}

bool lum_thread_break_off(pthread_t thread)
{
    (void)thread;
    return false;
}
