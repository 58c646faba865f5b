/** @file
 * How functions of the hosted layers report errors. */
#ifndef LUM_BASE_ERROR_H
#define LUM_BASE_ERROR_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__MINGW32__)
/** The arguments from first_at on are those of a printf format at format_at. */
#define LUM_PRINTF(format_at, first_at)                                        \
    __attribute__((format(gnu_printf, format_at, first_at)))
#elif defined(__GNUC__)
/** The arguments from first_at on are those of a printf format at format_at. */
#define LUM_PRINTF(format_at, first_at)                                        \
    __attribute__((format(printf, format_at, first_at)))
#else
/** The arguments from first_at on are those of a printf format at format_at. */
#define LUM_PRINTF(format_at, first_at)
#endif

/** Longest message, its NUL included. */
#define LUM_ERROR_BYTES 512

/** A message for a person: what was wrong, where, and the fix; one line, no
 * newline at its end. Caller-owned. It never grows. */
typedef struct lum_error {
    char text[LUM_ERROR_BYTES]; /**< NUL-terminated; empty: none */
} lum_error;

/** Set an error's text as printf does; longer text is cut.
 * @param error may be NULL.
 * @return -1, so that `return lum_error_set(...)` reads well. */
LUM_PRINTF(2, 3)
int lum_error_set(lum_error *error, const char *format, ...);

#ifdef __cplusplus
}
#endif

#endif
