#include "clock.h"

#include "bytes.h"
#include "product.h"

uint64_t lum_clock_extend(uint64_t before, uint64_t raw, unsigned bits)
{
    return lum_clock_follow(before, raw, lum_low_bits(bits));
}

uint64_t lum_clock_follow(uint64_t before, uint64_t raw, uint64_t mask)
{
    const uint64_t half = (mask >> 1) + 1u;
    return before + (((raw - before) & mask) ^ half) - half;
}

/* The upper half of a product with 2^38 / 1000: whole for any ns. */
static uint32_t whole_us(uint32_t ns)
{
    return (uint32_t)(product_unsigned(ns, UINT32_C(0x10624dd3)) >> 32) >> 6;
}

/* So many times 2^32 units, and 1000 times as many ticks, are added meanwhile:
 * ticks from 2^64 - 2^61 on, which are below 0, go over 2^64. */
#define AHEAD 536871u

/* As on paper, by digits of 32 bits, the highest first: 2^32 is 4294967 times
 * 1000, and 296. */
int64_t lum_clock_us(uint64_t ticks, uint32_t unit_ns)
{
    uint32_t digits[3];
    uint32_t rest = 0;
    if (unit_ns == 1000u) {
        return signed64(ticks);
    }
    uint64_t ns = product_unsigned((uint32_t)ticks, unit_ns);
    digits[0] = (uint32_t)ns;
    ns = product_unsigned((uint32_t)(ticks >> 32) + 1000u * AHEAD, unit_ns) +
         (ns >> 32);
    digits[1] = (uint32_t)ns;
    digits[2] = (uint32_t)(ns >> 32);
    for (unsigned k = 0; k < 3u; k++) {
        const unsigned i = 2u - k;
        const uint32_t us = whole_us(digits[i]);
        const uint32_t left = digits[i] - 1000u * us + 296u * rest;
        const uint32_t more = whole_us(left);
        digits[i] = 4294967u * rest + us + more;
        rest = left - 1000u * more;
    }
    return signed64((uint64_t)(digits[1] - AHEAD * unit_ns) << 32 | digits[0]);
}
