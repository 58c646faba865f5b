/** @file
 * Bytes in memory that grow, and little-endian numbers, texts and lengths into
 * them. Without memory nothing is added any more, and failed says so: ask once
 * at the end. Internal to cloud. */
#ifndef LUM_CLOUD_BUFFER_H
#define LUM_CLOUD_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Some bytes; all 0 is none. */
typedef struct lum_bytes {
    unsigned char *at; /**< from realloc(); NULL: none yet */
    size_t len;        /**< how many */
    size_t room;       /**< as many fit */
    bool failed;       /**< no memory; what was added since is missing */
} lum_bytes;

/** Free them; then there are none. */
void lum_bytes_free(lum_bytes *bytes);

/** Append n bytes that the caller fills.
 * @return where; NULL: no memory. */
unsigned char *lum_bytes_extend(lum_bytes *bytes, size_t n);

/** Append n bytes. */
void lum_bytes_put(lum_bytes *bytes, const void *from, size_t n);

/** Append a number. */
void lum_bytes_put_u8(lum_bytes *bytes, uint8_t v);
void lum_bytes_put_u16(lum_bytes *bytes, uint16_t v);
void lum_bytes_put_u32(lum_bytes *bytes, uint32_t v);
void lum_bytes_put_u64(lum_bytes *bytes, uint64_t v);

/** Append a text with its length before it, in 32 bits. */
void lum_bytes_put_text(lum_bytes *bytes, const char *text);

/** Leave room for a length of 32 bits.
 * @return where it is, for lum_bytes_end_u32(). */
size_t lum_bytes_begin_u32(lum_bytes *bytes);

/** Write how many bytes came since, where that room was left. */
void lum_bytes_end_u32(lum_bytes *bytes, size_t at);

#endif
