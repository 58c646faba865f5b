/** @file
 * Numbers as fixed decimals, fast: from integers, without locale, printf or
 * libm. Half a unit in the last place rounds away from zero, and what rounds to
 * zero has no sign.
 *
 * Each function writes at p, which must have LUM_DECIMAL_ROOM bytes, and
 * returns the end of the text; bytes behind that end may be overwritten too. No
 * NUL is added. */
#ifndef LUM_IO_DECIMAL_H
#define LUM_IO_DECIMAL_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

/** The bits of 9999.0f: as integers, smaller floats have smaller ones. */
#define LUM_BITS_OF_9999 0x461c3c00u

/** Room for any number that the functions below write. */
#define LUM_DECIMAL_ROOM 64u

/** Most decimals that these functions know. */
#define LUM_DECIMALS_MAX 5u

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
/** A number can be stored as it is; compilers do not always see that. */
#define LUM_LITTLE_ENDIAN 1
#endif

#if defined(__GNUC__)
/** With the number of decimals known, divisions become multiplications. */
#define LUM_ALWAYS_INLINE static inline __attribute__((always_inline))
/** Rare: keeps the code around it small. */
#define LUM_RARE static __attribute__((noinline, cold, unused))
#else
#define LUM_ALWAYS_INLINE static inline
#define LUM_RARE          static
#endif

/** Store four bytes, the lowest first. */
LUM_ALWAYS_INLINE void lum_put_four(char *p, uint32_t bytes)
{
#ifdef LUM_LITTLE_ENDIAN
    memcpy(p, &bytes, sizeof bytes);
#else
    for (unsigned i = 0; i < 4u; i++) {
        p[i] = (char)(bytes >> (8u * i) & 0xffu);
    }
#endif
}

/** Store eight bytes, the lowest first. */
LUM_ALWAYS_INLINE void lum_put_eight(char *p, uint64_t bytes)
{
#ifdef LUM_LITTLE_ENDIAN
    memcpy(p, &bytes, sizeof bytes);
#else
    for (unsigned i = 0; i < 8u; i++) {
        p[i] = (char)(bytes >> (8u * i) & 0xffu);
    }
#endif
}

/** The four ASCII digits of a < 10000 in the low half, of b < 10000 in the high
 * half, each with the first digit in the lowest byte: two numbers for the price
 * of one. */
LUM_ALWAYS_INLINE uint64_t lum_eight_digits(uint32_t a, uint32_t b)
{
    const uint64_t both = a | (uint64_t)b << 32;
    const uint64_t hundreds =
        (both * 5243u >> 19) & UINT64_C(0x0000007f0000007f);
    const uint64_t pairs = hundreds | (both - 100u * hundreds) << 16;
    const uint64_t tens = (pairs * 103u >> 10) & UINT64_C(0x000f000f000f000f);
    return (tens | (pairs - 10u * tens) << 8) + UINT64_C(0x3030303030303030);
}

/** How many bits of leading zeros four digits have, less than all four; the
 * digits are in binary here. */
LUM_ALWAYS_INLINE unsigned lum_zero_bits(uint32_t digits)
{
#if defined(__GNUC__)
    return (unsigned)__builtin_ctz(digits | 0x01000000u) & 24u;
#else
    return (digits & 0x00ffffffu) == 0u   ? 24u
           : (digits & 0x0000ffffu) == 0u ? 16u
           : (digits & 0x000000ffu) == 0u ? 8u
                                          : 0u;
#endif
}

/** Store the low half of lum_eight_digits() without leading zeros and without
 * a branch. */
LUM_ALWAYS_INLINE char *lum_put_low(char *p, uint64_t digits)
{
    const uint32_t low = (uint32_t)(digits & 0xffffffffu);
    const unsigned bits = lum_zero_bits(low - 0x30303030u);
    lum_put_four(p, low >> bits);
    return p + 4u - bits / 8u;
}

/** An integer below 10000. */
LUM_ALWAYS_INLINE char *lum_put_small(char *p, uint32_t v)
{
    return lum_put_low(p, lum_eight_digits(v, 0));
}

/** Any unsigned integer. */
static inline char *lum_put_u64(char *p, uint64_t v)
{
    char digits[20];
    char *first = digits + sizeof digits;
    if (v < 10000u) {
        return lum_put_small(p, (uint32_t)v);
    }
    for (; v >= 10000u; v /= 10000u) {
        first -= 4;
        const uint32_t low = (uint32_t)(v % 10000u);
        lum_put_four(first, (uint32_t)(lum_eight_digits(0, low) >> 32));
    }
    p = lum_put_small(p, (uint32_t)v);
    const size_t rest = (size_t)(digits + sizeof digits - first);
    memcpy(p, first, rest);
    return p + rest;
}

/** The magnitude of an integer; that of INT64_MIN too. */
static inline uint64_t lum_magnitude(int64_t v)
{
    return v < 0 ? 0u - (uint64_t)v : (uint64_t)v;
}

/** Any integer. */
static inline char *lum_put_i64(char *p, int64_t v)
{
    *p = '-';
    return lum_put_u64(p + (v < 0), lum_magnitude(v));
}

/** 10 to the power of decimals, which is at most LUM_DECIMALS_MAX. */
LUM_ALWAYS_INLINE uint32_t lum_decimal_unit(unsigned decimals)
{
    static const uint32_t unit[LUM_DECIMALS_MAX + 1u] = {1,    10,    100,
                                                         1000, 10000, 100000};
    return unit[decimals];
}

/** scaled / 10^decimals for 3 to 5 decimals and a result below 10000, and a
 * separator: point, fraction and separator make one store. */
LUM_ALWAYS_INLINE char *lum_put_short(char *p, uint32_t scaled,
                                      unsigned decimals, char separator)
{
    const uint32_t unit = lum_decimal_unit(decimals);
    const uint32_t fraction = scaled % unit;
    const uint32_t four = decimals == 3u   ? fraction * 10u
                          : decimals == 4u ? fraction
                                           : fraction / 10u;
    const uint64_t digits = lum_eight_digits(scaled / unit, four);
    const uint64_t last = (uint64_t)(unsigned char)separator
                          << (8u * decimals + 8u);
    uint64_t tail = digits >> 32 << 8 | (uint64_t)'.';
    if (decimals == 3u) {
        tail &= UINT64_C(0xffffffff);
    }
    if (decimals == 5u) {
        tail |= (uint64_t)('0' + fraction % 10u) << 40;
    }
    p = lum_put_low(p, digits);
    lum_put_eight(p, tail | last);
    return p + 2u + decimals;
}

/** The point and fraction < 10^decimals. */
static inline char *lum_put_fraction(char *p, uint32_t fraction,
                                     unsigned decimals)
{
    const uint32_t five =
        fraction * lum_decimal_unit(LUM_DECIMALS_MAX - decimals);
    *p = '.';
    lum_put_four(p + 1, (uint32_t)(lum_eight_digits(0, five / 10u) >> 32));
    p[5] = (char)('0' + five % 10u);
    return p + (decimals > 0 ? 1u + decimals : 0u);
}

/** scaled / 10^decimals with that many decimals, any scaled. */
static inline char *lum_put_fixed(char *p, int64_t scaled, unsigned decimals)
{
    const uint64_t magnitude = lum_magnitude(scaled);
    const uint32_t unit = lum_decimal_unit(decimals);
    *p = '-';
    p = lum_put_u64(p + (scaled < 0), magnitude / unit);
    return lum_put_fraction(p, (uint32_t)(magnitude % unit), decimals);
}

/** What lum_put_column() does not do at once: 10000 or more, and no numbers. */
LUM_RARE char *lum_put_large(char *p, float v, unsigned decimals)
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
    return v - v == 0.0f ? lum_put_fraction(p, 0, decimals) : p;
}

/** A float of any size with 3 to 5 decimals, and a separator; "nan", "inf" and
 * "-inf" where it is no number. The product with a power of ten is exact in
 * double, and so is the rounding. */
LUM_ALWAYS_INLINE char *lum_put_column(char *p, float v, unsigned decimals,
                                       char separator)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    const uint32_t size = bits & 0x7fffffffu;
    if (size > LUM_BITS_OF_9999) {
        p = lum_put_large(p, v, decimals);
        *p = separator;
        return p + 1;
    }
    float magnitude;
    memcpy(&magnitude, &size, sizeof magnitude);
    const double scaled = (double)magnitude * lum_decimal_unit(decimals);
    const uint32_t rounded = (uint32_t)(int64_t)(scaled + 0.5);
    *p = '-';
    p += (bits >> 31) & (rounded != 0);
    return lum_put_short(p, rounded, decimals, separator);
}

#endif
