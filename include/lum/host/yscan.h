/** @file
 * The Y-scan table: one elevation for each line (docs/protocol.md,
 * section 4). How to fill it: lum/host/yscan_plan.h. */
#ifndef LUM_HOST_YSCAN_H
#define LUM_HOST_YSCAN_H

#include "lum/result.h"
#include "lum/wire.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most lines that fit the 16-bit length of a TLV. */
#define LUM_YSCAN_LINES_MAX 32767u

/** Append a Y-scan table to a TLV packet.
 * @param type       the number of LUM_TLV_YSCAN in the profile.
 * @param elevations raw, same scale as angle samples; n of them.
 * @return LUM_OK; LUM_E_VALUE if n is above LUM_YSCAN_LINES_MAX; LUM_E_SPACE
 *         if it does not fit. Linear in n. */
LUM_MUST_CHECK lum_result lum_yscan_add(lum_tlv_writer *writer, uint16_t type,
                                        const int16_t *elevations, size_t n);

/** Read a Y-scan table from a TLV.
 * @param out   room for size elevations; written only on LUM_OK.
 * @param n     gets how many the table has.
 * @return LUM_OK; LUM_E_MALFORMED if the value's length is odd; LUM_E_SPACE if
 *         it has more than size. Linear in n. */
LUM_MUST_CHECK lum_result lum_yscan_decode(const lum_tlv *tlv, int16_t *out,
                                           size_t size, size_t *n);

#ifdef __cplusplus
}
#endif

#endif
