/** @file
 * Little-endian numbers into memory of any alignment, on any host, and from it.
 * What writes returns the end of what it wrote. */
#ifndef LUM_CLOUD_LE_H
#define LUM_CLOUD_LE_H

#include <stdint.h>
#include <string.h>

/* Where memory has this order, a number is copied: compilers do not see that of
 * shifts when other memory is read between. */
#if defined(__BYTE_ORDER__) && defined(__ORDER_LITTLE_ENDIAN__) &&             \
    __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define LUM_IS_LITTLE_ENDIAN 1
#else
#define LUM_IS_LITTLE_ENDIAN 0
#endif

/** One byte. */
static inline unsigned char *lum_put_u8(unsigned char *p, uint8_t v)
{
    p[0] = v;
    return p + 1;
}

/** Two bytes. */
static inline unsigned char *lum_put_le16(unsigned char *p, uint16_t v)
{
    if (LUM_IS_LITTLE_ENDIAN) {
        memcpy(p, &v, sizeof v);
        return p + sizeof v;
    }
    p[0] = (unsigned char)(v & 0xffu);
    p[1] = (unsigned char)(v >> 8);
    return p + 2;
}

/** Four bytes. */
static inline unsigned char *lum_put_le32(unsigned char *p, uint32_t v)
{
    if (LUM_IS_LITTLE_ENDIAN) {
        memcpy(p, &v, sizeof v);
        return p + sizeof v;
    }
    p[0] = (unsigned char)(v & 0xffu);
    p[1] = (unsigned char)(v >> 8 & 0xffu);
    p[2] = (unsigned char)(v >> 16 & 0xffu);
    p[3] = (unsigned char)(v >> 24);
    return p + 4;
}

/** Eight bytes. */
static inline unsigned char *lum_put_le64(unsigned char *p, uint64_t v)
{
    if (LUM_IS_LITTLE_ENDIAN) {
        memcpy(p, &v, sizeof v);
        return p + sizeof v;
    }
    p = lum_put_le32(p, (uint32_t)(v & 0xffffffffu));
    return lum_put_le32(p, (uint32_t)(v >> 32));
}

/** An IEEE 754 single. */
static inline unsigned char *lum_put_f32(unsigned char *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return lum_put_le32(p, bits);
}

/** An IEEE 754 double. */
static inline unsigned char *lum_put_f64(unsigned char *p, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return lum_put_le64(p, bits);
}

/** The four bytes that lum_put_le32() wrote. */
static inline uint32_t lum_get_le32(const unsigned char *p)
{
    uint32_t v;
    if (LUM_IS_LITTLE_ENDIAN) {
        memcpy(&v, p, sizeof v);
        return v;
    }
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

/** Those of lum_put_f32(). */
static inline float lum_get_f32(const unsigned char *p)
{
    const uint32_t bits = lum_get_le32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/** A frame number in 32 bits; numbers beyond those become the nearest. */
static inline int32_t lum_frame_i32(int64_t frame)
{
    const int64_t low = frame < INT32_MIN ? INT32_MIN : frame;
    return (int32_t)(low > INT32_MAX ? INT32_MAX : low);
}

#endif
