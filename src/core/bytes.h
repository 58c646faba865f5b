/* Integers by shifts: any alignment, any host. */
#ifndef LUM_CORE_BYTES_H
#define LUM_CORE_BYTES_H

#include "lum/profile.h"
#include "product.h"

#include <stdint.h>

/* Where one instruction reads any address, it is shorter than a call. */
#ifdef __ARM_FEATURE_UNALIGNED
#define LUM_LOAD_INLINE LUM_IN_PLACE
#else
#define LUM_LOAD_INLINE inline
#endif

/* Whether compilers make vector code for this target; 0 and 1 can be asked for,
 * and give the same lines. */
#ifndef LUM_VECTORS
#if defined(__SSE2__) || defined(__ARM_NEON) || defined(__ALTIVEC__)
#define LUM_VECTORS 1
#else
#define LUM_VECTORS 0
#endif
#endif

/* clang makes vector code of loops over whole loads alone. */
#if LUM_VECTORS && defined(__clang__) &&                                       \
    __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define LUM_WHOLE_LOADS 1
#else
#define LUM_WHOLE_LOADS 0
#endif

static inline uint16_t load_u16(const uint8_t *p)
{
#if LUM_WHOLE_LOADS
    uint16_t v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
#else
    return (uint16_t)(p[0] | ((unsigned)p[1] << 8));
#endif
}

static LUM_LOAD_INLINE uint32_t load_u32(const uint8_t *p)
{
#if LUM_WHOLE_LOADS
    uint32_t v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
#else
    return (uint32_t)p[0] | ((uint32_t)p[1] << 8) | ((uint32_t)p[2] << 16) |
           ((uint32_t)p[3] << 24);
#endif
}

static inline uint64_t load_u64(const uint8_t *p)
{
    return load_u32(p) | (uint64_t)load_u32(p + 4) << 32;
}

static inline uint16_t load_big_u16(const uint8_t *p)
{
    return (uint16_t)(p[1] | ((unsigned)p[0] << 8));
}

static LUM_LOAD_INLINE uint32_t load_big_u32(const uint8_t *p)
{
    return (uint32_t)p[3] | ((uint32_t)p[2] << 8) | ((uint32_t)p[1] << 16) |
           ((uint32_t)p[0] << 24);
}

static inline uint64_t load_big_u64(const uint8_t *p)
{
    return load_big_u32(p + 4) | (uint64_t)load_big_u32(p) << 32;
}

static inline uint32_t swapped32(uint32_t v)
{
    return v >> 24 | (v >> 8 & 0xff00u) | (v & 0xff00u) << 8 | v << 24;
}

/* order: an ::lum_byte_order. */
static LUM_LOAD_INLINE uint32_t load_sample(const uint8_t *p, uint8_t order)
{
    const uint32_t v = load_u32(p);
    return order == LUM_ORDER_LITTLE ? v : swapped32(v);
}

static inline void store_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v & 0xffu);
    p[1] = (uint8_t)((v >> 8) & 0xffu);
}

static inline void store_u32(uint8_t *p, uint32_t v)
{
    store_u16(p, v & 0xffffu);
    store_u16(p + 2, v >> 16);
}

/* Two's complement without a conversion that C99 leaves to the compiler. */
static inline int16_t signed16(uint16_t v)
{
    return (int16_t)((int32_t)(v ^ 0x8000u) - 0x8000);
}

static inline int32_t signed32(uint32_t v)
{
    return v <= INT32_MAX ? (int32_t)v : -(int32_t)~v - 1;
}

static inline int64_t signed64(uint64_t v)
{
    return v <= INT64_MAX ? (int64_t)v : -(int64_t)~v - 1;
}

#endif
