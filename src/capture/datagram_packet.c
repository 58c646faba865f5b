#include "datagram_packet.h"

#include "byte_order.h"
#include "link.h"

#include <string.h>

enum {
    HEADERS_BYTES = IPV4_BYTES + UDP_BYTES,
    IPV4_VERSION_AND_WORDS = 0x45,
    IPV4_TTL = 64,
    IPV4_UDP = 17
};

void lum_datagram_packet_make(const lum_record *datagram, uint32_t whole,
                              uint8_t *room, lum_pcap_record *out)
{
    uint8_t *p = room;
    memset(p, 0, HEADERS_BYTES);
    p[0] = IPV4_VERSION_AND_WORDS;
    store_be16(p + 2, HEADERS_BYTES + whole);
    p[8] = IPV4_TTL;
    p[9] = IPV4_UDP;
    store_be32(p + 12, datagram->source);
    store_be32(p + 16, datagram->destination);
    store_be16(p + 20, datagram->source_port);
    store_be16(p + 22, datagram->destination_port);
    store_be16(p + 24, 8u + whole);
    if (datagram->len != 0) {
        memcpy(p + HEADERS_BYTES, datagram->payload, datagram->len);
    }
    *out = (lum_pcap_record){.time_ns = datagram->time_ns,
                             .bytes = p,
                             .len = HEADERS_BYTES + (uint32_t)datagram->len,
                             .whole = HEADERS_BYTES + whole,
                             .link_type = LUM_DATAGRAM_LINK_TYPE};
}
