/* What say.c asks the system for. */
#ifndef LUM_TOOLS_SAY_SYSTEM_H
#define LUM_TOOLS_SAY_SYSTEM_H

#include <stdbool.h>
#include <stddef.h>

#define SAY_CLOCK_BYTES 16u

/* To standard error. False: not now. gone: bytes that need not be written
 * again; if nobody reads at all, that is all of them. */
bool say_write(const char *bytes, size_t n, size_t *gone);

/* The terminal's width, from 2. */
size_t say_columns(void);

/* The local time as HH:MM:SS; "" where it is not known. */
void say_clock(char out[SAY_CLOCK_BYTES]);

#endif
