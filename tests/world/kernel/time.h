/* True time of the world, and what happens at moments of it. Nothing here
 * waits: when no task can go on, time jumps to the next event. */
#ifndef WORLD_TIME_H
#define WORLD_TIME_H

#include <stdbool.h>
#include <stdint.h>

#define WORLD_US    INT64_C(1000)
#define WORLD_MS    INT64_C(1000000)
#define WORLD_S     INT64_C(1000000000)
#define WORLD_NEVER INT64_MAX

typedef struct world_event world_event;

/* True time since the world began, ns. */
int64_t world_now(void);

/* The task that runs uses up time; events that fall into it happen when the
 * task next gives way. */
void world_spend(int64_t ns);

/* run(argument) at a moment, not in a task: it must not block. Events of one
 * moment happen in the order of the calls. A moment that has passed is now.
 * The event is valid until it has run or was cancelled. */
world_event *world_at(int64_t when_ns, void (*run)(void *argument),
                      void *argument);
void world_cancel_event(world_event *event);

#endif
