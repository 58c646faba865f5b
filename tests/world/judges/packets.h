/* Datagrams in a capture as lumdump writes it: pcap and pcapng in the order of
 * this machine's bytes, Ethernet, IPv4 without options; MCAP with chunks that
 * are not compressed. */
#ifndef WORLD_PACKETS_H
#define WORLD_PACKETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum packets_step {
    PACKETS_ONE,
    PACKETS_END,   /* behind a whole record */
    PACKETS_CUT,   /* within a record */
    PACKETS_BROKEN /* what stands there is none */
} packets_step;

struct packets {
    const uint8_t *bytes;
    size_t size, at;
    packets_step (*next)(struct packets *packets, const uint8_t **payload,
                         size_t *len);
    unsigned channel; /* of MCAP: that of datagrams; 0: not yet known */
    size_t chunk_end; /* of MCAP: 0: between chunks */
};

/* False: the file's header is missing, or is not one. */
bool packets_open(struct packets *out, const uint8_t *bytes, size_t size);
packets_step packets_next(struct packets *packets, const uint8_t **payload,
                          size_t *len);

uint32_t packets_u16(const uint8_t *at);
uint32_t packets_u32(const uint8_t *at);

#endif
