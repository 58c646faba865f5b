/* Bytes that may not be text, or could upset a terminal. */
#ifndef LUM_TOOLS_PRINTABLE_H
#define LUM_TOOLS_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Bytes of the wire as text: bytes that are not printable ASCII become '?'. Cut
 * to size - 1 characters; size is at least 1. Returns out. */
const char *printable(const uint8_t *bytes, size_t len, char *out, size_t size);

/* Length of the UTF-8 sequence that begins here, 0 where none does. The text
 * ends with a NUL. */
size_t utf8_length(const unsigned char *p);

/* Its character; length is not 0. */
uint32_t utf8_character(const unsigned char *p, size_t length);

#endif
