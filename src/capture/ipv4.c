#include "ipv4.h"

#include "byte_order.h"

enum {
    PROTOCOL_UDP = 17,
    MORE_FRAGMENTS = 0x2000,
    OFFSET_MASK = 0x1fff
};

/* The fields of a header that is held whole but for its options. */
typedef struct header {
    size_t len;
    size_t total;
    unsigned fragment; /* flags and offset */
    uint16_t id;
} header;

static bool read_header(lum_span packet, header *out)
{
    const uint8_t *p = packet.at;
    if (packet.len < IPV4_BYTES || p[0] >> 4 != 4 || p[9] != PROTOCOL_UDP) {
        return false;
    }
    out->len = (size_t)(p[0] & 0x0fu) * 4u;
    out->total = load_big_u16(p + 2);
    out->id = load_big_u16(p + 4);
    out->fragment = load_big_u16(p + 6);
    return out->len >= IPV4_BYTES && out->total >= out->len;
}

static lum_span payload_of(lum_span packet, const header *ip)
{
    const size_t held = packet.len < ip->total ? packet.len : ip->total;
    if (held < ip->len) {
        return (lum_span){packet.at, 0};
    }
    return (lum_span){packet.at + ip->len, held - ip->len};
}

/* Of a datagram whose fragments are cut, the first one stands for it. */
static void read_fragment(lum_span data, const header *ip, lum_record *out,
                          lum_fragment *fragment)
{
    const size_t whole = ip->total - ip->len;
    const bool more = (ip->fragment & MORE_FRAGMENTS) != 0;
    const uint32_t offset = (ip->fragment & OFFSET_MASK) * 8u;
    out->kind = LUM_RECORD_OTHER;
    if (whole == 0 || (more && whole % 8u != 0) ||
        ip->len + offset + whole > LUM_IPV4_BYTES_MAX) {
        return;
    }
    if (data.len < whole) {
        if (offset == 0) {
            lum_udp_read(data, LUM_IPV4_BYTES_MAX, out);
        }
        return;
    }
    *fragment = (lum_fragment){data, offset, ip->id, more};
    out->kind = LUM_RECORD_FRAGMENT;
}

void lum_udp_read(lum_span udp, size_t whole, lum_record *out)
{
    const bool has_ports = udp.len >= 4;
    const bool has_length = udp.len >= 6;
    out->source_port = has_ports ? load_big_u16(udp.at) : 0;
    out->destination_port = has_ports ? load_big_u16(udp.at + 2) : 0;
    const size_t len = has_length ? load_big_u16(udp.at + 4) : UDP_BYTES;
    if (len < UDP_BYTES || len > whole) {
        out->kind = LUM_RECORD_OTHER;
    } else if (udp.len < whole) {
        out->kind = LUM_RECORD_CUT_SHORT;
    } else {
        out->payload = udp.at + UDP_BYTES;
        out->len = len - UDP_BYTES;
        out->kind = LUM_RECORD_DATAGRAM;
    }
}

void lum_ipv4_read(lum_span packet, lum_record *out, lum_fragment *fragment)
{
    header ip;
    if (!read_header(packet, &ip)) {
        out->kind = LUM_RECORD_OTHER;
        return;
    }
    out->source = load_big_u32(packet.at + 12);
    out->destination = load_big_u32(packet.at + 16);
    const lum_span data = payload_of(packet, &ip);
    if ((ip.fragment & (MORE_FRAGMENTS | OFFSET_MASK)) != 0) {
        read_fragment(data, &ip, out, fragment);
    } else {
        lum_udp_read(data, ip.total - ip.len, out);
    }
}
