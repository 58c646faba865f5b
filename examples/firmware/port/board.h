/* Between the startup code and the semihosting of a board. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* One request to the host: an instruction of the architecture. */
long board_call(long operation, const void *arguments);

/* Fills variables, asks the host for the command line, runs main(), exits. The
 * startup code ends with it. */
void board_run(void);

/* An unexpected exception: reports to the host and exits. */
void board_fault(void);

#endif
