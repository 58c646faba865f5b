#define _POSIX_C_SOURCE 200809L
#include "thread.h"

#include <signal.h>
#include <string.h>

int thread_start(pthread_t *thread, void *(*run)(void *), void *argument,
                 lum_error *error)
{
    sigset_t all;
    sigset_t mine;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &mine);
    const int code = pthread_create(thread, NULL, run, argument);
    (void)pthread_sigmask(SIG_SETMASK, &mine, NULL);
    return code == 0 ? 0
                     : lum_error_set(error, "cannot start a thread: %s",
                                     strerror(code));
}
