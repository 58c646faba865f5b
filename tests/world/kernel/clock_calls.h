/* Clocks, as tools ask for them. */
#ifndef WORLD_CLOCK_CALLS_H
#define WORLD_CLOCK_CALLS_H

#include "process.h"

#include <time.h>

WORLD_CALL(clock_gettime);
WORLD_CALL(clock_nanosleep);
WORLD_CALL(localtime_r);
WORLD_CALL(time);

#endif
