/** @file
 * Threads that do a program's work behind it. Internal. */
#ifndef LUM_BASE_THREAD_H
#define LUM_BASE_THREAD_H

#include "lum/result.h"

#include <pthread.h>
#include <stdbool.h>

/** Start a thread that no signal is delivered to, so that none breaks its
 * writes off: signals are those threads' that the caller has.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_thread_start(pthread_t *thread, void *(*run)(void *),
                                    void *argument);

/** Break off a write that a thread waits in: to be repeated until it has ended.
 * @return whether that is how it is done on this system; elsewhere a thread
 * asks before it writes (base/outfile_io.h), and looks around. */
bool lum_thread_break_off(pthread_t thread);

#endif
