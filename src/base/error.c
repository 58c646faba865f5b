#include "lum/base/error.h"

#include <stdarg.h>
#include <stdio.h>

int lum_error_set(lum_error *error, const char *format, ...)
{
    if (error != NULL) {
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(error->text, sizeof error->text, format, arguments);
        va_end(arguments);
    }
    return -1;
}
