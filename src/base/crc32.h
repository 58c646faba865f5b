/** @file
 * The CRC-32 of zip, PNG and MCAP. Internal. */
#ifndef LUM_BASE_CRC32_H
#define LUM_BASE_CRC32_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** What it is computed by. */
typedef struct lum_crc32 {
    uint32_t table[16][256]; /**< [k][b]: byte b with k zero bytes behind it */
    bool has_clmul;          /**< the processor is faster without them */
} lum_crc32;

/** Make the tables. */
void lum_crc32_init(lum_crc32 *crc);

/** Go on with n more bytes.
 * @param value of the bytes before; 0: there are none.
 * @return the CRC of all of them. */
uint32_t lum_crc32_add(const lum_crc32 *crc, uint32_t value, const void *bytes,
                       size_t n);

#endif
