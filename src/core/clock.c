#include "clock.h"

#include "bytes.h"
#include "product.h"

uint64_t lum_clock_extend(uint64_t before, uint64_t raw, unsigned bits)
{
    const uint64_t mask = lum_low_bits(bits);
    const uint64_t half = mask ^ mask >> 1;
    return before - half + ((raw - before + half) & mask);
}

/* So many times 2^32 units, and 1000 times as many ticks, are added meanwhile:
 * ticks from 2^64 - 1000 x 2^52 on, which are below 0, go over 2^64. */
#define AHEAD (UINT32_C(1) << 20)

/* As on paper, by bytes from the highest on: a rest and a byte are less than
 * 256,000, which a product with 2^22 / 125 divides exactly. */
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
    for (unsigned i = 0; i < 12u; i++) {
        uint32_t *const digit = &digits[(11u - i) / 4u];
        const uint32_t left = rest << 8 | *digit >> 24;
        const uint32_t us = ((left >> 3) * 33555u) >> 22;
        *digit = *digit << 8 | us;
        rest = left - 1000u * us;
    }
    return signed64((uint64_t)(digits[1] - AHEAD * unit_ns) << 32 | digits[0]);
}
