/** @file
 * Decimal numbers to integers in small units: exact, and independent of the
 * locale, unlike strtod(). Internal to host. */
#ifndef LUM_HOST_KEY_NUMBER_H
#define LUM_HOST_KEY_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** How reading a number went. */
typedef enum lum_key_number {
    LUM_KEY_NUMBER_FINE,         /**< read */
    LUM_KEY_NUMBER_NONE,         /**< not a decimal number */
    LUM_KEY_NUMBER_NOT_WHOLE,    /**< has a point or an exponent */
    LUM_KEY_NUMBER_LEADING_ZERO, /**< some read it as octal, others as
                                      decimal */
    LUM_KEY_NUMBER_TOO_LARGE     /**< beyond 64 bits */
} lum_key_number;

/** Read `[+-]digits[.digits][e[+-]digits]`, nothing before or after it.
 * @param text     len bytes; need not be terminated.
 * @param decimals 0..12; the result counts units of 10^-decimals.
 * @param whole    refuse a point and an exponent.
 * @param out      the number, rounded to the unit, half away from zero; written
 *                 only on success. */
lum_key_number lum_key_number_parse(const char *text, size_t len, int decimals,
                                    bool whole, int64_t *out);

#endif
