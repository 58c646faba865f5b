#include "lum/host/yscan.h"

#include "../core/bytes.h"

lum_result lum_yscan_add(lum_tlv_writer *writer, uint16_t type,
                         const int16_t *elevations, size_t n)
{
    if (n > LUM_YSCAN_LINES_MAX) {
        return LUM_E_VALUE;
    }
    const size_t room = writer->size - writer->len;
    if (room < LUM_TLV_HEAD_BYTES || (room - LUM_TLV_HEAD_BYTES) / 2 < n) {
        return LUM_E_SPACE;
    }
    uint8_t *p = writer->out + writer->len;
    store_u16(p, type);
    store_u16(p + 2, (uint32_t)(2 * n));
    for (size_t i = 0; i < n; i++) {
        store_u16(p + LUM_TLV_HEAD_BYTES + 2 * i,
                  (uint32_t)elevations[i] & 0xffffu);
    }
    writer->len += LUM_TLV_HEAD_BYTES + 2 * n;
    return LUM_OK;
}

lum_result lum_yscan_decode(const lum_tlv *tlv, int16_t *out, size_t size,
                            size_t *n)
{
    const size_t lines = tlv->length / 2u;
    if (tlv->length % 2u != 0) {
        return LUM_E_MALFORMED;
    }
    if (lines > size) {
        return LUM_E_SPACE;
    }
    for (size_t i = 0; i < lines; i++) {
        out[i] = signed16(load_u16(tlv->value + 2 * i));
    }
    *n = lines;
    return LUM_OK;
}
