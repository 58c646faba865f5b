/* What a sensor says, without what could upset a terminal. */
#ifndef LUM_TOOLS_PRINTABLE_H
#define LUM_TOOLS_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Bytes of the wire as text: bytes that are not printable ASCII become '?'. Cut
 * to size - 1 characters; size is at least 1. Returns out. */
const char *printable(const uint8_t *bytes, size_t len, char *out, size_t size);

#endif
