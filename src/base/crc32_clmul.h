/** @file
 * CRC-32 by multiplication without carries, on processors that have it.
 * Internal to base. */
#ifndef LUM_BASE_CRC32_CLMUL_H
#define LUM_BASE_CRC32_CLMUL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes that are taken at least, and a multiple of which are. */
#define LUM_CRC32_CLMUL_LEAST 64u
#define LUM_CRC32_CLMUL_STEP  16u

/** Whether this processor has it. */
bool lum_crc32_has_clmul(void);

/** Go on with n more bytes, of which there are LUM_CRC32_CLMUL_LEAST at least
 * and a multiple of LUM_CRC32_CLMUL_STEP.
 * @param value as it is within the sum: all bits inverted. */
uint32_t lum_crc32_clmul(uint32_t value, const void *bytes, size_t n);

#endif
