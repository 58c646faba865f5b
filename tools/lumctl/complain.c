/* Complaints and notes on standard error. */
#include "ctl.h"

#include "../common/terminal.h"

#include <stdarg.h>
#include <stdio.h>

/* Whoever owns a sensor waits for no reader: its heartbeats come first. */
static bool is_hurried;

void ctl_complain_hurry(bool is)
{
    is_hurried = is;
}

LUM_PRINTF(1, 0)
static void say(const char *format, va_list arguments)
{
    if (!is_hurried || writable(stderr, 0)) {
        (void)fputs("lumctl: ", stderr);
        (void)vfprintf(stderr, format, arguments);
        (void)fputc('\n', stderr);
    }
}

enum exit_status ctl_complain(enum exit_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    say(format, arguments);
    va_end(arguments);
    return status;
}

void ctl_note(const struct ctl *ctl, const char *format, ...)
{
    va_list arguments;
    if (!ctl->options.quiet) {
        va_start(arguments, format);
        say(format, arguments);
        va_end(arguments);
    }
}
