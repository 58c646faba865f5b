/* Signals that end a run: noted, and died of once all is tidy. */
#ifndef LUM_TOOLS_INTERRUPT_H
#define LUM_TOOLS_INTERRUPT_H

/* Note SIGINT, SIGTERM and SIGHUP from now on; a write to a pipe without a
 * reader fails with EPIPE instead of killing the process. */
void interrupt_catch(void);

/* The signal that came, or 0. */
int interrupt_signal(void);

/* Die of the signal that came, as if it had never been caught. */
void interrupt_die(void);

#endif
