/* What is wrong, as a line on standard error. */
#include "options.h"

#include <stdarg.h>
#include <stdio.h>

/* In one write. */
bool complain(const char *format, ...)
{
    char text[12000];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    (void)fprintf(stderr, "lumsim: %s\n", text);
    return false;
}
