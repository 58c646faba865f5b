/* Signals, as tools ask for them. */
#ifndef WORLD_SIGNAL_CALLS_H
#define WORLD_SIGNAL_CALLS_H

#include "process.h"

#include <signal.h>
#include <sys/time.h>

WORLD_CALL(kill);
WORLD_CALL(pthread_sigmask);
WORLD_CALL(raise);
WORLD_CALL(setitimer);
WORLD_CALL(sigaction);
WORLD_CALL(sigprocmask);

#endif
