/* Numbers of a command line, strictly: the whole text, no unexpected sign or
 * space, and a point as decimal separator in any locale. */
#ifndef LUM_TOOLS_NUMBER_H
#define LUM_TOOLS_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

bool number_parse_int(const char *text, int64_t min, int64_t max, int64_t *out);

/* Finite, within [min, max]. */
bool number_parse_real(const char *text, double min, double max, double *out);

/* A number from 0 and its unit, without a space between: bytes, such as 64KiB
 * or 100MB; nanoseconds, such as 60s, 10min, 2h or 7d. */
bool number_parse_size(const char *text, double min, double max, double *out);
bool number_parse_time(const char *text, double min, double max, double *out);

/* a.b.c.d to host order. */
bool number_parse_address(const char *text, uint32_t *out);

/* Host order to a.b.c.d; out holds 16 bytes. Returns out. */
const char *number_format_address(uint32_t address, char out[16]);

/* The same as a value, to be shown at once. */
struct number_address {
    char text[16];
};
struct number_address number_address(uint32_t address);

#endif
