#include "product.h"

/* a = ah x 2^16 + al, where al is not negative, and b likewise. Each sum of a
 * product and what was carried into it still fits. */
static LUM_IN_PLACE int32_t upper_half(int32_t a, int32_t b)
{
    const int32_t al = a & 0xffff;
    const int32_t bl = b & 0xffff;
    const int32_t ah = a >> 16;
    const int32_t bh = b >> 16;
    const uint32_t low = (uint32_t)al * (uint32_t)bl;
    const int32_t middle = ah * bl + (int32_t)(low >> 16);
    const int32_t other = al * bh + (middle & 0xffff);
    return ah * bh + (middle >> 16) + (other >> 16);
}

int32_t lum_high_by_parts(int32_t a, int32_t b, int32_t sum)
{
    return upper_half(a, b) + sum;
}

/* The lower half is that of a product of 32 bits. */
int64_t lum_product_by_parts(int32_t a, int32_t b)
{
    const uint32_t high = (uint32_t)upper_half(a, b);
    return (int64_t)((uint64_t)high << 32 | (uint32_t)a * (uint32_t)b);
}

/* What a sign takes off is added. */
uint64_t lum_unsigned_by_parts(uint32_t a, uint32_t b)
{
    const uint32_t high = (a >> 31 != 0 ? b : 0) + (b >> 31 != 0 ? a : 0);
    return (uint64_t)lum_product_by_parts((int32_t)a, (int32_t)b) +
           ((uint64_t)high << 32);
}

uint64_t lum_low_bits(unsigned bits)
{
#if LUM_BY_PARTS
    const uint32_t ones = (UINT32_C(1) << (bits % 32u)) - 1u;
    if (bits < 32u) {
        return ones;
    }
    return bits < 64u ? (uint64_t)ones << 32 | UINT32_MAX : UINT64_MAX;
#else
    return bits == 0 ? 0 : UINT64_MAX >> (64u - bits);
#endif
}
