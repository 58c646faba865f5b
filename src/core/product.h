/* Products of 32 by 32 bits. Where a processor has no instruction for them, a
 * function by parts is half as long as the compiler's, which takes 64 bits. */
#ifndef LUM_CORE_PRODUCT_H
#define LUM_CORE_PRODUCT_H

#include <stdint.h>

#if ((-1) >> 1) != -1
#error "the right shift of a negative number has to keep its sign"
#endif

#if defined(__ARM_ARCH_6M__) || defined(__ARM_ARCH_8M_BASE__)
#define LUM_BY_PARTS 1
#else
#define LUM_BY_PARTS 0
#endif

/* Such a processor also needs only one copy of the code that multiplies. */
#if LUM_BY_PARTS && defined(__GNUC__)
#define LUM_ONE_COPY __attribute__((noinline))
#else
#define LUM_ONE_COPY inline
#endif

#if defined(__GNUC__)
#define LUM_IN_PLACE inline __attribute__((always_inline))
#else
#define LUM_IN_PLACE inline
#endif

/* A Cortex-M4 has an instruction for high_product(), but GCC does not use it by
 * itself. */
#if defined(__ARM_FEATURE_DSP) && defined(__thumb2__) && defined(__GNUC__)
#define LUM_SMMLA 1
#else
#define LUM_SMMLA 0
#endif

/* By products of 16 bits, on any processor; tests compare them. */
int32_t lum_high_by_parts(int32_t a, int32_t b, int32_t sum);
int64_t lum_product_by_parts(int32_t a, int32_t b);
uint64_t lum_unsigned_by_parts(uint32_t a, uint32_t b);

/* So many low bits set, 0..64. */
uint64_t lum_low_bits(unsigned bits);

/* A right shift by less than 64 bits; bit by bit where there is no instruction
 * for it. */
static inline uint64_t shift_down(uint64_t value, unsigned bits)
{
#if LUM_BY_PARTS
    uint64_t shifted = value;
    for (unsigned left = bits; left > 0; left--) {
        shifted >>= 1;
    }
    return shifted;
#else
    return value >> bits;
#endif
}

/* The upper half of a product, rounded down, and a sum. */
static inline int32_t high_product(int32_t a, int32_t b, int32_t sum)
{
#if LUM_BY_PARTS
    return lum_high_by_parts(a, b, sum);
#elif LUM_SMMLA
    int32_t high = 0;
    const int is_bare = __builtin_constant_p(sum) ? (sum == 0) : 0;
    if (is_bare != 0) {
        __asm__("smmul %0, %1, %2" : "=r"(high) : "r"(a), "r"(b));
    } else {
        __asm__("smmla %0, %1, %2, %3" : "=r"(high) : "r"(a), "r"(b), "r"(sum));
    }
    return high;
#else
    return (int32_t)(((int64_t)a * b) >> 32) + sum;
#endif
}

static inline int64_t product(int32_t a, int32_t b)
{
#if LUM_BY_PARTS
    return lum_product_by_parts(a, b);
#else
    return (int64_t)a * b;
#endif
}

static inline uint64_t product_unsigned(uint32_t a, uint32_t b)
{
#if LUM_BY_PARTS
    return lum_unsigned_by_parts(a, b);
#else
    return (uint64_t)a * b;
#endif
}

#endif
