#include "ctl.h"

#include <stdarg.h>
#include <stdio.h>

enum exit_status ctl_complain(enum exit_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)fputs("lumctl: ", stderr);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
    return status;
}

void ctl_note(const struct ctl *ctl, const char *format, ...)
{
    va_list arguments;
    if (ctl->options.quiet) {
        return;
    }
    va_start(arguments, format);
    (void)fputs("lumctl: ", stderr);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
}
