/** @file
 * Texts that are made of parts, or kept. Internal. */
#ifndef LUM_BASE_TEXT_H
#define LUM_BASE_TEXT_H

#include "lum/base/error.h"

#include <stddef.h>

/** Add to a text, which is cut where it is full.
 * @param room Bytes that out has, its NUL among them. */
LUM_PRINTF(3, 4)
void lum_text_add(char *out, size_t room, const char *format, ...);

/** Add one more to a list.
 * @param between What stands between two of them. */
void lum_text_list(char *out, size_t room, const char *between,
                   const char *text);

/** A copy of a text, which ISO C has no function for.
 * @return to be freed with free(); NULL without memory. */
char *lum_text_copy(const char *text);

#endif
