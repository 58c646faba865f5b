/* What a program knows of the terminal or the pipe that it prints to. */
#ifndef LUM_TOOLS_TERMINAL_H
#define LUM_TOOLS_TERMINAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* What a stream that is writable takes without a wait. */
#define WRITABLE_BYTES 512u

/* Whether a stream is a terminal, and this process in its foreground now: a
 * shell may move it at any time. Only then may a line that is painted again and
 * again be shown: in the background it would be painted over the shell's
 * prompt. A terminal that is not the one this process was started at has no
 * shell to disturb. */
bool terminal_is_foreground(FILE *stream);

/* How wide standard error is, from 2; 80 if it is no terminal. */
size_t terminal_columns(void);

/* Whether a short text can be written now, or within a patience: a program that
 * has to send in time must not wait for a reader that stopped reading. A reader
 * that has left counts as one that reads: the write will show it. If the system
 * cannot say, it is true. */
bool writable(FILE *stream, int patience_ms);

#endif
