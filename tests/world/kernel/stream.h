/* Standard I/O of processes (FILE): stdio.c. */
#ifndef WORLD_STREAM_H
#define WORLD_STREAM_H

struct world_process;

/* Standard input, output and error of a process, before its first call. */
void world_stdio_begin(struct world_process *process);
/* What exit() does: all that is buffered is written. It may wait. Of the
 * process that runs. */
void world_stdio_flush(void);
/* Forgets what is buffered, and frees all streams; descriptors stay open. After
 * the process's tasks were dropped. */
void world_stdio_end(struct world_process *process);

#endif
