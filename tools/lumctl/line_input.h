/* Standard input, without waiting. */
#ifndef LUMCTL_LINE_INPUT_H
#define LUMCTL_LINE_INPUT_H

#include <stdbool.h>
#include <stddef.h>

bool line_input_is_terminal(void);

/* Whether a read would not wait. */
bool line_input_is_ready(void);

/* Bytes that are there now, 0 for none yet, -1 at the end. */
int line_input_read(char *out, size_t room);

#endif
