#include "packets.h"

#define PCAP_HEADER   24u
#define PCAP_RECORD   16u
#define PCAPNG_RECORD 28u
#define PCAPNG_PACKET 6u
#define FRAME_HEADERS 42u /* Ethernet, IPv4, UDP */
#define UDP_HEADER    8u
#define LONGEST       262144u

uint32_t packets_u16(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

uint32_t packets_u32(const uint8_t *at)
{
    return packets_u16(at) | packets_u16(at + 2) << 16;
}

bool packets_open(struct packets *out, const uint8_t *bytes, size_t size)
{
    *out = (struct packets){.bytes = bytes, .size = size};
    if (size < PCAP_HEADER) {
        return false;
    }
    const uint32_t magic = packets_u32(bytes);
    out->is_pcapng = magic == 0x0a0d0d0au;
    out->at = out->is_pcapng ? 0 : PCAP_HEADER;
    return out->is_pcapng || magic == 0xa1b23c4du || magic == 0xa1b2c3d4u;
}

/* The payload of the frame at a place. */
static packets_step take_frame(const uint8_t *frame, size_t size,
                               const uint8_t **payload, size_t *len)
{
    if (size < FRAME_HEADERS) {
        return PACKETS_BROKEN;
    }
    const size_t udp = (size_t)frame[38] << 8 | frame[39];
    if (udp < UDP_HEADER || udp - UDP_HEADER != size - FRAME_HEADERS) {
        return PACKETS_BROKEN;
    }
    *payload = frame + FRAME_HEADERS;
    *len = udp - UDP_HEADER;
    return PACKETS_ONE;
}

static packets_step next_pcap(struct packets *p, const uint8_t **payload,
                              size_t *len)
{
    const uint8_t *at = p->bytes + p->at;
    const size_t left = p->size - p->at;
    if (left == 0) {
        return PACKETS_END;
    }
    if (left < PCAP_RECORD) {
        return PACKETS_CUT;
    }
    const size_t size = packets_u32(at + 8);
    if (size > LONGEST || size != packets_u32(at + 12)) {
        return PACKETS_BROKEN;
    }
    if (size > left - PCAP_RECORD) {
        return PACKETS_CUT;
    }
    p->at += PCAP_RECORD + size;
    return take_frame(at + PCAP_RECORD, size, payload, len);
}

static packets_step next_pcapng(struct packets *p, const uint8_t **payload,
                                size_t *len)
{
    while (p->size - p->at > 0) {
        const uint8_t *at = p->bytes + p->at;
        const size_t left = p->size - p->at;
        const size_t size = left >= 8 ? packets_u32(at + 4) : 0;
        if (left < 8 || size > left) {
            return PACKETS_CUT;
        }
        if (size < 12 || size % 4 != 0 || packets_u32(at + size - 4) != size) {
            return PACKETS_BROKEN;
        }
        p->at += size;
        if (packets_u32(at) == PCAPNG_PACKET) {
            const size_t frame = packets_u32(at + 20);
            return size < PCAPNG_RECORD + 4 || frame > size - PCAPNG_RECORD
                       ? PACKETS_BROKEN
                       : take_frame(at + PCAPNG_RECORD, frame, payload, len);
        }
    }
    return PACKETS_END;
}

packets_step packets_next(struct packets *packets, const uint8_t **payload,
                          size_t *len)
{
    return packets->is_pcapng ? next_pcapng(packets, payload, len)
                              : next_pcap(packets, payload, len);
}
