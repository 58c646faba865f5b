/* A sensor on the network. */
#ifndef LUMSIM_LIVE_H
#define LUMSIM_LIVE_H

#include "options.h"

/* Be one until a signal or the duration ends it. Returns the exit status. */
int live_run(const struct options *o);

#endif
