#define _POSIX_C_SOURCE 200809L
#include "number.h"

#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool number_parse_int(const char *text, int64_t min, int64_t max, int64_t *out)
{
    const size_t sign = text[0] == '-' ? 1 : 0;
    char *end = NULL;
    if (strspn(text + sign, "0123456789") == 0) {
        return false;
    }
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    if (*end != '\0' || errno != 0 || value < min || value > max) {
        return false;
    }
    *out = value;
    return true;
}

bool number_parse_real(const char *text, double min, double max, double *out)
{
    char *end = NULL;
    if (text[0] == '\0' || strspn(text, "+-.0123456789eE") != strlen(text)) {
        return false;
    }
    errno = 0;
    const double value = strtod(text, &end);
    if (*end != '\0' || !isfinite(value) || value < min || value > max) {
        return false;
    }
    *out = value;
    return true;
}

bool number_parse_address(const char *text, uint32_t *out)
{
    struct in_addr address;
    if (inet_pton(AF_INET, text, &address) != 1) {
        return false;
    }
    *out = ntohl(address.s_addr);
    return true;
}

const char *number_format_address(uint32_t address, char out[16])
{
    (void)snprintf(out, 16, "%u.%u.%u.%u", (unsigned)(address >> 24),
                   (unsigned)(address >> 16 & 0xffu),
                   (unsigned)(address >> 8 & 0xffu),
                   (unsigned)(address & 0xffu));
    return out;
}
