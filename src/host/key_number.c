/* Decimal numbers to integers in small units: exact, and independent of the
 * locale, unlike strtod(). */
#include "key_rule.h"

#include <string.h>

/* More than the digits of any text that is read. */
#define EXPONENT_MAX 1000000

typedef struct digits {
    const char *text;
    size_t count;
} digits;

typedef struct decimal {
    bool negative;
    bool whole;
    digits integer;
    digits fraction;
    int64_t exponent;
} decimal;

static digits scan_digits(const char **p, const char *end)
{
    digits d = {*p, 0};
    while (*p < end && **p >= '0' && **p <= '9') {
        (*p)++;
        d.count++;
    }
    return d;
}

static bool scan_sign(const char **p, const char *end)
{
    if (*p < end && (**p == '-' || **p == '+')) {
        return *(*p)++ == '-';
    }
    return false;
}

/* Reads the digits after an e; false if there are none. */
static bool scan_exponent(const char **p, const char *end, int64_t *out)
{
    const bool negative = scan_sign(p, end);
    const digits d = scan_digits(p, end);
    int64_t value = 0;
    for (size_t i = 0; i < d.count && value < EXPONENT_MAX; i++) {
        value = value * 10 + (d.text[i] - '0');
    }
    *out = negative ? -value : value;
    return d.count > 0;
}

static bool scan_decimal(const char *p, const char *end, decimal *d)
{
    d->negative = scan_sign(&p, end);
    d->integer = scan_digits(&p, end);
    d->fraction = (digits){p, 0};
    d->whole = true;
    if (p < end && *p == '.') {
        d->whole = false;
        p++;
        d->fraction = scan_digits(&p, end);
    }
    if (d->integer.count + d->fraction.count == 0) {
        return false;
    }
    if (p < end && (*p == 'e' || *p == 'E')) {
        d->whole = false;
        p++;
        if (!scan_exponent(&p, end, &d->exponent)) {
            return false;
        }
    }
    return p == end;
}

/* The i-th digit of a number, which is followed by zeros. */
static int digit_at(const decimal *d, size_t i)
{
    if (i < d->integer.count) {
        return d->integer.text[i] - '0';
    }
    i -= d->integer.count;
    return i < d->fraction.count ? d->fraction.text[i] - '0' : 0;
}

static bool scale(const decimal *d, int decimals, int64_t *out)
{
    const int64_t keep = (int64_t)d->integer.count + d->exponent + decimals;
    const size_t count = d->integer.count + d->fraction.count;
    int64_t value = 0;
    if (keep < 0) {
        *out = 0;
        return true;
    }
    for (size_t i = 0; i < (size_t)keep && (value != 0 || i < count); i++) {
        if (value > (INT64_MAX - 10) / 10) {
            return false;
        }
        value = value * 10 + digit_at(d, i);
    }
    value += digit_at(d, (size_t)keep) >= 5;
    *out = d->negative ? -value : value;
    return true;
}

lum_key_number lum_key_number_parse(const char *text, size_t len, int decimals,
                                    bool whole, int64_t *out)
{
    decimal d;
    memset(&d, 0, sizeof d);
    if (!scan_decimal(text, text + len, &d)) {
        return LUM_KEY_NUMBER_NONE;
    }
    if (whole && !d.whole) {
        return LUM_KEY_NUMBER_NOT_WHOLE;
    }
    if (d.integer.count > 1 && d.integer.text[0] == '0') {
        return LUM_KEY_NUMBER_LEADING_ZERO;
    }
    return scale(&d, decimals, out) ? LUM_KEY_NUMBER_FINE
                                    : LUM_KEY_NUMBER_TOO_LARGE;
}
