/* Whether a reader keeps up: a program that has to send in time must not wait
 * for one that stopped reading. */
#ifndef LUM_TOOLS_WRITABLE_H
#define LUM_TOOLS_WRITABLE_H

#include <stdbool.h>
#include <stdio.h>

/* What a stream that is writable takes without a wait. */
#define WRITABLE_BYTES 512u

/* Whether a short text can be written now, or within a patience. A reader that
 * has left counts as one that reads: the write will show it. If the system
 * cannot say, it is true. */
bool writable(FILE *stream, int patience_ms);

#endif
