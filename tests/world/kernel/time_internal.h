/* Time as task.c moves it. */
#ifndef WORLD_TIME_INTERNAL_H
#define WORLD_TIME_INTERNAL_H

#include <stdbool.h>
#include <stdint.h>

/* WORLD_NEVER: there is none. */
int64_t world_next_event_ns(void);

/* Forward only. */
void world_jump(int64_t to_ns);

/* Runs the first event that is due; false: none is. */
bool world_run_due(void);

void world_time_reset(void);

#endif
