#include "line.h"
#include "line_input.h"
#include "line_plain.h"

#include <stdio.h>

/* A line editor is one for a process. */
static struct line_plain plain;
static const char *shown;

void line_open(const char *prompt, const char *history)
{
    (void)history;
    plain = (struct line_plain){.len = 0};
    shown = line_input_is_terminal() ? prompt : "";
    line_prompt();
}

enum line_event line_take(const char **out)
{
    return line_plain_take(&plain, out);
}

void line_prompt(void)
{
    (void)fputs(shown, stdout);
    (void)fflush(stdout);
}

void line_break(void)
{
    if (*shown != '\0') {
        (void)fputc('\n', stdout);
        (void)fflush(stdout);
    }
}

void line_forget(void)
{
    line_break();
    line_prompt();
}

void line_above(const char *text)
{
    line_break();
    (void)fprintf(stdout, "%s\n", text);
    line_prompt();
}

void line_close(void)
{
}
