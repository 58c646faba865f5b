#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void lum_text_add(char *out, size_t room, const char *format, ...)
{
    const size_t len = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(out + len, room - len, format, arguments);
    va_end(arguments);
}

void lum_text_list(char *out, size_t room, const char *between,
                   const char *text)
{
    lum_text_add(out, room, "%s%s", out[0] != '\0' ? between : "", text);
}

char *lum_text_copy(const char *text)
{
    const size_t len = strlen(text) + 1u;
    char *copy = malloc(len);
    if (copy != NULL) {
        memcpy(copy, text, len);
    }
    return copy;
}
