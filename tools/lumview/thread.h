/* Threads that signals leave alone, and what is shared between them. Where the
 * system has none, alone.c stands in place of thread.c: nobody else takes a
 * gate, and who would have a thread works in steps (feed_work()). */
#ifndef LUMVIEW_THREAD_H
#define LUMVIEW_THREAD_H

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
struct gate;

/* To be freed by gate_free(), once nobody has it; NULL without memory. */
struct gate *gate_new(void);
void gate_free(struct gate *gate); /* NULL is allowed */

void gate_take(struct gate *gate);
void gate_leave(struct gate *gate);

/* With the gate, which others have meanwhile: wait for news. False: the time is
 * over. */
bool gate_wait(struct gate *gate, int64_t wait_ns);

/* With the gate: there is news. */
void gate_tell(struct gate *gate);

#endif
