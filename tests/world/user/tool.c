#define _GNU_SOURCE
#include "internal.h"

#include "kernel/trace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#define LINE_MAX_BYTES 4096

/* Something that waits for the n-th call of a tool. */
typedef struct cue {
    struct cue *next;
    user_tool *tool;
    const char *call; /* NULL: any */
    unsigned left;
    int number; /* 0: run() */
    void (*run)(void *argument);
    void *argument;
} cue;

static struct {
    user_tool *first, *last;
    cue *cues;
} tools;

/* --- what tools print --- */

typedef struct kept_file {
    user_text *text;
    size_t told; /* bytes whose lines were told */
    void (*line)(void *argument, const char *line);
    void *argument;
} kept_file;

static void tell_lines(kept_file *kept)
{
    const char *from = kept->text->bytes + kept->told;
    const char *end = NULL;
    while ((end = strchr(from, '\n')) != NULL) {
        const size_t size = (size_t)(end - from);
        if (world_traces) {
            world_trace("says: %.*s", (int)(size < 300 ? size : 300), from);
        }
        if (kept->line != NULL) {
            kept->line(kept->argument, user_keep_text(from, size));
        }
        kept->told += size + 1;
        from = end + 1;
    }
}

static ssize_t keep(world_file *file, const void *bytes, size_t size)
{
    kept_file *kept = file->data;
    user_text_add(kept->text, bytes, size);
    if (kept->line != NULL || world_traces) {
        tell_lines(kept);
    }
    if (user_prints != NULL) {
        user_prints(kept->text);
    }
    user_has_changed();
    return (ssize_t)size;
}

/* A pipe whose reader is always in time. */
static int stat_kept(world_file *file, struct stat *out)
{
    memset(out, 0, sizeof *out);
    out->st_mode = S_IFIFO | 0600;
    out->st_ino = file->number;
    out->st_nlink = 1;
    return 0;
}

static short poll_kept(world_file *file)
{
    (void)file;
    return POLLOUT;
}

static void close_kept(world_file *file)
{
    (void)file;
}

static const world_file_kind kept_kind = {.name = "pipe",
                                          .write = keep,
                                          .stat = stat_kept,
                                          .poll = poll_kept,
                                          .close = close_kept};

world_file *user_kept_file(user_text *text,
                           void (*line)(void *argument, const char *line),
                           void *argument)
{
    kept_file *kept = user_keep(sizeof *kept);
    *kept = (kept_file){.text = text, .line = line, .argument = argument};
    return world_file_new(&kept_kind, O_WRONLY, kept);
}

/* --- starting --- */

const char *const user_environment[] = {"HOME=" USER_HOME,
                                        "XDG_STATE_HOME=/state", NULL};

user_tool *user_tool_first(void)
{
    return tools.first;
}

user_tool *user_tool_begin(world_start *start, const char *command)
{
    user_tool *tool = user_keep(sizeof *tool);
    size_t count = 0;
    const char **words = user_words(command, &count);
    if (count == 0) {
        user_fail(USER_HERE, "no tool is named");
    }
    tool->command = command;
    start->program = words[0];
    start->arguments = words + 1;
    tool->process = world_process_start(start);
    if (tool->process == NULL) {
        user_fail(USER_HERE, "%s cannot be started", words[0]);
    }
    if (tools.last != NULL) {
        tools.last->next = tool;
    } else {
        tools.first = tool;
    }
    tools.last = tool;
    return tool;
}

static const char *format_command(const char *format, va_list arguments)
{
    char text[4096];
    const int size = vsnprintf(text, sizeof text, format, arguments);
    if (size < 0 || (size_t)size >= sizeof text) {
        user_fail(USER_HERE, "a command of %d bytes is too long", size);
    }
    return user_keep_text(text, (size_t)size);
}

/* What was said, the terminal, or what keeps a text; NULL: /dev/null. */
static world_file *stream(world_file *said, const user_with *with,
                          user_text *text)
{
    if (said != NULL) {
        return said;
    }
    if (with->terminal != NULL) {
        return world_terminal_file(with->terminal);
    }
    return text != NULL ? user_kept_file(text, NULL, NULL) : NULL;
}

static user_tool *start_as(world_host *host, const user_with *with,
                           const char *command)
{
    user_text *out = user_text_new();
    user_text *err = user_text_new();
    world_start start = {.host = host,
                         .environment = with->environment != NULL
                                            ? with->environment
                                            : user_environment,
                         .directory = with->directory,
                         .is_background = with->is_background,
                         .ignores_int = with->ignores_int,
                         .ignores = with->ignores};
    start.input = stream(with->input, with, NULL);
    start.output = stream(with->output, with, out);
    start.error = stream(with->error, with, err);
    user_tool *tool = user_tool_begin(&start, command);
    if (with->terminal != NULL && !with->is_background) {
        user_foreground(with->terminal, tool);
    } else if (with->terminal != NULL &&
               world_terminal_foreground(with->terminal) < 0) {
        world_terminal_set_foreground(with->terminal, 0); /* the shell's */
    }
    tool->out = out;
    tool->err = err;
    return tool;
}

user_tool *user_start(world_host *host, const char *format, ...)
{
    const user_with as_usual = {0};
    va_list arguments;
    va_start(arguments, format);
    const char *command = format_command(format, arguments);
    va_end(arguments);
    return start_as(host, &as_usual, command);
}

user_tool *user_start_with(world_host *host, user_with with, const char *format,
                           ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *command = format_command(format, arguments);
    va_end(arguments);
    return start_as(host, &with, command);
}

user_tool *user_run(world_host *host, const char *format, ...)
{
    const user_with as_usual = {0};
    va_list arguments;
    va_start(arguments, format);
    const char *command = format_command(format, arguments);
    va_end(arguments);
    user_tool *tool = start_as(host, &as_usual, command);
    (void)user_wait(tool);
    return tool;
}

static void note_typed(const user_tool *tool, const char *text)
{
    user_trace("types %s", text);
    if (user_types != NULL) {
        user_types(tool, text);
    }
}

void user_type(const user_tool *tool, world_writer *keys, const char *text)
{
    note_typed(tool, text);
    world_writer_say(keys, text);
}

void user_type_at(const user_tool *tool, world_terminal *terminal,
                  const char *text)
{
    note_typed(tool, text);
    world_terminal_type(terminal, text);
}

/* --- looking --- */

const char *user_out(const user_tool *tool)
{
    return tool->out->bytes;
}

const char *user_err(const user_tool *tool)
{
    return tool->err->bytes;
}

size_t user_size_out(const user_tool *tool)
{
    return tool->out->size;
}

bool user_ended(const user_tool *tool)
{
    return tool->process->has_ended;
}

static int status_of(const user_tool *tool)
{
    const int status = tool->process->status;
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

int user_wait(user_tool *tool)
{
    if (!world_process_wait(tool->process, user_limit_ns())) {
        user_fail(USER_HERE, "%s does not end", tool->command);
    }
    return status_of(tool);
}

void user_signal(user_tool *tool, int number)
{
    user_trace("sends %s[%ld] signal %d (%s)", tool->process->name,
               tool->process->pid, number, strsignal(number));
    if (tool->signal_count < USER_SIGNALS) {
        tool->signals[tool->signal_count].t_ns = world_now();
        tool->signals[tool->signal_count++].number = number;
    }
    if (!tool->process->has_ended) {
        world_process_signal(tool->process, number);
    }
}

int user_end(user_tool *tool, int number)
{
    user_signal(tool, number);
    return user_wait(tool);
}

void user_check_status(user_place at, user_tool *tool, int status)
{
    const int got = user_wait(tool);
    if (got != status) {
        user_fail(at, "%s ended with %d and not %d; it said '%.200s'",
                  tool->command, got, status, user_err(tool));
    }
}

/* The last words of a text. */
static const char *last_words(const char *text, size_t most)
{
    const size_t size = strlen(text);
    return size > most ? text + size - most : text;
}

void user_tell_tools(char *out, size_t room)
{
    size_t used = 0;
    out[0] = '\0';
    for (const user_tool *t = tools.first; t != NULL; t = t->next) {
        if (t->err->size > 0 && used < room &&
            (t->next == NULL || !t->process->has_ended)) {
            used += (size_t)snprintf(out + used, room - used, "\n  %s[%ld]: %s",
                                     t->process->name, t->process->pid,
                                     last_words(t->err->bytes, 200));
        }
    }
}

/* --- calls of tools --- */

static void add_cue(cue made)
{
    cue *c = user_keep(sizeof *c);
    *c = made;
    c->next = tools.cues;
    tools.cues = c;
}

void user_signal_at(user_tool *tool, const char *call, unsigned n, int number)
{
    add_cue((cue){.tool = tool, .call = call, .left = n, .number = number});
}

void user_at_call(user_tool *tool, const char *call, unsigned n,
                  void (*run)(void *argument), void *argument)
{
    add_cue((cue){.tool = tool,
                  .call = call,
                  .left = n,
                  .run = run,
                  .argument = argument});
}

static bool is_of(const cue *c, const world_process *process, const char *name)
{
    const char *plain = name;
    if (strncmp(plain, "world_call_", 11) == 0) {
        plain += 11;
    }
    if (c->tool->process != process || c->call == NULL) {
        return c->tool->process == process;
    }
    const size_t size = strlen(c->call);
    return strncmp(plain, c->call, size) == 0 &&
           (plain[size] == '\0' || strcmp(plain + size, "64") == 0);
}

void user_tool_calls(world_process *process, const char *name)
{
    for (cue *c = tools.cues; c != NULL; c = c->next) {
        if (c->left == 0 || !is_of(c, process, name) || --c->left > 0) {
            continue;
        }
        if (c->number != 0) {
            user_signal(c->tool, c->number);
        } else {
            c->run(c->argument);
        }
    }
}

void user_tool_reset(void)
{
    memset(&tools, 0, sizeof tools);
}
