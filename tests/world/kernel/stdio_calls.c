#define _GNU_SOURCE
#include "stdio_calls.h"

#include "disk_calls.h"
#include "file_calls.h"
#include "process.h"
#include "stdio_internal.h"
#include "task.h"
#include "time.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CALL_NS 100

/* Standard streams have the same name in all processes: that of a marker. */
static stream markers[3];
FILE *world_call_stdin = (FILE *)(void *)&markers[STDIN_FILENO];
FILE *world_call_stdout = (FILE *)(void *)&markers[STDOUT_FILENO];
FILE *world_call_stderr = (FILE *)(void *)&markers[STDERR_FILENO];

static stream *of(FILE *file)
{
    stream *s = (stream *)(void *)file;
    return s >= markers && s < markers + 3
               ? &world_process_self()->stdio->standard[s - markers]
               : s;
}

static FILE *show(stream *s)
{
    return (FILE *)(void *)s;
}

/* --- Opening and closing --- */

/* The flags of open() that a mode means; -1: none. */
static int flags_of(const char *mode)
{
    const bool both = strchr(mode, '+') != NULL;
    const int access = both ? O_RDWR : mode[0] == 'r' ? O_RDONLY : O_WRONLY;
    const int more = (strchr(mode, 'e') != NULL ? O_CLOEXEC : 0) |
                     (strchr(mode, 'x') != NULL ? O_EXCL : 0);
    switch (mode[0]) {
    case 'r':
        return access | more;
    case 'w':
        return access | more | O_CREAT | O_TRUNC;
    case 'a':
        return access | more | O_CREAT | O_APPEND;
    default:
        errno = EINVAL;
        return -1;
    }
}

FILE *world_call_fopen64(const char *path, const char *mode)
{
    const mode_t everyone = 0666;
    const int flags = flags_of(mode);
    const int fd = flags >= 0 ? world_call_open64(path, flags, everyone) : -1;
    if (fd >= 0 && (flags & O_APPEND) != 0) {
        (void)world_call_lseek64(fd, 0, SEEK_END);
    }
    return fd >= 0 ? show(stream_new(fd, flags)) : NULL;
}

FILE *world_call_fdopen(int fd, const char *mode)
{
    const int wanted = flags_of(mode);
    const int has = wanted >= 0 ? world_call_fcntl64(fd, F_GETFL) : -1;
    if (has < 0) {
        return NULL;
    }
    if ((has & O_ACCMODE) != O_RDWR &&
        (has & O_ACCMODE) != (wanted & O_ACCMODE)) {
        errno = EINVAL;
        return NULL;
    }
    return show(stream_new(fd, wanted));
}

FILE *world_call_tmpfile64(void)
{
    const int fd = world_call_tmpfile_fd();
    return fd >= 0 ? show(stream_new(fd, O_RDWR)) : NULL;
}

FILE *world_call_open_memstream(char **text, size_t *len)
{
    world_call(CALL_NS);
    stream *s = stream_new(-1, O_WRONLY);
    s->is_memory = true;
    s->text = text;
    s->len = len;
    (void)stream_flush(s);
    return show(s);
}

/* A standard stream's memory is the process's. */
static void release(stream *s)
{
    const struct world_stdio *stdio = world_process_self()->stdio;
    const bool is_standard = s >= stdio->standard && s < stdio->standard + 3;
    stream_forget(s);
    s->fd = -1;
    if (!is_standard) {
        free(s);
    }
}

int world_call_fclose(FILE *file)
{
    stream *s = of(file);
    world_call(CALL_NS);
    stream_lock(s);
    int result = stream_flush(s);
    int code = errno;
    if (s->fd >= 0) {
        stream_settle(s);
        if (world_call_close(s->fd) != 0 && result == 0) {
            result = -1;
            code = errno;
        }
    }
    stream_unlock(s);
    release(s);
    errno = code;
    return result == 0 ? 0 : EOF;
}

static int flush_locked(stream *s)
{
    stream_lock(s);
    const int result = stream_flush(s);
    stream_unlock(s);
    return result == 0 ? 0 : EOF;
}

static int flush_each(void)
{
    int result = 0;
    for (stream *s = world_process_self()->stdio->first; s != NULL;
         s = s->next) {
        result = flush_locked(s) == 0 ? result : EOF;
    }
    return result;
}

int world_call_fflush(FILE *file)
{
    world_call(CALL_NS);
    return file != NULL ? flush_locked(of(file)) : flush_each();
}

/* --- What they are --- */

/* Only before the first use, as the standard asks. */
int world_call_setvbuf(FILE *file, char *buffer, int mode, size_t size)
{
    stream *s = of(file);
    world_call(CALL_NS);
    if (mode != _IOFBF && mode != _IOLBF && mode != _IONBF) {
        return -1;
    }
    s->mode = mode == _IOFBF   ? STREAM_FULL
              : mode == _IOLBF ? STREAM_LINES
                               : STREAM_NONE;
    if (mode != _IONBF && buffer != NULL && size > 0 && s->buffer == NULL) {
        s->buffer = buffer;
        s->room = size;
    }
    return 0;
}

int world_call_fileno(FILE *file)
{
    const int fd = of(file)->fd;
    if (fd < 0) {
        errno = EBADF;
    }
    return fd;
}

int world_call_ferror(FILE *file)
{
    return of(file)->has_failed ? 1 : 0;
}

int world_call_feof(FILE *file)
{
    return of(file)->is_at_end ? 1 : 0;
}

void world_call_clearerr(FILE *file)
{
    of(file)->has_failed = false;
    of(file)->is_at_end = false;
}

int world_call_fseek(FILE *file, long offset, int whence)
{
    stream *s = of(file);
    world_call(CALL_NS);
    stream_lock(s);
    const int result = stream_seek(s, offset, whence);
    stream_unlock(s);
    return result;
}

void world_call_rewind(FILE *file)
{
    (void)world_call_fseek(file, 0, SEEK_SET);
    of(file)->has_failed = false;
}

long world_call_ftell(FILE *file)
{
    const stream *s = of(file);
    const int64_t at = world_call_lseek64(s->fd, 0, SEEK_CUR);
    return at < 0 ? -1
                  : (long)(at - (int64_t)(s->end - s->at) + (int64_t)s->used);
}

/* --- Writing --- */

static size_t put_locked(FILE *file, const char *bytes, size_t size)
{
    stream *s = of(file);
    stream_lock(s);
    const size_t done = stream_put(s, bytes, size);
    stream_unlock(s);
    return done;
}

size_t world_call_fwrite(const void *bytes, size_t size, size_t count,
                         FILE *file)
{
    world_call(CALL_NS);
    const size_t done =
        size * count > 0 ? put_locked(file, bytes, size * count) : 0;
    return size > 0 ? done / size : 0;
}

int world_call_fputs(const char *text, FILE *file)
{
    const size_t len = strlen(text);
    world_call(CALL_NS);
    return put_locked(file, text, len) == len ? 1 : EOF;
}

/* The text and its end come together. */
int world_call_puts(const char *text)
{
    const size_t len = strlen(text);
    stream *s = of(world_call_stdout);
    world_call(CALL_NS);
    stream_lock(s);
    const bool is_done =
        stream_put(s, text, len) == len && stream_put(s, "\n", 1) == 1;
    stream_unlock(s);
    return is_done ? (int)len + 1 : EOF;
}

int world_call_fputc(int c, FILE *file)
{
    const char byte = (char)c;
    world_call(CALL_NS);
    return put_locked(file, &byte, 1) == 1 ? (unsigned char)c : EOF;
}

int world_call_putc(int c, FILE *file)
{
    return world_call_fputc(c, file);
}

int world_call_putchar(int c)
{
    return world_call_fputc(c, world_call_stdout);
}

/* Also where nothing is buffered, it is one write. */
int world_call_vfprintf(FILE *file, const char *format, va_list arguments)
{
    char few[1024];
    char *text = few;
    va_list again;
    world_call(CALL_NS);
    va_copy(again, arguments);
    const int n = vsnprintf(few, sizeof few, format, arguments);
    if (n >= (int)sizeof few) {
        text = world_malloc((size_t)n + 1u);
        if (text == NULL) {
            abort();
        }
        (void)vsnprintf(text, (size_t)n + 1u, format, again);
    }
    va_end(again);
    const bool is_done =
        n >= 0 && put_locked(file, text, (size_t)n) == (size_t)n;
    if (text != few) {
        const int code = errno;
        world_free(text);
        errno = code;
    }
    return is_done ? n : -1;
}

int world_call_fprintf(FILE *file, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int n = world_call_vfprintf(file, format, arguments);
    va_end(arguments);
    return n;
}

int world_call_printf(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int n = world_call_vfprintf(world_call_stdout, format, arguments);
    va_end(arguments);
    return n;
}

void world_call_perror(const char *text)
{
    const char *why = strerror(errno);
    const bool has_text = text != NULL && *text != '\0';
    (void)world_call_fprintf(world_call_stderr, "%s%s%s\n",
                             has_text ? text : "", has_text ? ": " : "", why);
}

/* --- Reading --- */

size_t world_call_fread(void *out, size_t size, size_t count, FILE *file)
{
    stream *s = of(file);
    world_call(CALL_NS);
    if (size * count == 0) {
        return 0;
    }
    stream_lock(s);
    const size_t done = stream_get(s, out, size * count);
    stream_unlock(s);
    return done / size;
}

static int get_byte(stream *s)
{
    if (s->at == s->end && !stream_fill(s)) {
        return EOF;
    }
    return (unsigned char)s->buffer[s->at++];
}

/* As glibc: what came before an error is lost with it. */
char *world_call_fgets(char *out, int room, FILE *file)
{
    stream *s = of(file);
    int n = 0;
    int c = 0;
    world_call(CALL_NS);
    stream_lock(s);
    const bool had_failed = s->has_failed;
    s->has_failed = false;
    while (n + 1 < room && c != '\n' && (c = get_byte(s)) != EOF) {
        out[n++] = (char)c;
    }
    const bool fails = s->has_failed && errno != EAGAIN;
    s->has_failed = s->has_failed || had_failed;
    stream_unlock(s);
    if (n == 0 || fails) {
        return NULL;
    }
    out[n] = '\0';
    return out;
}

int world_call_fgetc(FILE *file)
{
    stream *s = of(file);
    world_call(CALL_NS);
    stream_lock(s);
    const int c = get_byte(s);
    stream_unlock(s);
    return c;
}

int world_call_getc(FILE *file)
{
    return world_call_fgetc(file);
}
