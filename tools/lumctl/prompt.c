#include "prompt.h"

#include "status_report.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* A terminal is one for a process. */
static struct {
    char bytes[PROMPT_LINE_BYTES]; /* read, not yet taken */
    size_t len;
    size_t taken; /* bytes of the line that was handed out */
    bool is_cut;  /* a line too long: the rest of it is thrown away */
    bool has_ended;
    const char *shown; /* empty where there is no terminal */
} p;

/* Cuts the first line off, whose end is at `end`. */
static enum prompt_event hand_out(size_t end, const char **out)
{
    p.bytes[end] = '\0';
    if (end > 0 && p.bytes[end - 1] == '\r') {
        p.bytes[end - 1] = '\0';
    }
    p.taken = end + 1;
    if (p.is_cut) {
        p.is_cut = false;
        return PROMPT_TOO_LONG;
    }
    *out = p.bytes;
    return PROMPT_LINE;
}

static void read_more(void)
{
    if (p.len == PROMPT_LINE_BYTES - 1) {
        p.is_cut = true;
        p.len = 0;
    }
    const int n =
        prompt_input_read(p.bytes + p.len, PROMPT_LINE_BYTES - 1 - p.len);
    if (n < 0) {
        p.has_ended = true;
    } else {
        p.len += (size_t)n;
    }
}

enum prompt_event prompt_take(const char **out)
{
    p.len -= p.taken;
    memmove(p.bytes, p.bytes + p.taken, p.len);
    p.taken = 0;
    const char *end = memchr(p.bytes, '\n', p.len);
    if (end == NULL && !p.has_ended) {
        read_more();
        end = memchr(p.bytes, '\n', p.len);
    }
    if (end != NULL) {
        return hand_out((size_t)(end - p.bytes), out);
    }
    if (!p.has_ended) {
        return PROMPT_NONE;
    }
    if (p.len == 0 && !p.is_cut) {
        return PROMPT_END;
    }
    const size_t rest = p.len;
    p.len++;
    return hand_out(rest, out);
}

void prompt_open(const char *text)
{
    memset(&p, 0, sizeof p);
    p.shown = report_is_terminal(stdin) ? text : "";
    prompt_show();
}

void prompt_show(void)
{
    (void)fputs(p.shown, stdout);
    (void)fflush(stdout);
}

void prompt_break(void)
{
    if (*p.shown != '\0') {
        (void)fputc('\n', stdout);
        (void)fflush(stdout);
    }
}

void prompt_forget(void)
{
    prompt_break();
    prompt_show();
}

void prompt_above(const char *text)
{
    prompt_break();
    (void)fprintf(stdout, "%s\n", text);
    prompt_show();
}
