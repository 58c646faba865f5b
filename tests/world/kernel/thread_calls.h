/* Threads, as tools ask for them. */
#ifndef WORLD_THREAD_CALLS_H
#define WORLD_THREAD_CALLS_H

#include "process.h"

#include <pthread.h>

WORLD_CALL(pthread_create);
WORLD_CALL(pthread_join);
WORLD_CALL(pthread_detach);
WORLD_CALL(pthread_mutex_init);
WORLD_CALL(pthread_mutex_destroy);
WORLD_CALL(pthread_mutex_lock);
WORLD_CALL(pthread_mutex_trylock);
WORLD_CALL(pthread_mutex_unlock);
WORLD_CALL(pthread_cond_init);
WORLD_CALL(pthread_cond_destroy);
WORLD_CALL(pthread_cond_wait);
WORLD_CALL(pthread_cond_timedwait);
WORLD_CALL(pthread_cond_signal);
WORLD_CALL(pthread_cond_broadcast);

#endif
