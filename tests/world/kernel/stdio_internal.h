/* What stdio.c and stdio_calls.c share. */
#ifndef WORLD_STDIO_INTERNAL_H
#define WORLD_STDIO_INTERNAL_H

#include "process.h"
#include "task.h"

#include <stdbool.h>
#include <stddef.h>

enum stream_mode {
    STREAM_UNKNOWN, /* by what the descriptor is, once it is used */
    STREAM_FULL,
    STREAM_LINES,
    STREAM_NONE
};

/* What a FILE is. Bytes of its buffer are either read ahead, from `at` to
 * `end`, or wait to be written: the first `used`. */
typedef struct stream {
    struct stream *next;
    int fd; /* -1: closed, or in memory */
    enum stream_mode mode;
    char *buffer; /* NULL: not made yet */
    size_t room, used, at, end;
    bool reads, writes;
    bool is_own_buffer, has_failed, is_at_end;
    const world_task *holder; /* of the lock */
    unsigned depth;
    world_queue unlocked;
    /* In memory (open_memstream). */
    bool is_memory;
    char **text; /* the caller's */
    size_t *len;
    char *memory;
    size_t memory_len, memory_room;
} stream;

struct world_stdio {
    stream *first; /* in the order of their opening, standard ones first */
    stream standard[3];
};

/* flags: as the descriptor was opened, O_ACCMODE and O_APPEND. */
stream *stream_new(int fd, int flags);
/* Takes it out of the process's list. It stays the caller's to free, unless it
 * is a standard one. */
void stream_forget(stream *s);

void stream_lock(stream *s);
void stream_unlock(stream *s);

/* How many bytes were taken: all, or fewer where a write failed. */
size_t stream_put(stream *s, const char *bytes, size_t size);
/* 0, or -1 and errno; what could not be written is forgotten, as by glibc. */
int stream_flush(stream *s);
/* Fills an empty buffer. False: at the end, or failed. */
bool stream_fill(stream *s);
/* Up to size bytes. */
size_t stream_get(stream *s, char *out, size_t size);
/* 0, or -1 and errno. */
int stream_seek(stream *s, long offset, int whence);
/* What is read ahead is given back. */
void stream_settle(stream *s);

#endif
