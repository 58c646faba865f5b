/** @file
 * Numbers as bytes and back. One function describes a state for both
 * directions, so that what is read is what was written. The bytes are the same
 * on every machine: seven bits a byte, the lowest first. Internal. */
#ifndef LUM_BASE_PACK_H
#define LUM_BASE_PACK_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes that are written or read. All bytes 0: nothing is written yet. */
typedef struct lum_pack {
    uint8_t *written;   /**< to be freed; NULL while nothing is */
    size_t room;        /**< of written */
    const uint8_t *end; /**< of what is read; NULL: it is written */
    const uint8_t *at;  /**< next to be read */
    size_t len;         /**< bytes written */
    bool has_failed;    /**< no memory, or bytes that mean nothing; then no more
                             is written, and all that is read is 0 */
} lum_pack;

/** Read these bytes. */
lum_pack lum_pack_of(const void *bytes, size_t len);

static inline bool lum_pack_is_reading(const lum_pack *pack)
{
    return pack->end != NULL;
}

/** Free what was written, and begin anew. */
void lum_pack_reset(lum_pack *pack);

/** A number in either direction. What does not fit its type fails. */
void lum_pack_u64(lum_pack *pack, uint64_t *value);
void lum_pack_u32(lum_pack *pack, uint32_t *value);
void lum_pack_u16(lum_pack *pack, uint16_t *value);
void lum_pack_u8(lum_pack *pack, uint8_t *value);
void lum_pack_bool(lum_pack *pack, bool *value);
void lum_pack_i64(lum_pack *pack, int64_t *value);

/** A number that is near another, within 64 bits. */
void lum_pack_near(lum_pack *pack, int64_t *value, int64_t other);

/** Bytes as they are. */
void lum_pack_bytes(lum_pack *pack, void *bytes, size_t len);

/** A text in an array of so many bytes, at most 256. */
void lum_pack_text(lum_pack *pack, char *text, size_t room);

/** Fail unless what was read is possible.
 * @return whether nothing has failed. */
bool lum_pack_check(lum_pack *pack, bool is_possible);

#endif
