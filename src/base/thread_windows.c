/* Starts threads, and ends their writes, on Windows. */
#include "base/thread.h"

#include <windows.h>

int lum_thread_start(pthread_t *thread, void *(*run)(void *), void *argument)
{
    return pthread_create(thread, NULL, run, argument);
}

bool lum_thread_break_off(pthread_t thread)
{
    (void)CancelSynchronousIo(pthread_gethandle(thread));
    return true;
}
