/* What the files about processes share. */
#ifndef WORLD_PROCESS_INTERNAL_H
#define WORLD_PROCESS_INTERNAL_H

#include "process.h"
#include "random.h"
#include "task.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A thread of a process. Sets of signals: bit N - 1 is signal N. */
typedef struct world_thread {
    struct world_thread *next; /* in the order of their beginning */
    world_process *process;
    world_task *task;
    void *(*run)(void *argument);
    void *argument;
    uint64_t mask;
    uint64_t pending; /* for this thread alone */
    bool has_ended;
} world_thread;

struct world_process_private {
    char *data; /* static data of the image, while that of another is present */
    char *own;  /* and of the kernel's WORLD_OWN */
    world_thread *threads;
    unsigned arena; /* memory.c */
    world_random chance;
    world_queue ended;
};

/* Of the task that runs; NULL for the user and in events. */
world_thread *world_thread_self(void);
/* A thread of a process, ready to run, with the mask of the one that begins it.
 */
world_thread *world_thread_begin(world_process *process,
                                 void *(*run)(void *argument), void *argument);

/* Of one that has ended. */
void world_thread_free(world_thread *thread);

/* number: of the process in this world, counted from 0. */
void world_memory_begin(world_process *process, unsigned number);
void world_memory_free(world_process *process);
void world_memory_reset(void);

void world_signals_begin(world_process *process, const world_start *start);
void world_signals_free(world_process *process);
/* What task.c asks for (world_task_deliver). */
bool world_signals_deliver(void);

/* All processes are gone. */
void world_process_reset(void);

#endif
