/** @file
 * How functions of the hosted layers say what went wrong. */
#ifndef LUM_BASE_ERROR_H
#define LUM_BASE_ERROR_H

#include <stddef.h>

/** Longest message, its NUL included. */
#define LUM_ERROR_BYTES 512

/** A message for a person: what was wrong, where, and what would be right; one
 * line, no newline at its end. Caller-owned. */
typedef struct lum_error {
    char text[LUM_ERROR_BYTES]; /**< NUL-terminated; empty: none */
} lum_error;

/** Set an error's text as printf does; what is too long is cut.
 * @param error may be NULL.
 * @return -1, so that `return lum_error_set(...)` reads well. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int lum_error_set(lum_error *error, const char *format, ...);

#endif
