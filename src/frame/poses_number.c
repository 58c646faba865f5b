/* Numbers of poses in a text, whatever the locale is. */
#include "poses_internal.h"

#include <math.h>
#include <string.h>

#define DIGITS_MAX   UINT64_C(1000000000000000000)
#define EXPONENT_MAX 100000

struct text {
    const char *at;
    const char *end;
};

static bool take(struct text *t, const char *any)
{
    if (t->at < t->end && *t->at != '\0' && strchr(any, *t->at) != NULL) {
        t->at++;
        return true;
    }
    return false;
}

/* Digits, from the first to the last. Those beyond the 19th are dropped. */
static size_t take_digits(struct text *t, lum_decimal *d, bool is_fraction)
{
    size_t n = 0;
    for (; t->at < t->end && *t->at >= '0' && *t->at <= '9'; t->at++, n++) {
        const bool has_room = d->digits < DIGITS_MAX;
        if (has_room) {
            d->digits = d->digits * 10u + (uint64_t)(*t->at - '0');
        }
        if (has_room == is_fraction && d->exponent < EXPONENT_MAX &&
            d->exponent > -EXPONENT_MAX) {
            d->exponent += is_fraction ? -1 : 1;
        }
    }
    return n;
}

static bool take_exponent(struct text *t, lum_decimal *d)
{
    if (!take(t, "eE")) {
        return true;
    }
    const bool is_negative = take(t, "-");
    if (!is_negative) {
        (void)take(t, "+");
    }
    int value = 0;
    const char *begin = t->at;
    for (; t->at < t->end && *t->at >= '0' && *t->at <= '9'; t->at++) {
        value = value < EXPONENT_MAX ? value * 10 + (*t->at - '0') : value;
    }
    d->exponent += is_negative ? -value : value;
    return t->at > begin;
}

bool lum_decimal_parse(const char *at, size_t len, lum_decimal *out)
{
    struct text t = {at, at + len};
    lum_decimal d = {0, 0, false};
    d.is_negative = take(&t, "-");
    if (!d.is_negative) {
        (void)take(&t, "+");
    }
    size_t digits = take_digits(&t, &d, false);
    if (take(&t, ".")) {
        digits += take_digits(&t, &d, true);
    }
    if (digits == 0 || !take_exponent(&t, &d) || t.at != t.end) {
        return false;
    }
    *out = d;
    return true;
}

double lum_decimal_double(const lum_decimal *d)
{
    const double value = (double)d->digits;
    if (d->digits == 0) {
        return 0.0;
    }
    const double size = d->exponent < -300
                            ? value * 1e-300 * pow(10.0, d->exponent + 300)
                        : d->exponent < 0 ? value / pow(10.0, -d->exponent)
                                          : value * pow(10.0, d->exponent);
    return d->is_negative ? -size : size;
}

bool lum_decimal_whole(const lum_decimal *d, int exponent, int64_t *out)
{
    uint64_t value = d->digits;
    int e = d->exponent + exponent;
    for (; e > 0 && value > 0; e--) {
        if (value > (uint64_t)INT64_MAX / 10u) {
            return false;
        }
        value *= 10u;
    }
    unsigned last = 0;
    for (; e < 0 && (value > 0 || last > 0); e++) {
        last = (unsigned)(value % 10u);
        value /= 10u;
    }
    value += e == 0 && last >= 5u ? 1u : 0u;
    if (value > (uint64_t)INT64_MAX) {
        return false;
    }
    *out = d->is_negative ? -(int64_t)value : (int64_t)value;
    return true;
}
