#include "packets.h"

#include <string.h>

#define PCAP_HEADER   24u
#define PCAP_RECORD   16u
#define PCAPNG_RECORD 28u
#define PCAPNG_PACKET 6u
#define FRAME_HEADERS 42u /* Ethernet, IPv4, UDP */
#define UDP_HEADER    8u
#define LONGEST       262144u

#define MCAP_MAGIC      8u
#define MCAP_HEAD       9u  /* type and length of a record */
#define MCAP_CHUNK_HEAD 40u /* before its records */
#define MCAP_DATAGRAM   54u /* before it, in its message */

enum {
    MCAP_FOOTER = 2,
    MCAP_CHANNEL = 4,
    MCAP_MESSAGE = 5,
    MCAP_CHUNK = 6
};

uint32_t packets_u16(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

uint32_t packets_u32(const uint8_t *at)
{
    return packets_u16(at) | packets_u16(at + 2) << 16;
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

/* --- MCAP --- */

static void note_channel(struct packets *p, const uint8_t *channel, size_t size)
{
    static const char topic[] = "/datagrams";
    const size_t len = sizeof topic - 1u;
    if (size >= 8u + len && packets_u32(channel + 4) == len &&
        memcmp(channel + 8, topic, len) == 0) {
        p->channel = packets_u16(channel);
    }
}

/* A datagram stands behind the channel, the number, both times, and what
 * comes before it in its message. */
static packets_step take_message(const struct packets *p,
                                 const uint8_t *message, size_t size,
                                 const uint8_t **payload, size_t *len)
{
    if (size < 22u) {
        return PACKETS_BROKEN;
    }
    if (p->channel == 0 || packets_u16(message) != p->channel) {
        return PACKETS_END; /* of this record */
    }
    if (size < MCAP_DATAGRAM || packets_u32(message + 50) != size - 54u) {
        return PACKETS_BROKEN;
    }
    *payload = message + MCAP_DATAGRAM;
    *len = size - MCAP_DATAGRAM;
    return PACKETS_ONE;
}

static packets_step take_record(struct packets *p, unsigned op,
                                const uint8_t *record, size_t size,
                                const uint8_t **payload, size_t *len)
{
    if (op == MCAP_CHANNEL) {
        note_channel(p, record, size);
    }
    return op == MCAP_MESSAGE ? take_message(p, record, size, payload, len)
                              : PACKETS_END;
}

/* Into a chunk, which is not compressed. */
static bool enter_chunk(struct packets *p, size_t size)
{
    const uint8_t *chunk = p->bytes + p->at + MCAP_HEAD;
    if (size < MCAP_CHUNK_HEAD || packets_u32(chunk + 28) != 0) {
        return false;
    }
    p->chunk_end = p->at + MCAP_HEAD + size;
    p->at += MCAP_HEAD + MCAP_CHUNK_HEAD;
    return true;
}

/* Its length, if all of it is there. */
static bool has_record(struct packets *p, size_t *size)
{
    p->chunk_end = p->at < p->chunk_end ? p->chunk_end : 0;
    const size_t left = (p->chunk_end != 0 ? p->chunk_end : p->size) - p->at;
    *size = left >= MCAP_HEAD ? packets_u32(p->bytes + p->at + 1) : 0;
    return left >= MCAP_HEAD && *size <= left - MCAP_HEAD;
}

static packets_step next_mcap(struct packets *p, const uint8_t **payload,
                              size_t *len)
{
    packets_step step = PACKETS_END;
    size_t size = 0;
    while (step == PACKETS_END && has_record(p, &size)) {
        const uint8_t *at = p->bytes + p->at;
        if (at[0] == MCAP_FOOTER) {
            const size_t after = p->size - p->at - MCAP_HEAD - size;
            return after == MCAP_MAGIC ? PACKETS_END : PACKETS_CUT;
        }
        if (at[0] == MCAP_CHUNK) {
            step = enter_chunk(p, size) ? PACKETS_END : PACKETS_BROKEN;
        } else {
            p->at += MCAP_HEAD + size;
            step = take_record(p, at[0], at + MCAP_HEAD, size, payload, len);
        }
    }
    if (step != PACKETS_END) {
        return step;
    }
    return p->chunk_end != 0 ? PACKETS_BROKEN : PACKETS_CUT;
}

/* --- All of them --- */

bool packets_open(struct packets *out, const uint8_t *bytes, size_t size)
{
    static const struct {
        uint32_t magic;
        size_t header;
        packets_step (*next)(struct packets *packets, const uint8_t **payload,
                             size_t *len);
    } kinds[] = {{0x0a0d0d0au, 0, next_pcapng},
                 {0xa1b23c4du, PCAP_HEADER, next_pcap},
                 {0xa1b2c3d4u, PCAP_HEADER, next_pcap},
                 {0x41434d89u, MCAP_MAGIC, next_mcap}};
    *out = (struct packets){.bytes = bytes, .size = size};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (size >= PCAP_HEADER && packets_u32(bytes) == kinds[i].magic) {
            out->at = kinds[i].header;
            out->next = kinds[i].next;
            return true;
        }
    }
    return false;
}

packets_step packets_next(struct packets *packets, const uint8_t **payload,
                          size_t *len)
{
    return packets->next(packets, payload, len);
}
