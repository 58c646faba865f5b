#define _GNU_SOURCE
#include "stdio_internal.h"

#include "file.h"
#include "file_calls.h"
#include "stdio_calls.h"
#include "stream.h"
#include "terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define ROOM          4096u
#define ROOM_TERMINAL 1024u

static void *must(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

/* --- Streams of a process --- */

static void append(struct world_stdio *stdio, stream *s)
{
    stream **last = &stdio->first;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = s;
}

void world_stdio_begin(world_process *process)
{
    process->stdio = must(calloc(1, sizeof *process->stdio));
    for (int fd = 0; fd < 3; fd++) {
        stream *s = &process->stdio->standard[fd];
        s->fd = fd;
        s->reads = fd == STDIN_FILENO;
        s->writes = !s->reads;
        s->mode = fd == STDERR_FILENO ? STREAM_NONE : STREAM_UNKNOWN;
        append(process->stdio, s);
    }
}

stream *stream_new(int fd, int flags)
{
    stream *s = must(calloc(1, sizeof *s));
    s->fd = fd;
    s->reads = (flags & O_ACCMODE) != O_WRONLY;
    s->writes = (flags & O_ACCMODE) != O_RDONLY;
    append(world_process_self()->stdio, s);
    return s;
}

static void free_buffer(stream *s)
{
    if (s->is_own_buffer) {
        free(s->buffer);
    }
    s->buffer = NULL;
    s->is_own_buffer = false;
}

void stream_forget(stream *s)
{
    stream **at = &world_process_self()->stdio->first;
    while (*at != s) {
        at = &(*at)->next;
    }
    *at = s->next;
    free_buffer(s);
}

void world_stdio_flush(void)
{
    for (stream *s = world_process_self()->stdio->first; s != NULL;
         s = s->next) {
        (void)stream_flush(s);
    }
}

static bool is_standard(const struct world_stdio *stdio, const stream *s)
{
    return s >= stdio->standard && s < stdio->standard + 3;
}

void world_stdio_end(world_process *process)
{
    struct world_stdio *stdio = process->stdio;
    if (stdio == NULL) {
        return;
    }
    while (stdio->first != NULL) {
        stream *s = stdio->first;
        stdio->first = s->next;
        free_buffer(s);
        if (!is_standard(stdio, s)) {
            free(s);
        }
    }
    free(stdio);
    process->stdio = NULL;
}

/* --- Locks --- */

void stream_lock(stream *s)
{
    const world_task *self = world_task_self();
    while (s->holder != NULL && s->holder != self) {
        world_wait_deaf(&s->unlocked, INT64_MAX);
    }
    s->holder = self;
    s->depth++;
}

void stream_unlock(stream *s)
{
    s->depth--;
    if (s->depth == 0) {
        s->holder = NULL;
        world_wake_one(&s->unlocked);
    }
}

/* --- Buffers --- */

static bool is_terminal(const stream *s)
{
    const world_process *self = world_process_self();
    return s->fd >= 0 && s->fd < WORLD_FDS &&
           world_terminal_of(self->fds[s->fd].file) != NULL;
}

/* A terminal is written by lines. */
static void make_buffer(stream *s)
{
    if (s->mode == STREAM_UNKNOWN) {
        s->mode = is_terminal(s) ? STREAM_LINES : STREAM_FULL;
    }
    if (s->buffer == NULL) {
        s->room = s->mode == STREAM_NONE ? 1u
                  : is_terminal(s)       ? ROOM_TERMINAL
                                         : ROOM;
        s->buffer = must(malloc(s->room));
        s->is_own_buffer = true;
    }
}

static void grow_memory(stream *s, size_t size)
{
    size_t room = s->memory_room == 0 ? 256 : s->memory_room;
    while (room <= s->memory_len + size) {
        room *= 2;
    }
    if (room != s->memory_room) {
        s->memory = must(world_realloc(s->memory, room));
        s->memory_room = room;
    }
}

static void put_memory(stream *s, const char *bytes, size_t size)
{
    grow_memory(s, size);
    memcpy(s->memory + s->memory_len, bytes, size);
    s->memory_len += size;
}

static void show_memory(stream *s)
{
    grow_memory(s, 0);
    s->memory[s->memory_len] = '\0';
    *s->text = s->memory;
    *s->len = s->memory_len;
}

/* How much of it: an error ends it, also one that only says "later". */
static size_t write_all(stream *s, const char *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        const ssize_t n = world_call_write(s->fd, bytes + done, size - done);
        if (n < 0) {
            s->has_failed = true;
            break;
        }
        done += (size_t)n;
    }
    return done;
}

int stream_flush(stream *s)
{
    if (s->is_memory) {
        show_memory(s);
        return 0;
    }
    const size_t used = s->used;
    s->used = 0;
    return used == 0 || write_all(s, s->buffer, used) == used ? 0 : -1;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Through the buffer; whole buffers go past it. */
static size_t put_full(stream *s, const char *bytes, size_t size)
{
    size_t done = least(size, s->room - s->used);
    memcpy(s->buffer + s->used, bytes, done);
    s->used += done;
    if (done == size) {
        return done;
    }
    if (stream_flush(s) != 0) {
        return done;
    }
    const size_t whole = (size - done) / s->room * s->room;
    const size_t gone = write_all(s, bytes + done, whole);
    done += gone;
    if (gone < whole) {
        return done;
    }
    memcpy(s->buffer, bytes + done, size - done);
    s->used = size - done;
    return size;
}

/* All up to the last end of a line is written. */
static size_t put_lines(stream *s, const char *bytes, size_t size)
{
    const char *end = memrchr(bytes, '\n', size);
    const size_t lines = end != NULL ? (size_t)(end - bytes) + 1u : 0;
    size_t done = 0;
    if (lines > 0) {
        done = put_full(s, bytes, lines);
        if (done < lines || stream_flush(s) != 0) {
            return done;
        }
    }
    return done + put_full(s, bytes + done, size - done);
}

/* A stream that is not for this. */
static bool refuses(stream *s, bool may)
{
    if (!may) {
        s->has_failed = true;
        errno = EBADF;
    }
    return !may;
}

size_t stream_put(stream *s, const char *bytes, size_t size)
{
    if (refuses(s, s->writes)) {
        return 0;
    }
    if (s->is_memory) {
        put_memory(s, bytes, size);
        return size;
    }
    make_buffer(s);
    stream_settle(s);
    switch (s->mode) {
    case STREAM_LINES:
        return put_lines(s, bytes, size);
    case STREAM_NONE:
        return write_all(s, bytes, size);
    case STREAM_UNKNOWN:
    case STREAM_FULL:
        break;
    }
    return put_full(s, bytes, size);
}

/* --- Reading --- */

/* Whoever is asked for a line has seen what was printed before. */
static void flush_output(const stream *s)
{
    stream *out = &world_process_self()->stdio->standard[STDOUT_FILENO];
    if ((s->mode == STREAM_LINES || s->mode == STREAM_NONE) &&
        out->mode == STREAM_LINES) {
        (void)stream_flush(out);
    }
}

static size_t read_some(stream *s, char *out, size_t size)
{
    flush_output(s);
    const ssize_t n = world_call_read(s->fd, out, size);
    s->has_failed = s->has_failed || n < 0;
    s->is_at_end = n == 0;
    return n > 0 ? (size_t)n : 0;
}

bool stream_fill(stream *s)
{
    if (refuses(s, s->reads)) {
        return false;
    }
    make_buffer(s);
    if (s->is_at_end || stream_flush(s) != 0) {
        return false;
    }
    s->at = 0;
    s->end = read_some(s, s->buffer, s->room);
    return s->end > 0;
}

/* What is large goes past the buffer. */
size_t stream_get(stream *s, char *out, size_t size)
{
    size_t done = 0;
    if (refuses(s, s->reads)) {
        return 0;
    }
    make_buffer(s);
    while (done < size) {
        const size_t ahead = least(s->end - s->at, size - done);
        memcpy(out + done, s->buffer + s->at, ahead);
        s->at += ahead;
        done += ahead;
        if (size - done >= s->room && !s->is_at_end && stream_flush(s) == 0) {
            const size_t whole = (size - done) / s->room * s->room;
            const size_t n = read_some(s, out + done, whole);
            if (n == 0) {
                break;
            }
            done += n;
        } else if (done < size && !stream_fill(s)) {
            break;
        }
    }
    return done;
}

void stream_settle(stream *s)
{
    if (s->end > s->at && s->fd >= 0) {
        const int code = errno;
        (void)world_call_lseek64(s->fd, -(int64_t)(s->end - s->at), SEEK_CUR);
        errno = code;
    }
    s->at = s->end = 0;
}

int stream_seek(stream *s, long offset, int whence)
{
    if (stream_flush(s) != 0) {
        return -1;
    }
    stream_settle(s);
    s->is_at_end = false;
    return world_call_lseek64(s->fd, offset, whence) < 0 ? -1 : 0;
}
