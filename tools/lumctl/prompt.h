/* The shell's prompt: lines typed at a terminal, or read from a pipe or a file,
 * without ever waiting; the caller waits, for the sensor and for input at once.
 * One at a time. */
#ifndef LUMCTL_PROMPT_H
#define LUMCTL_PROMPT_H

#include <stddef.h>

#define PROMPT_LINE_BYTES 2048u

enum prompt_event {
    PROMPT_NONE, /* no whole line yet */
    PROMPT_LINE,
    PROMPT_TOO_LONG, /* a line that does not fit was thrown away */
    PROMPT_END       /* end of the input */
};

/* Shows the first prompt where standard input is a terminal. */
void prompt_open(const char *text);

/* Takes what was typed; the last line need not end. *out lives until the next
 * call. */
enum prompt_event prompt_take(const char **out);

/* Shows it again, after a line is executed. */
void prompt_show(void);

/* Ctrl-C at a prompt: the terminal has forgotten what was typed so far. */
void prompt_forget(void);

/* On a terminal, ends the line that a key such as ^C was echoed to. */
void prompt_break(void);

/* Prints a line, and the prompt again below it. */
void prompt_above(const char *text);

/* The descriptor to wait on, or -1 where the system cannot: then look again
 * every PROMPT_LOOK_MS. */
int prompt_descriptor(void);
#define PROMPT_LOOK_MS 50

/* Bytes of standard input that are there now, 0 for none yet, -1 at the end
 * (prompt_input_*.c). */
int prompt_input_read(char *out, size_t room);

#endif
