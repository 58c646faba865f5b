#include "number.h"

#include <errno.h>
#include <float.h>
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
    const bool is_finite = value >= -DBL_MAX && value <= DBL_MAX;
    if (*end != '\0' || !is_finite || value < min || value > max) {
        return false;
    }
    *out = value;
    return true;
}

/* Units and what one of them is. */
struct unit {
    const char *name;
    double factor;
};

static bool parse_quantity(const char *text, const struct unit *units,
                           double min, double max, double *out)
{
    char number[32];
    const size_t len = strspn(text, "0123456789.");
    while (units->name != NULL && strcmp(units->name, text + len) != 0) {
        units++;
    }
    if (units->name == NULL || len >= sizeof number) {
        return false;
    }
    (void)snprintf(number, sizeof number, "%.*s", (int)len, text);
    const bool is_number = number_parse_real(number, 0, 1e12, out);
    *out *= units->factor;
    return is_number && *out >= min && *out <= max;
}

bool number_parse_size(const char *text, double min, double max, double *out)
{
    static const struct unit sizes[] = {
        {"B", 1},         {"kB", 1e3},         {"MB", 1e6},
        {"GB", 1e9},      {"TB", 1e12},        {"KiB", 1024},
        {"MiB", 1048576}, {"GiB", 1073741824}, {NULL, 0}};
    return parse_quantity(text, sizes, min, max, out);
}

bool number_parse_time(const char *text, double min, double max, double *out)
{
    static const struct unit times[] = {
        {"s", 1e9}, {"min", 60e9}, {"h", 3600e9}, {"d", 86400e9}, {NULL, 0}};
    return parse_quantity(text, times, min, max, out);
}

/* 0..255 in decimal without leading zeros. Returns its digits, 0: none. */
static size_t read_part(const char *text, uint32_t *out)
{
    const size_t n = strspn(text, "0123456789");
    uint32_t value = 0;
    if (n == 0 || n > 3 || (n > 1 && text[0] == '0')) {
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        value = 10u * value + (uint32_t)(text[i] - '0');
    }
    *out = value;
    return value <= 255u ? n : 0;
}

bool number_parse_address(const char *text, uint32_t *out)
{
    uint32_t address = 0;
    for (unsigned i = 0; i < 4; i++) {
        uint32_t part = 0;
        const size_t n = read_part(text, &part);
        if (n == 0 || text[n] != (i < 3 ? '.' : '\0')) {
            return false;
        }
        address = address << 8 | part;
        text += n + 1;
    }
    *out = address;
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

struct number_address number_address(uint32_t address)
{
    struct number_address out;
    (void)number_format_address(address, out.text);
    return out;
}
