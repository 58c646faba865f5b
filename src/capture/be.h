/** @file
 * Network byte order by shifts: any alignment, any host. Internal to
 * capture. The caller has checked the length. */
#ifndef LUM_CAPTURE_BE_H
#define LUM_CAPTURE_BE_H

#include <stdint.h>

static inline uint16_t load_be16(const uint8_t *p)
{
    return (uint16_t)(((unsigned)p[0] << 8) | p[1]);
}

static inline uint32_t load_be32(const uint8_t *p)
{
    return ((uint32_t)load_be16(p) << 16) | load_be16(p + 2);
}

static inline void store_be16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)((v >> 8) & 0xffu);
    p[1] = (uint8_t)(v & 0xffu);
}

static inline void store_be32(uint8_t *p, uint32_t v)
{
    store_be16(p, v >> 16);
    store_be16(p + 2, v & 0xffffu);
}

#endif
