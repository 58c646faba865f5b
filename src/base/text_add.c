#include "base/text_add.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void lum_text_add(char *out, size_t room, const char *format, ...)
{
    const size_t len = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(out + len, room - len, format, arguments);
    va_end(arguments);
}
