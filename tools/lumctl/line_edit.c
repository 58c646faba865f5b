#define _POSIX_C_SOURCE 200809L
#include "ctl.h"
#include "line.h"
#include "line_input.h"
#include "line_plain.h"
#include "words.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <editline/readline.h>

#define HISTORY_LINES 1000
#define WORDS_MAX     8

/* libedit's interface knows one editor a process, and calls without a context.
 */
static struct line_plain plain;
static bool is_edited; /* else standard input is no terminal */
static const char *shown;
static const char *history_file;
static char *typed; /* a whole line, to be freed */
static enum line_event event;

static void note_line(char *text)
{
    rl_callback_handler_remove();
    event = text == NULL ? LINE_END : LINE_READY;
    free(typed);
    typed = text;
    if (text != NULL && *text != '\0') {
        (void)add_history(text);
    }
}

/* The next candidate that begins with the text; malloc'ed, as libedit wants. */
static char *next_candidate(const char *text, int state)
{
    static size_t next;
    static int count;
    static char before[LINE_BYTES];
    static char *words[WORDS_MAX];
    const char *candidate = NULL;
    if (state == 0) {
        const size_t len = strlen(rl_line_buffer) - strlen(text);
        next = 0;
        (void)snprintf(before, sizeof before, "%.*s", (int)len, rl_line_buffer);
        count = words_cut(before, words, WORDS_MAX);
    }
    if (count < 0) {
        return NULL;
    }
    do {
        candidate = count == 0 ? ctl_command_name(next)
                               : ctl_command_word(count, words, next);
        next++;
    } while (candidate != NULL && strncmp(candidate, text, strlen(text)) != 0);
    return candidate == NULL ? NULL : strdup(candidate);
}

static char **complete(const char *text, int start, int end)
{
    (void)start;
    (void)end;
    /* File names are no words of ours. */
    rl_attempted_completion_over = 1;
    return rl_completion_matches(text, next_candidate);
}

void line_open(const char *prompt, const char *history)
{
    plain = (struct line_plain){.len = 0};
    shown = prompt;
    is_edited = line_input_is_terminal();
    history_file = history;
    if (!is_edited) {
        return;
    }
    rl_readline_name = "lumctl";
    rl_catch_signals = 0;
    rl_attempted_completion_function = complete;
    using_history();
    stifle_history(HISTORY_LINES);
    if (history != NULL) {
        (void)read_history(history);
    }
    line_prompt();
}

enum line_event line_take(const char **out)
{
    if (!is_edited) {
        return line_plain_take(&plain, out);
    }
    event = LINE_NONE;
    if (line_input_is_ready()) {
        rl_callback_read_char();
    }
    *out = typed;
    return event;
}

void line_prompt(void)
{
    if (is_edited) {
        (void)fflush(stdout);
        rl_callback_handler_install(shown, note_line);
    }
}

void line_break(void)
{
    if (is_edited) {
        (void)fputc('\n', stdout);
        (void)fflush(stdout);
    }
}

void line_forget(void)
{
    if (is_edited) {
        rl_replace_line("", 0);
        line_break();
        rl_callback_handler_remove();
        line_prompt();
    }
}

void line_above(const char *text)
{
    if (!is_edited) {
        (void)printf("%s\n", text);
        (void)fflush(stdout);
        return;
    }
    (void)printf("\r\033[K%s\n", text);
    (void)fflush(stdout);
    rl_forced_update_display();
}

void line_close(void)
{
    if (is_edited) {
        rl_callback_handler_remove();
        if (history_file != NULL) {
            (void)write_history(history_file);
        }
    }
    free(typed);
    typed = NULL;
}
