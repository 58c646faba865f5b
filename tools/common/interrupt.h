/* Signals that end a run: noted, and died of once all is tidy. */
#ifndef LUM_TOOLS_INTERRUPT_H
#define LUM_TOOLS_INTERRUPT_H

/* Note SIGINT, SIGTERM and SIGHUP from now on; a write to a pipe without a
 * reader fails with EPIPE instead of killing the process. After a signal, waits
 * for input and output end with EINTR again and again; a second signal, or
 * three seconds, end the process at once. */
void interrupt_catch(void);

/* The signal that came, or 0. */
int interrupt_signal(void);

/* Die of the signal that came, as if it had never been caught. Safe in a signal
 * handler. */
void interrupt_die(void);

#endif
