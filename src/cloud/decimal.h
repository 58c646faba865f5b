/** @file
 * Numbers as fixed decimals, fast: from integers, without locale, printf or
 * libm. Half a unit in the last place rounds away from zero, and zero has no
 * sign.
 *
 * Each function writes at p, which must have LUM_DECIMAL_ROOM bytes, and
 * returns the end of the text; bytes behind that end may be overwritten too. No
 * NUL is added. Internal to cloud. */
#ifndef LUM_CLOUD_DECIMAL_H
#define LUM_CLOUD_DECIMAL_H

#include "le.h"

#include <stdio.h>

/** Room for any number that the functions below write. */
#define LUM_DECIMAL_ROOM 64u

/** Most decimals that these functions know. */
#define LUM_DECIMALS_MAX 5u

/** The bits of 999.0f: as integers, smaller floats have smaller ones. */
#define LUM_BITS_OF_999 0x4479c000u

#if defined(__GNUC__)
/** With the number of decimals known, divisions become multiplications. */
#define LUM_ALWAYS_INLINE static inline __attribute__((always_inline))
#else
#define LUM_ALWAYS_INLINE static inline
#endif

/** The text of 0 to 999, the first character in the lowest byte; the highest
 * byte is how long it is. */
extern const uint32_t lum_short_digits[1000];

/** The same, always three digits; the highest byte is 0. */
extern const uint32_t lum_full_digits[1000];

/** The text of 0 to 9999, always four digits. */
extern const uint32_t lum_four_digits[10000];

/** Any unsigned integer. */
char *lum_put_u64(char *p, uint64_t v);

/** Any integer. */
char *lum_put_i64(char *p, int64_t v);

/** scaled / 10^decimals with that many decimals, any scaled. */
char *lum_put_fixed(char *p, int64_t scaled, unsigned decimals);

/** Nanoseconds as seconds with 9 decimals. */
char *lum_put_nanoseconds(char *p, int64_t ns);

/** Values that lum_put_column() leaves to it: 999 or more, nan and inf. */
#if defined(__GNUC__)
__attribute__((cold))
#endif
char *
lum_put_large(char *p, float v, unsigned decimals);

/** Store four bytes, the lowest first. */
LUM_ALWAYS_INLINE void lum_put_four(char *p, uint32_t bytes)
{
    (void)lum_put_le32((unsigned char *)p, bytes);
}

/** Store eight bytes, the lowest first. */
LUM_ALWAYS_INLINE void lum_put_eight(char *p, uint64_t bytes)
{
    (void)lum_put_le64((unsigned char *)p, bytes);
}

/** 10 to the power of decimals, which is at most LUM_DECIMALS_MAX. */
LUM_ALWAYS_INLINE uint32_t lum_decimal_unit(unsigned decimals)
{
    static const uint32_t unit[LUM_DECIMALS_MAX + 1u] = {1,    10,    100,
                                                         1000, 10000, 100000};
    return unit[decimals];
}

/** An integer below 1000. */
LUM_ALWAYS_INLINE char *lum_put_three(char *p, uint32_t v)
{
    const uint32_t text = lum_short_digits[v];
    lum_put_four(p, text);
    return p + (text >> 24);
}

/** The digits of fraction < 10^decimals, for 3 to 5 decimals; the first digit
 * in the lowest byte. */
LUM_ALWAYS_INLINE uint64_t lum_fraction_digits(uint32_t fraction,
                                               unsigned decimals)
{
    if (decimals == 3u) {
        return lum_full_digits[fraction];
    }
    if (decimals == 4u) {
        return lum_four_digits[fraction];
    }
    const uint64_t last = '0' + (uint64_t)(fraction % 10u);
    return lum_four_digits[fraction / 10u] | last << 32;
}

/** scaled / 10^decimals for 3 to 5 decimals and a result below 1000, and a
 * separator: point, fraction and separator make one store. */
LUM_ALWAYS_INLINE char *lum_put_short(char *p, uint32_t scaled,
                                      unsigned decimals, char separator)
{
    const uint32_t unit = lum_decimal_unit(decimals);
    const uint64_t last = (uint64_t)(unsigned char)separator
                          << (8u * decimals + 8u);
    const uint64_t digits = lum_fraction_digits(scaled % unit, decimals);
    p = lum_put_three(p, scaled / unit);
    lum_put_eight(p, (uint64_t)'.' | digits << 8 | last);
    return p + 2u + decimals;
}

/** A float of any size with 3 to 5 decimals, and a separator; "nan", "inf" and
 * "-inf" if it is not a number. The product with a power of ten is exact in
 * double, and so is the rounding. */
LUM_ALWAYS_INLINE char *lum_put_column(char *p, float v, unsigned decimals,
                                       char separator)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    const uint32_t size = bits & 0x7fffffffu;
    if (size > LUM_BITS_OF_999) {
        p = lum_put_large(p, v, decimals);
        *p = separator;
        return p + 1;
    }
    float magnitude;
    memcpy(&magnitude, &size, sizeof magnitude);
    const double scaled = (double)magnitude * lum_decimal_unit(decimals);
    const uint32_t rounded = (uint32_t)(int32_t)(scaled + 0.5);
    *p = '-';
    p += (bits >> 31) & (rounded != 0);
    return lum_put_short(p, rounded, decimals, separator);
}

#endif
