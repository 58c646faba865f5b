#include "lum/packet.h"

#include "lum/wire.h"

static lum_packet_kind decode_data(const lum_layout *layout, const void *bytes,
                                   size_t len, lum_group *group)
{
    const lum_result r = lum_group_decode(layout, bytes, len, group);
    if (r == LUM_OK) {
        return LUM_PACKET_DATA;
    }
    return r == LUM_E_UNKNOWN_TAG ? LUM_PACKET_UNKNOWN_TAG
                                  : LUM_PACKET_MALFORMED;
}

static lum_packet_kind at_least(size_t len, size_t least, lum_packet_kind kind)
{
    return len < least ? LUM_PACKET_MALFORMED : kind;
}

static bool is_data_type(const lum_profile *p, uint8_t type)
{
    if (p->group[LUM_FIELD_TAG].at < LUM_HEADER_BYTES) {
        return type == LUM_TAG_ANGLES || type == LUM_TAG_RANGES;
    }
    return type == p->data_packet_type;
}

lum_packet_kind lum_packet_decode(const lum_layout *layout, const void *bytes,
                                  size_t len, lum_group *group)
{
    uint8_t type = 0;
    const lum_result r = lum_header_decode(bytes, len, &type);
    if (r != LUM_OK) {
        return r == LUM_E_TYPE ? LUM_PACKET_UNKNOWN_TYPE : LUM_PACKET_FOREIGN;
    }
    if (type == LUM_TYPE_HEARTBEAT && len == LUM_HEARTBEAT_BYTES) {
        return LUM_PACKET_HEARTBEAT;
    }
    if (is_data_type(&layout->profile, type)) {
        return decode_data(layout, bytes, len, group);
    }
    switch (type) {
    case LUM_TYPE_SET_IP:
        return at_least(len, LUM_SET_IP_BYTES, LUM_PACKET_SET_IP);
    case LUM_TYPE_TIMESTAMP:
        return at_least(len, LUM_TIMESTAMP_BYTES, LUM_PACKET_TIMESTAMP);
    case LUM_TYPE_TLV:
        return at_least(len, LUM_TLV_PACKET_BYTES, LUM_PACKET_TLV);
    default:
        return LUM_PACKET_UNKNOWN_TYPE;
    }
}
