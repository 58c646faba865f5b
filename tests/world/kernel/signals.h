/* Masks of signals, for calls that have one of their own. Needs POSIX. */
#ifndef WORLD_SIGNALS_H
#define WORLD_SIGNALS_H

#include <signal.h>

/* The mask of the task that runs becomes another one, as for ppoll(), which
 * puts the old one back after its wait. Waits and calls deliver what it lets
 * through. old may be NULL. */
void world_signal_mask(const sigset_t *mask, sigset_t *old);

#endif
