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
    store_big_u16(p + 2, HEADERS_BYTES + whole);
    p[8] = IPV4_TTL;
    p[9] = IPV4_UDP;
    store_big_u32(p + 12, datagram->source);
    store_big_u32(p + 16, datagram->destination);
    store_big_u16(p + 20, datagram->source_port);
    store_big_u16(p + 22, datagram->destination_port);
    store_big_u16(p + 24, 8u + whole);
    if (datagram->len != 0) {
        memcpy(p + HEADERS_BYTES, datagram->payload, datagram->len);
    }
    *out = (lum_pcap_record){.time_ns = datagram->time_ns,
                             .bytes = p,
                             .len = HEADERS_BYTES + (uint32_t)datagram->len,
                             .whole = HEADERS_BYTES + whole,
                             .link_type = LUM_DATAGRAM_LINK_TYPE};
}

/* --- Of an MCAP file --- */

/* Each field follows the one before without padding. */
enum {
    SECONDS = 4,
    NANOSECONDS = 8,
    SOURCE = 12,
    SOURCE_PORT = 16,
    DESTINATION = 18,
    DESTINATION_PORT = 22,
    WHOLE = 24,
    COUNT = 28,
    DATA = 32,
    NANOSECONDS_PER_S = 1000000000
};

static uint32_t number(bool is_little, const uint8_t *p)
{
    return is_little ? load_u32(p) : load_big_u32(p);
}

static uint16_t port(bool is_little, const uint8_t *p)
{
    return is_little ? load_u16(p) : load_big_u16(p);
}

bool lum_mcap_datagram_read(const uint8_t *message, size_t len, lum_record *out,
                            uint32_t *whole)
{
    if (len < DATA || message[0] != 0 || message[1] > 1) {
        return false;
    }
    const bool is_little = message[1] == 1;
    const uint32_t nanoseconds = number(is_little, message + NANOSECONDS);
    const uint32_t sent = number(is_little, message + WHOLE);
    const uint32_t count = number(is_little, message + COUNT);
    if (count > len - DATA || count > sent ||
        nanoseconds >= NANOSECONDS_PER_S) {
        return false;
    }
    const int64_t seconds = (int32_t)number(is_little, message + SECONDS);
    *out = (lum_record){
        .time_ns = seconds * NANOSECONDS_PER_S + nanoseconds,
        .payload = message + DATA,
        .len = count,
        .source = load_big_u32(message + SOURCE),
        .destination = load_big_u32(message + DESTINATION),
        .source_port = port(is_little, message + SOURCE_PORT),
        .destination_port = port(is_little, message + DESTINATION_PORT),
        .kind = count < sent ? LUM_RECORD_CUT_SHORT : LUM_RECORD_DATAGRAM};
    *whole = sent;
    return true;
}
