/* A terminal: lines are typed, a group of processes is in its foreground, keys
 * send signals. */
#ifndef WORLD_TERMINAL_H
#define WORLD_TERMINAL_H

#include "file.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct world_queue;
typedef struct world_terminal world_terminal;

/* 80 columns, 24 rows, shown at once. It lives as long as the world. */
world_terminal *world_terminal_new(const char *name);

/* For a process: a use of it, for reading and writing. */
world_file *world_terminal_file(world_terminal *terminal);

/* The terminal that a file is; NULL: it is none. */
world_terminal *world_terminal_of(const world_file *file);

void world_terminal_set_size(world_terminal *terminal, unsigned columns,
                             unsigned rows);
/* 0: none, as at a shell's prompt. Until it is set, no group is in the
 * background, and keys send no signals. */
void world_terminal_set_foreground(world_terminal *terminal, long group);
long world_terminal_foreground(const world_terminal *terminal);

/* Lines go to whoever reads; a line is not read before its end. Control-C (\3)
 * and Control-\ (\34) send SIGINT and SIGQUIT to the foreground, Control-D (\4)
 * ends a line, or the input. What is typed is shown too. */
void world_terminal_type(world_terminal *terminal, const char *keys);
/* Control-S and Control-Q: what is written waits. */
void world_terminal_stop(world_terminal *terminal, bool is_stopped);
/* The window is closed: SIGHUP to the foreground; reading ends, writing fails
 * with EIO. */
void world_terminal_hang_up(world_terminal *terminal);

/* All that was shown, with a 0 behind it; valid until more is shown. */
const char *world_terminal_text(const world_terminal *terminal, size_t *size);
/* Woken when something is shown. */
struct world_queue *world_terminal_shown(world_terminal *terminal);

void world_terminal_reset(void);

#endif
