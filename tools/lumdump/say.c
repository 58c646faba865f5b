#define _POSIX_C_SOURCE 200809L
#include "say.h"

#include "../common/terminal.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* How often a count that grows is told. */
#define AGAIN_NS INT64_C(10000000000)

static const char clear_line[] = "\r\033[K";

void say_init(struct say *say, bool quiet)
{
    *say = (struct say){.is_quiet = quiet};
}

/* Writes a piece if that needs no wait. False: nothing was written. If nobody
 * reads at all, it need not be written again. */
static bool write_piece(struct say *say, int patience_ms)
{
    const size_t n = say->pending_bytes < WRITABLE_BYTES ? say->pending_bytes
                                                         : WRITABLE_BYTES;
    if (!writable(stderr, patience_ms)) {
        return false;
    }
    const long written = (long)write(fileno(stderr), say->pending, (unsigned)n);
    if (written < 0 && (errno == EINTR || errno == EAGAIN)) {
        return false;
    }
    const size_t gone = written < 0 ? n : (size_t)written;
    say->pending_bytes -= gone;
    memmove(say->pending, say->pending + gone, say->pending_bytes);
    return true;
}

void say_flush(struct say *say)
{
    while (say->pending_bytes > 0 && write_piece(say, 0)) {
    }
}

static void append(struct say *say, const char *text)
{
    const size_t n = strlen(text);
    if (sizeof say->pending - say->pending_bytes < n) {
        say->left_out = true;
        return;
    }
    memcpy(say->pending + say->pending_bytes, text, n);
    say->pending_bytes += n;
}

bool say_is_due(struct say_count *count, uint64_t now, int64_t now_ns)
{
    if (now == count->told ||
        (count->told != 0 && now_ns - count->told_ns < AGAIN_NS)) {
        return false;
    }
    *count = (struct say_count){now, now_ns};
    return true;
}

/* A run that went to the background has the shell's prompt there now. */
static void clear_status(struct say *say)
{
    if (say->shows_status && terminal_is_foreground(stderr)) {
        append(say, clear_line);
    }
    say->shows_status = false;
}

static void append_left_out(struct say *say)
{
    if (say->left_out && say->pending_bytes == 0) {
        say->left_out = false;
        append(say, "lumdump: warning: further warnings could not be "
                    "written in time\n");
    }
}

/* The local time as HH:MM:SS; "" where it is not known. */
static void write_clock(char out[16])
{
    const time_t now = time(NULL);
    struct tm local;
    out[0] = '\0';
    if (localtime_r(&now, &local) != NULL) {
        (void)strftime(out, 16, "%H:%M:%S", &local);
    }
}

/* kind: the word before the time. */
LUM_PRINTF(3, 0)
static void add_line(struct say *say, const char *kind, const char *format,
                     va_list arguments)
{
    char text[768];
    char line[sizeof text + 64];
    char clock[16];
    (void)vsnprintf(text, sizeof text, format, arguments);
    write_clock(clock);
    (void)snprintf(line, sizeof line, "lumdump: %s%s: %s\n", kind, clock, text);
    append_left_out(say);
    clear_status(say);
    append(say, line);
    say_flush(say);
}

void say_warn(struct say *say, const char *format, ...)
{
    va_list arguments;
    if (say->is_quiet) {
        return;
    }
    va_start(arguments, format);
    add_line(say, "warning: ", format, arguments);
    va_end(arguments);
}

void say_error(struct say *say, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_line(say, "", format, arguments);
    va_end(arguments);
}

bool say_has_status(const struct say *say)
{
    return !say->is_quiet && terminal_is_foreground(stderr);
}

/* A line that the terminal would break could not be taken back. */
void say_status(struct say *say, const char *text)
{
    char line[512];
    const size_t width = terminal_columns() - 1u;
    say_flush(say);
    if (!say_has_status(say) || say->pending_bytes > 0) {
        return;
    }
    (void)snprintf(line, sizeof line, "%s%.*s", clear_line, (int)width, text);
    append(say, line);
    say->shows_status = true;
    say_flush(say);
}

void say_end(struct say *say)
{
    clear_status(say);
    append_left_out(say);
    while (say->pending_bytes > 0 && write_piece(say, 1000)) {
    }
}
