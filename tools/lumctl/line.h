/* Lines typed at a prompt, or read from a file, without ever waiting: the
 * caller waits, for the sensor and for input at once. One at a time. */
#ifndef LUMCTL_LINE_H
#define LUMCTL_LINE_H

#include <stdbool.h>
#include <stddef.h>

enum line_event {
    LINE_NONE, /* no whole line yet */
    LINE_READY,
    LINE_TOO_LONG, /* one that does not fit was thrown away */
    LINE_END       /* end of the input */
};

/* history: a file to keep lines in, NULL for none. Shows the first prompt where
 * standard input is a terminal. */
void line_open(const char *prompt, const char *history);

/* Takes what was typed. *out lives until the next call. The prompt is hidden
 * while a line is executed; line_prompt() shows it again. */
enum line_event line_take(const char **out);

void line_prompt(void);

/* Forgets what was typed so far: Ctrl-C at a prompt. */
void line_forget(void);

/* On a terminal, ends the line that a key such as ^C was echoed to. */
void line_break(void);

/* Prints a line above the prompt. */
void line_above(const char *text);

/* The descriptor to wait on, or -1 where the system cannot: then look again
 * every LINE_LOOK_MS. */
int line_descriptor(void);
#define LINE_LOOK_MS 50

/* Keeps the history. */
void line_close(void);

#endif
