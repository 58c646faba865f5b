/** @file
 * Decimal numbers of YAML files to integers in small units and back: exact, and
 * blind to the locale, which strtod() is not. Internal to config. */
#ifndef LUM_CONFIG_YAML_NUMBER_H
#define LUM_CONFIG_YAML_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes that every formatted number fits. */
#define LUM_YAML_NUMBER_BYTES 40

/** How reading a number went. */
typedef enum lum_yaml_number {
    LUM_YAML_NUMBER_FINE,         /**< read */
    LUM_YAML_NUMBER_NONE,         /**< not a decimal number */
    LUM_YAML_NUMBER_NOT_WHOLE,    /**< has a point or an exponent */
    LUM_YAML_NUMBER_LEADING_ZERO, /**< octal to some, decimal to others */
    LUM_YAML_NUMBER_TOO_LARGE     /**< beyond 64 bits */
} lum_yaml_number;

/** Read `[+-]digits[.digits][e[+-]digits]`, nothing before or behind it.
 * @param text     len bytes; need not be terminated.
 * @param decimals 0..12; the result counts units of 10^-decimals.
 * @param whole    refuse a point and an exponent.
 * @param out      the number, rounded to the unit, half away from zero; written
 *                 only when all is fine. */
lum_yaml_number lum_yaml_number_parse(const char *text, size_t len,
                                      int decimals, bool whole, int64_t *out);

/** Write number x 10^-decimals, without zeros at the end of its fraction.
 * @param out      gets a terminated string.
 * @param decimals 0..12. */
void lum_yaml_number_format(char out[LUM_YAML_NUMBER_BYTES], int64_t number,
                            int decimals);

#endif
