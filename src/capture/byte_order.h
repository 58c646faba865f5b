/** @file
 * Numbers of either byte order, of which core has those that it needs itself.
 * Internal to capture and frame. The caller has checked the length. */
#ifndef LUM_CAPTURE_BYTE_ORDER_H
#define LUM_CAPTURE_BYTE_ORDER_H

#include "core/bytes.h"

static inline void store_big_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)((v >> 8) & 0xffu);
    p[1] = (uint8_t)(v & 0xffu);
}

static inline void store_big_u32(uint8_t *p, uint32_t v)
{
    store_big_u16(p, v >> 16);
    store_big_u16(p + 2, v & 0xffffu);
}

#endif
