/* Threads that signals leave alone, and what is shared between them. Where the
 * system has none, alone.c stands in place of thread_monitor.c: nobody else
 * takes a monitor, and who would have a thread works in steps (feed_work()). */
#ifndef LUMVIEW_THREAD_MONITOR_H
#define LUMVIEW_THREAD_MONITOR_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct thread;

/* Whether there are threads. */
bool thread_exists(void);

/* To be ended by thread_join(). 0, or -1 with the reason in error. */
int thread_start(struct thread **out, void *(*run)(void *), void *argument,
                 lum_error *error);
void thread_join(struct thread *thread); /* NULL is allowed */

/* A lock for a few assignments at a time, and news about what it guards. */
struct monitor;

/* To be freed by monitor_free(), once nobody has it; NULL without memory. */
struct monitor *monitor_new(void);
void monitor_free(struct monitor *monitor); /* NULL is allowed */

void monitor_lock(struct monitor *monitor);
void monitor_unlock(struct monitor *monitor);

/* With the monitor, which others have meanwhile: wait for news. False: the time
 * is over. */
bool monitor_wait(struct monitor *monitor, int64_t wait_ns);

/* With the monitor: there is news. */
void monitor_notify(struct monitor *monitor);

#endif
