#define _GNU_SOURCE /* POLLRDNORM */
#include "terminal.h"

#include "disk.h"
#include "process.h"
#include "shown.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#define LINE_BYTES 4096u /* of a line that can be typed */
#define NO_GROUP   (-1L)
#define DEVICE     0x8800u

/* Keys. */
enum {
    KEY_INTERRUPT = 3,
    KEY_END = 4,
    KEY_ERASE_LINE = 21,
    KEY_QUIT = 28,
    KEY_ERASE = 127
};

/* What one read() may take: a line, or nothing: the end of the input. */
struct typed {
    struct typed *next;
    size_t from, len;
    char bytes[LINE_BYTES];
};

struct world_terminal {
    world_terminal *next;
    world_file *file; /* that processes share; NULL: none has it open */
    shown shown;
    world_queue changed;
    struct typed *typed;
    char line[LINE_BYTES]; /* not ended yet */
    size_t len;
    unsigned columns, rows;
    long foreground;
    bool is_stopped, is_gone;
};

static world_terminal *terminals;

static int refuse(int code)
{
    errno = code;
    return -1;
}

static void *must(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

/* --- What processes do --- */

static bool is_in_background(const world_terminal *t)
{
    const world_process *self = world_process_self();
    return self != NULL && t->foreground != NO_GROUP &&
           self->group != t->foreground;
}

/* Stops the process; once it goes on, it asks again. */
static int stop_background(world_terminal *t)
{
    world_process_signal(world_process_self(), SIGTTIN);
    return world_wait(&t->changed, world_now() + WORLD_MS) == WORLD_INTERRUPTED
               ? EINTR
               : 0;
}

static ssize_t take(world_terminal *t, char *out, size_t size)
{
    struct typed *typed = t->typed;
    const size_t n = typed->len < size ? typed->len : size;
    memcpy(out, typed->bytes + typed->from, n);
    typed->from += n;
    typed->len -= n;
    if (typed->len == 0) {
        t->typed = typed->next;
        free(typed);
    }
    return (ssize_t)n;
}

static ssize_t read_terminal(world_file *file, void *out, size_t size)
{
    world_terminal *t = file->data;
    int code = 0;
    while (code == 0) {
        if (is_in_background(t)) {
            code = stop_background(t);
        } else if (t->typed != NULL) {
            return take(t, out, size);
        } else if (t->is_gone) {
            return 0;
        } else if (!world_file_waits(file)) {
            code = EAGAIN;
        } else if (world_wait(&t->changed, WORLD_NEVER) == WORLD_INTERRUPTED) {
            code = EINTR;
        }
    }
    return refuse(code);
}

static ssize_t write_terminal(world_file *file, const void *bytes, size_t size)
{
    world_terminal *t = file->data;
    while (t->is_stopped && !t->is_gone) {
        if (!world_file_waits(file)) {
            return refuse(EAGAIN);
        }
        if (world_wait(&t->changed, WORLD_NEVER) == WORLD_INTERRUPTED) {
            return refuse(EINTR);
        }
    }
    if (t->is_gone) {
        return refuse(EIO);
    }
    shown_add(&t->shown, bytes, size);
    return (ssize_t)size;
}

static short poll_terminal(world_file *file)
{
    const world_terminal *t = file->data;
    if (t->is_gone) {
        return POLLIN | POLLRDNORM | POLLOUT | POLLWRNORM | POLLERR | POLLHUP;
    }
    return (short)((t->typed != NULL ? POLLIN | POLLRDNORM : 0) |
                   (t->is_stopped ? 0 : POLLOUT | POLLWRNORM));
}

static int get_group(const world_terminal *t, pid_t *out)
{
    if (t->foreground == NO_GROUP) {
        return refuse(ENOTTY);
    }
    *out = (pid_t)t->foreground;
    return 0;
}

static int control_terminal(world_file *file, unsigned long request,
                            void *argument)
{
    world_terminal *t = file->data;
    if (t->is_gone) {
        return refuse(EIO);
    }
    switch (request) {
    case TIOCGWINSZ:
        *(struct winsize *)argument =
            (struct winsize){.ws_row = (unsigned short)t->rows,
                             .ws_col = (unsigned short)t->columns};
        return 0;
    case TIOCGPGRP:
        return get_group(t, argument);
    case TIOCSPGRP:
        t->foreground = *(const pid_t *)argument;
        return 0;
    default:
        return refuse(ENOTTY);
    }
}

static int stat_terminal(world_file *file, struct stat *out)
{
    (void)file;
    out->st_mode = S_IFCHR | S_IRUSR | S_IWUSR | S_IWGRP;
    out->st_rdev = DEVICE;
    out->st_ino = 3;
    out->st_nlink = 1;
    out->st_uid = WORLD_UID;
    out->st_blksize = 1024;
    return 0;
}

static world_file *reopen_terminal(world_file *file, int flags);

static void close_terminal(world_file *file)
{
    world_terminal *t = file->data;
    if (t->file == file) {
        t->file = NULL;
    }
}

static const world_file_kind terminal_kind = {
    .name = "terminal",
    .read = read_terminal,
    .write = write_terminal,
    .stat = stat_terminal,
    .poll = poll_terminal,
    .ioctl = control_terminal,
    .reopen = reopen_terminal,
    .close = close_terminal,
};

static world_file *open_terminal(world_terminal *t, int flags)
{
    world_file *file = world_file_new(&terminal_kind, flags, t);
    file->changed = &t->changed;
    return file;
}

static world_file *reopen_terminal(world_file *file, int flags)
{
    return open_terminal(file->data, flags);
}

/* --- What the user does --- */

world_terminal *world_terminal_new(const char *name)
{
    world_terminal *t = must(calloc(1, sizeof *t));
    shown_begin(&t->shown, name);
    t->columns = 80;
    t->rows = 24;
    t->foreground = NO_GROUP;
    t->next = terminals;
    terminals = t;
    return t;
}

world_file *world_terminal_file(world_terminal *t)
{
    if (t->file != NULL) {
        return world_file_use(t->file);
    }
    t->file = open_terminal(t, O_RDWR);
    return t->file;
}

world_terminal *world_terminal_of(const world_file *file)
{
    return file != NULL && file->kind == &terminal_kind ? file->data : NULL;
}

static void signal_foreground(const world_terminal *t, int number)
{
    for (world_process *p = world_process_first();
         p != NULL && t->foreground > 0; p = p->next) {
        if (!p->has_ended && p->group == t->foreground) {
            world_process_signal(p, number);
        }
    }
}

void world_terminal_set_size(world_terminal *t, unsigned columns, unsigned rows)
{
    t->columns = columns;
    t->rows = rows;
    signal_foreground(t, SIGWINCH);
}

void world_terminal_set_foreground(world_terminal *t, long group)
{
    t->foreground = group;
    world_wake_all(&t->changed);
}

long world_terminal_foreground(const world_terminal *t)
{
    return t->foreground;
}

static void end_line(world_terminal *t)
{
    struct typed **last = &t->typed;
    struct typed *typed = must(calloc(1, sizeof *typed));
    memcpy(typed->bytes, t->line, t->len);
    typed->len = t->len;
    t->len = 0;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = typed;
    world_wake_all(&t->changed);
}

/* What was typed but not ended is forgotten, as a signal's key does. */
static void press_signal(world_terminal *t, const char *echo, int number)
{
    shown_add(&t->shown, echo, strlen(echo));
    t->len = 0;
    WORLD_TRACE("%s in %s", echo, t->shown.name);
    signal_foreground(t, number);
}

static void press_plain(world_terminal *t, char key)
{
    if (t->len < LINE_BYTES - 1u || key == '\n') {
        shown_add(&t->shown, &key, 1);
        t->line[t->len++] = key;
    }
    if (key == '\n') {
        end_line(t);
    }
}

static void press(world_terminal *t, char key)
{
    switch (key) {
    case KEY_INTERRUPT:
        press_signal(t, "^C", SIGINT);
        break;
    case KEY_QUIT:
        press_signal(t, "^\\", SIGQUIT);
        break;
    case KEY_END:
        end_line(t);
        break;
    case KEY_ERASE_LINE:
        t->len = 0;
        break;
    case KEY_ERASE:
        t->len -= t->len > 0 ? 1u : 0u;
        break;
    default:
        press_plain(t, key);
        break;
    }
}

void world_terminal_type(world_terminal *t, const char *keys)
{
    for (; *keys != '\0'; keys++) {
        press(t, *keys);
    }
}

void world_terminal_stop(world_terminal *t, bool is_stopped)
{
    t->is_stopped = is_stopped;
    if (is_stopped) {
        world_met("fault:terminal-stops");
    }
    world_wake_all(&t->changed);
}

void world_terminal_hang_up(world_terminal *t)
{
    t->is_gone = true;
    world_met("fault:terminal-hangs-up");
    WORLD_TRACE("%s hangs up", t->shown.name);
    signal_foreground(t, SIGHUP);
    world_wake_all(&t->changed);
}

const char *world_terminal_text(const world_terminal *t, size_t *size)
{
    return shown_text(&t->shown, size);
}

world_queue *world_terminal_shown(world_terminal *t)
{
    return &t->shown.came;
}

void world_terminal_reset(void)
{
    while (terminals != NULL) {
        world_terminal *t = terminals;
        terminals = t->next;
        while (t->typed != NULL) {
            struct typed *next = t->typed->next;
            free(t->typed);
            t->typed = next;
        }
        shown_end(&t->shown);
        free(t);
    }
}
