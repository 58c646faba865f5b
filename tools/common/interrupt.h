/* Signals that end a run: noted, and died of once all is tidy. */
#ifndef LUM_TOOLS_INTERRUPT_H
#define LUM_TOOLS_INTERRUPT_H

#include "lum/net/cancel.h"

/* Note SIGINT, SIGTERM and SIGHUP from now on, except those that the parent has
 * ignored; a write to a pipe without a reader, or beyond the largest size of a
 * file, fails with EPIPE or EFBIG instead of killing the process. After a
 * signal, waits for input and output end with EINTR repeatedly; a second
 * signal, or three seconds, end the process at once. */
void interrupt_catch(void);

/* Such writes fail from now on; signals end the process at once, as they did.
 */
void interrupt_catch_none(void);

/* From now on the program may keep a laser on: note SIGINT, SIGTERM and
 * SIGQUIT, even if the parent has ignored or blocked them, as a shell without
 * job control does with SIGINT and SIGQUIT for background commands. SIGHUP
 * stays as it was inherited, for nohup. After interrupt_catch(). */
void interrupt_insist(void);

/* A cancel that a signal raises from now on; NULL: none. Only one at a time. */
void interrupt_attach(lum_cancel *cancel);

/* The signal that came, or 0. */
int interrupt_signal(void);

/* Signals that came so far; it may wrap. */
unsigned interrupt_count(void);

/* As if no signal had come: for a prompt that continues after Ctrl-C. The
 * cancel that is attached is reset. */
void interrupt_forget(void);

/* From now on the program needs its own time to end in good order, for example
 * to switch a laser off: until interrupt_release() a signal is noted and raises
 * the cancel, but a second one or three seconds do not end the process. */
void interrupt_hold(void);

/* A cancel that a second signal raises while signals are held, for what may go
 * on for longer than a person waits. Lives as long as the program; NULL before
 * interrupt_insist() and interrupt_hold(), or if memory was short. */
const lum_cancel *interrupt_second(void);

/* What begins now looks at interrupt_count() to end early: until
 * interrupt_release() the next signal is only noted, the one after it ends the
 * process, and three seconds do not. */
void interrupt_linger(void);

/* As before interrupt_hold(); the three seconds of a signal that came in
 * between begin. */
void interrupt_release(void);

/* Die of the signal that came, as if it had never been caught. Safe in a signal
 * handler. */
void interrupt_die(void);

#endif
