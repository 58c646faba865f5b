#include "terminal.h"

#include <io.h>

/* A console has no background. */
bool terminal_is_foreground(FILE *stream)
{
    return _isatty(_fileno(stream)) != 0;
}
