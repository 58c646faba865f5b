/* What tools ask the system for about themselves: memory, names, numbers. */
#ifndef WORLD_SMALL_CALLS_H
#define WORLD_SMALL_CALLS_H

#include "process.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

WORLD_CALL(malloc);
WORLD_CALL(calloc);
WORLD_CALL(realloc);
WORLD_CALL(free);
WORLD_CALL(strdup);
WORLD_CALL(strndup);
WORLD_CALL(getenv);
WORLD_CALL(getpid);
WORLD_CALL(getppid);
WORLD_CALL(getpgrp);
WORLD_CALL(geteuid);
WORLD_CALL(exit) __attribute__((noreturn));
WORLD_CALL(_exit) __attribute__((noreturn));
WORLD_CALL(abort) __attribute__((noreturn));
WORLD_CALL(prctl);
WORLD_CALL(setpriority);
WORLD_CALL(sched_getaffinity);
WORLD_CALL(fork);
WORLD_CALL(execv);
WORLD_CALL(waitpid);

#endif
