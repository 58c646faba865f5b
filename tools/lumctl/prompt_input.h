/* Standard input without a wait: the caller waits, for the sensor and for input
 * at once. */
#ifndef LUMCTL_PROMPT_INPUT_H
#define LUMCTL_PROMPT_INPUT_H

#include <stddef.h>

/* The descriptor to wait on, or -1 where the system cannot: then look again
 * every PROMPT_LOOK_MS. */
int prompt_descriptor(void);
#define PROMPT_LOOK_MS 50

/* Bytes of standard input that are there now, 0 for none yet, -1 at its end. */
int prompt_input_read(char *out, size_t room);

#endif
