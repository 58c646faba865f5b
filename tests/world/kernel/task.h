/* Tasks: threads of the world's processes, and the user. All of them run in one
 * thread of the system, one at a time, and change only where they call the
 * world: so a seed decides the order, and nothing else does. */
#ifndef WORLD_TASK_H
#define WORLD_TASK_H

#include "process.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct world_task world_task;

/* Queues that one wait can name: more than any tool polls. */
#define WORLD_WAITS 64

/* Where tasks wait. Zeroed memory is an empty one. */
typedef struct world_queue {
    struct world_waiter *first, *last;
} world_queue;

typedef enum world_wake {
    WORLD_WOKEN,
    WORLD_TIMED_OUT,
    WORLD_INTERRUPTED /* a handler of a signal has run: EINTR */
} world_wake;

/* A new task, ready to run. process: NULL for the user. */
world_task *world_task_begin(world_process *process,
                             void *(*run)(void *argument), void *argument);

/* The one that runs; NULL in an event. */
world_task *world_task_self(void);
world_process *world_task_process(const world_task *task);

/* Calls that wait, give way or end a task are of a task alone; in an event they
 * abort, because there is no task that could go on later. */

/* The task that runs waits on one or several queues, until one of them is
 * woken, until a moment (true time, WORLD_NEVER: none), or a signal's handler
 * has run. Whoever calls it looks again at what it waits for: a wake says
 * nothing. */
world_wake world_wait(world_queue *queue, int64_t until_ns);
world_wake world_wait_any(world_queue *const *queues, unsigned count,
                          int64_t until_ns);
/* As world_wait(), but no signal ends it. */
void world_wait_deaf(world_queue *queue, int64_t until_ns);

/* All that wait, or one of them (chosen by the seed). */
void world_wake_all(world_queue *queue);
void world_wake_one(world_queue *queue);

/* At the beginning of each call of a process: the call costs time, signals are
 * delivered, and another task may go first. Does not return if a signal ends
 * the process. The name of the call is that of the function that says this. */
#define world_call(cost_ns) world_call_of(__func__, cost_ns)
void world_call_of(const char *name, int64_t cost_ns);

/* Called at each call of a process before anything else, so that something can
 * be made to happen at the n-th call of a name. NULL: nothing. It must not
 * wait. */
extern void (*world_hook)(world_process *process, const char *name);

/* Gives way: another task may run first. */
void world_yield(void);

/* The task that runs ends, with the result for whoever joins it. */
__attribute__((noreturn)) void world_task_end(void *result);
/* Waits for a task, and takes its result. Once for each task. */
void *world_task_join(world_task *task);
/* Tasks of a process end without another step; that of the caller, if it is of
 * the process, is left for it to end. */
void world_task_drop_others(world_process *process);
/* A waiting task looks whether a signal has come for it. */
void world_task_interrupt(world_task *task);
/* The tasks of a process, in the order of their beginning; NULL after the last.
 */
world_task *world_task_next(const world_process *process,
                            const world_task *after);
/* Numbers of tasks count from 1 in the order of their beginning. */
unsigned world_task_number(const world_task *task);

/* What signals.c and process.c are asked for: run the handlers of signals that
 * are due to the task that runs (true: one that ends waits has run), and make
 * the static data of a process present. */
extern bool (*world_task_deliver)(void);
extern void (*world_task_present)(world_process *process);

/* Runs everything until the user's task has ended, or nothing can happen any
 * more (false: a deadlock), or until a moment of true time (false). */
bool world_run(world_task *user, int64_t until_ns);

#endif
