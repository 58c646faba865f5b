/* Whether a line that is painted again and again may be shown: a program in the
 * background would paint it over the shell's prompt. */
#ifndef LUM_TOOLS_TERMINAL_H
#define LUM_TOOLS_TERMINAL_H

#include <stdbool.h>
#include <stdio.h>

/* Whether a stream is a terminal, and this process in its foreground now: a
 * shell may move it at any time. A terminal that is not the one this process
 * was started at has no shell to disturb. */
bool terminal_is_foreground(FILE *stream);

#endif
