/* Threads that signals leave alone. */
#ifndef LUMVIEW_THREAD_H
#define LUMVIEW_THREAD_H

#include "lum/base/error.h"

#include <pthread.h>

/* 0, or -1 with the reason in error. */
int thread_start(pthread_t *thread, void *(*run)(void *), void *argument,
                 lum_error *error);

#endif
