/* Text that may not be any. */
#ifndef LUM_TOOLS_UTF8_H
#define LUM_TOOLS_UTF8_H

#include <stddef.h>
#include <stdint.h>

/* Length of the UTF-8 sequence that begins here, 0 where none does. The text
 * ends with a NUL. */
size_t utf8_length(const unsigned char *p);

/* Its character; length is not 0. */
uint32_t utf8_character(const unsigned char *p, size_t length);

#endif
