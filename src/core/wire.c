#include "lum/wire.h"

#include "bytes.h"

#include <string.h>

#define MAGIC_BYTES 8u

/* The magic, and where a packet's type goes. */
static const uint8_t header[LUM_HEADER_BYTES] = {0xed, 0xfe, 0xf3, 0xa1,
                                                 0xef, 0xbe, 0x34, 0x12};

lum_result lum_header_decode(const void *bytes, size_t len, uint8_t *type)
{
    const uint8_t *p = bytes;
    if (len < LUM_HEADER_BYTES || memcmp(p, header, MAGIC_BYTES) != 0) {
        return LUM_E_FOREIGN;
    }
    if ((p[9] | p[10] | p[11]) != 0) {
        return LUM_E_TYPE;
    }
    *type = p[8];
    return LUM_OK;
}

void lum_header_encode(uint8_t out[LUM_HEADER_BYTES], uint8_t type)
{
    memcpy(out, header, sizeof header);
    out[MAGIC_BYTES] = type;
}

void lum_heartbeat_encode(uint8_t out[LUM_HEARTBEAT_BYTES])
{
    lum_header_encode(out, LUM_TYPE_HEARTBEAT);
}

/* All packets but heartbeats and data go on with a word. */
static void encode_word(uint8_t *out, uint8_t type, uint32_t word)
{
    lum_header_encode(out, type);
    store_u32(out + LUM_HEADER_BYTES, word);
}

/* The checks that they share; of a timestamp, two words. */
static lum_result decode_word(const void *bytes, size_t len, uint8_t type,
                              uint32_t *word)
{
    const uint8_t *p = bytes;
    uint8_t found = 0;
    const lum_result r = lum_header_decode(bytes, len, &found);
    if (r != LUM_OK) {
        return r;
    }
    if (found != type) {
        return LUM_E_TYPE;
    }
    if (len < (type == LUM_TYPE_TIMESTAMP ? LUM_TIMESTAMP_BYTES
                                          : LUM_TLV_PACKET_BYTES)) {
        return LUM_E_SHORT;
    }
    *word = load_u32(p + LUM_HEADER_BYTES);
    return LUM_OK;
}

bool lum_address_is_host(uint32_t address)
{
    const bool is_multicast = (address >> 28) == 0xeu;
    return address != 0 && address != 0xffffffffu && !is_multicast;
}

/* An address as its little-endian word, and back. */
static uint32_t in_order(const lum_layout *layout, uint32_t address)
{
    if (layout->profile.set_ip_order != LUM_SET_IP_NETWORK) {
        return address;
    }
    return swapped32(address);
}

lum_result lum_set_ip_encode(uint8_t out[LUM_SET_IP_BYTES],
                             const lum_layout *layout, uint32_t address)
{
    if (!lum_address_is_host(address)) {
        return LUM_E_VALUE;
    }
    encode_word(out, LUM_TYPE_SET_IP, in_order(layout, address));
    return LUM_OK;
}

lum_result lum_set_ip_decode(const lum_layout *layout, const void *bytes,
                             size_t len, uint32_t *address)
{
    uint32_t word = 0;
    const lum_result r = decode_word(bytes, len, LUM_TYPE_SET_IP, &word);
    if (r == LUM_OK) {
        *address = in_order(layout, word);
    }
    return r;
}

void lum_timestamp_encode(uint8_t out[LUM_TIMESTAMP_BYTES],
                          const lum_timestamp *in)
{
    encode_word(out, LUM_TYPE_TIMESTAMP, in->sequence);
    store_u32(out + 16, in->clock_us);
}

lum_result lum_timestamp_decode(const void *bytes, size_t len,
                                lum_timestamp *out)
{
    const uint8_t *p = bytes;
    const lum_result r =
        decode_word(bytes, len, LUM_TYPE_TIMESTAMP, &out->sequence);
    if (r == LUM_OK) {
        out->clock_us = load_u32(p + 16);
    }
    return r;
}

lum_result lum_tlv_open(const void *bytes, size_t len, uint32_t *sequence,
                        lum_tlv_reader *reader)
{
    const uint8_t *p = bytes;
    const lum_result r = decode_word(bytes, len, LUM_TYPE_TLV, sequence);
    if (r == LUM_OK) {
        reader->next = p + LUM_TLV_PACKET_BYTES;
        reader->left = len - LUM_TLV_PACKET_BYTES;
    }
    return r;
}

lum_result lum_tlv_next(lum_tlv_reader *reader, lum_tlv *out)
{
    if (reader->left == 0) {
        return LUM_END;
    }
    const size_t left = reader->left;
    reader->left = 0;
    if (left < LUM_TLV_HEAD_BYTES) {
        return LUM_E_MALFORMED;
    }
    const uint16_t length = load_u16(reader->next + 2);
    if (left - LUM_TLV_HEAD_BYTES < length) {
        return LUM_E_MALFORMED;
    }
    out->type = load_u16(reader->next);
    out->length = length;
    out->value = reader->next + LUM_TLV_HEAD_BYTES;
    reader->next = out->value + length;
    reader->left = left - LUM_TLV_HEAD_BYTES - length;
    return LUM_OK;
}

lum_result lum_tlv_begin(lum_tlv_writer *writer, void *out, size_t size,
                         uint32_t sequence)
{
    uint8_t *p = out;
    if (size < LUM_TLV_PACKET_BYTES) {
        return LUM_E_SPACE;
    }
    encode_word(p, LUM_TYPE_TLV, sequence);
    *writer = (lum_tlv_writer){p, size, LUM_TLV_PACKET_BYTES};
    return LUM_OK;
}

lum_result lum_tlv_add(lum_tlv_writer *writer, uint16_t type, const void *value,
                       uint16_t length)
{
    uint8_t *p = writer->out + writer->len;
    const size_t room = writer->size - writer->len;
    if (room < LUM_TLV_HEAD_BYTES || room - LUM_TLV_HEAD_BYTES < length) {
        return LUM_E_SPACE;
    }
    store_u16(p, type);
    store_u16(p + 2, length);
    if (length > 0) {
        memcpy(p + LUM_TLV_HEAD_BYTES, value, length);
    }
    writer->len += LUM_TLV_HEAD_BYTES + (size_t)length;
    return LUM_OK;
}

lum_result lum_tlv_add_u16(lum_tlv_writer *writer, uint16_t type,
                           uint16_t value)
{
    uint8_t bytes[2];
    store_u16(bytes, value);
    return lum_tlv_add(writer, type, bytes, sizeof bytes);
}

lum_result lum_tlv_u16(const lum_tlv *tlv, uint16_t *out)
{
    if (tlv->length < 2) {
        return LUM_E_SHORT;
    }
    *out = load_u16(tlv->value);
    return LUM_OK;
}
