/* Names of files in commands that a person copies. */
#ifndef LUM_TOOLS_SHELL_WORD_H
#define LUM_TOOLS_SHELL_WORD_H

#include <stddef.h>

/* A name as one word of the system's shell, in quotes where it needs them, and
 * never like an option. Returns out; NULL: it does not fit, or has characters
 * that cannot be shown. */
const char *shell_word(const char *name, char *out, size_t room);

#endif
