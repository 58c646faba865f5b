/** @file
 * Texts that are made of parts. Internal. */
#ifndef LUM_BASE_TEXT_ADD_H
#define LUM_BASE_TEXT_ADD_H

#include "lum/base/error.h"

#include <stddef.h>

/** Add to a text, which is cut where it is full.
 * @param room Bytes that out has, its NUL among them. */
LUM_PRINTF(3, 4)
void lum_text_add(char *out, size_t room, const char *format, ...);

#endif
