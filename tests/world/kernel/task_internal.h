/* A new order. */
#ifndef WORLD_TASK_INTERNAL_H
#define WORLD_TASK_INTERNAL_H

/* Forgets all tasks; not from one. */
void world_task_reset(void);

#endif
