#include "decimal.h"

#define C(digit) ((uint32_t)('0' + (digit)))

/* Text with its first character in the lowest byte, its length in the
 * highest. */
#define ONE(u)         (C(u) | 1u << 24)
#define TWO(t, u)      (C(t) | C(u) << 8 | 2u << 24)
#define THREE(h, t, u) (C(h) | C(t) << 8 | C(u) << 16 | 3u << 24)
#define FULL(h, t, u)  (C(h) | C(t) << 8 | C(u) << 16)

#define FOUR(d, h, t, u) (C(d) | C(h) << 8 | C(t) << 16 | C(u) << 24)

#define TEN_TWO(t)                                                             \
    TWO(t, 0), TWO(t, 1), TWO(t, 2), TWO(t, 3), TWO(t, 4), TWO(t, 5),          \
        TWO(t, 6), TWO(t, 7), TWO(t, 8), TWO(t, 9)
#define TEN(of, h, t)                                                          \
    of(h, t, 0), of(h, t, 1), of(h, t, 2), of(h, t, 3), of(h, t, 4),           \
        of(h, t, 5), of(h, t, 6), of(h, t, 7), of(h, t, 8), of(h, t, 9)
#define HUNDRED(of, h)                                                         \
    TEN(of, h, 0), TEN(of, h, 1), TEN(of, h, 2), TEN(of, h, 3), TEN(of, h, 4), \
        TEN(of, h, 5), TEN(of, h, 6), TEN(of, h, 7), TEN(of, h, 8),            \
        TEN(of, h, 9)
#define FROM_HUNDRED(of)                                                       \
    HUNDRED(of, 1), HUNDRED(of, 2), HUNDRED(of, 3), HUNDRED(of, 4),            \
        HUNDRED(of, 5), HUNDRED(of, 6), HUNDRED(of, 7), HUNDRED(of, 8),        \
        HUNDRED(of, 9)

#define TEN_FOUR(d, h, t)                                                      \
    FOUR(d, h, t, 0), FOUR(d, h, t, 1), FOUR(d, h, t, 2), FOUR(d, h, t, 3),    \
        FOUR(d, h, t, 4), FOUR(d, h, t, 5), FOUR(d, h, t, 6),                  \
        FOUR(d, h, t, 7), FOUR(d, h, t, 8), FOUR(d, h, t, 9)
#define HUNDRED_FOUR(d, h)                                                     \
    TEN_FOUR(d, h, 0), TEN_FOUR(d, h, 1), TEN_FOUR(d, h, 2),                   \
        TEN_FOUR(d, h, 3), TEN_FOUR(d, h, 4), TEN_FOUR(d, h, 5),               \
        TEN_FOUR(d, h, 6), TEN_FOUR(d, h, 7), TEN_FOUR(d, h, 8),               \
        TEN_FOUR(d, h, 9)
#define THOUSAND_FOUR(d)                                                       \
    HUNDRED_FOUR(d, 0), HUNDRED_FOUR(d, 1), HUNDRED_FOUR(d, 2),                \
        HUNDRED_FOUR(d, 3), HUNDRED_FOUR(d, 4), HUNDRED_FOUR(d, 5),            \
        HUNDRED_FOUR(d, 6), HUNDRED_FOUR(d, 7), HUNDRED_FOUR(d, 8),            \
        HUNDRED_FOUR(d, 9)

const uint32_t lum_short_digits[1000] = {
    ONE(0),     ONE(1),     ONE(2),     ONE(3),     ONE(4),
    ONE(5),     ONE(6),     ONE(7),     ONE(8),     ONE(9),
    TEN_TWO(1), TEN_TWO(2), TEN_TWO(3), TEN_TWO(4), TEN_TWO(5),
    TEN_TWO(6), TEN_TWO(7), TEN_TWO(8), TEN_TWO(9), FROM_HUNDRED(THREE)};

const uint32_t lum_full_digits[1000] = {HUNDRED(FULL, 0), FROM_HUNDRED(FULL)};

const uint32_t lum_four_digits[10000] = {
    THOUSAND_FOUR(0), THOUSAND_FOUR(1), THOUSAND_FOUR(2), THOUSAND_FOUR(3),
    THOUSAND_FOUR(4), THOUSAND_FOUR(5), THOUSAND_FOUR(6), THOUSAND_FOUR(7),
    THOUSAND_FOUR(8), THOUSAND_FOUR(9)};

char *lum_put_u64(char *p, uint64_t v)
{
    char digits[21];
    char *first = digits + sizeof digits;
    char group[4];
    for (; v >= 1000u; v /= 1000u) {
        first -= 3;
        lum_put_four(group, lum_full_digits[v % 1000u]);
        memcpy(first, group, 3);
    }
    const size_t rest = (size_t)(digits + sizeof digits - first);
    p = lum_put_three(p, (uint32_t)v);
    memcpy(p, first, rest);
    return p + rest;
}

/* The magnitude of an integer; that of INT64_MIN too. */
static uint64_t magnitude_of(int64_t v)
{
    return v < 0 ? 0u - (uint64_t)v : (uint64_t)v;
}

char *lum_put_i64(char *p, int64_t v)
{
    *p = '-';
    return lum_put_u64(p + (v < 0), magnitude_of(v));
}

/* The point and this number of digits of fraction < 10^decimals. */
static char *put_fraction(char *p, uint32_t fraction, unsigned decimals)
{
    for (unsigned i = decimals; i > 0; i--) {
        p[i] = (char)('0' + fraction % 10u);
        fraction /= 10u;
    }
    *p = '.';
    return p + (decimals > 0 ? 1u + decimals : 0u);
}

/* unit: 10^decimals. */
static char *put_scaled(char *p, int64_t scaled, uint32_t unit,
                        unsigned decimals)
{
    const uint64_t magnitude = magnitude_of(scaled);
    *p = '-';
    p = lum_put_u64(p + (scaled < 0), magnitude / unit);
    return put_fraction(p, (uint32_t)(magnitude % unit), decimals);
}

char *lum_put_fixed(char *p, int64_t scaled, unsigned decimals)
{
    return put_scaled(p, scaled, lum_decimal_unit(decimals), decimals);
}

char *lum_put_nanoseconds(char *p, int64_t ns)
{
    return put_scaled(p, ns, 1000000000u, 9);
}

char *lum_put_large(char *p, float v, unsigned decimals)
{
    const double scaled = (double)v * lum_decimal_unit(decimals);
    if (v != v) {
        memcpy(p, "nan", 3);
        return p + 3;
    }
    if (scaled > -9e18 && scaled < 9e18) {
        return lum_put_fixed(p, (int64_t)(scaled + (scaled < 0 ? -0.5 : 0.5)),
                             decimals);
    }
    const int n = snprintf(p, LUM_DECIMAL_ROOM, "%.0f", (double)v);
    p += n > 0 ? n : 0;
    return v - v == 0.0f ? put_fraction(p, 0, decimals) : p;
}
