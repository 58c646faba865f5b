/* What the core includes of string.h, for compilers that come without a C
 * library; memory.c has the functions. */
#ifndef STRING_H
#define STRING_H

#include <stddef.h>

void *memcpy(void *restrict out, const void *restrict in, size_t n);
void *memmove(void *out, const void *in, size_t n);
void *memset(void *out, int value, size_t n);
int memcmp(const void *a, const void *b, size_t n);

#endif
