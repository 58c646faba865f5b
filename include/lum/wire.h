/** @file
 * Packets other than data: header, set IP, timestamp, heartbeat, TLV
 * (docs/protocol.md, sections 1 to 4 and 6). Encoder and decoder of each.
 *
 * Input may have any length and any alignment and is not kept. Outputs are
 * written only on LUM_OK. Everything here is reentrant, takes constant time
 * (except that TLV values are copied), and allocates nothing. */
#ifndef LUM_WIRE_H
#define LUM_WIRE_H

#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LUM_PORT             5517u       /**< the sensor's UDP port */
#define LUM_BOOT_ADDRESS     0x0a2a0025u /**< 10.42.0.37, after power-up */
#define LUM_HEADER_BYTES     12u         /**< magic and packet type */
#define LUM_HEARTBEAT_BYTES  12u         /**< a heartbeat is a bare header */
#define LUM_SET_IP_BYTES     16u         /**< a set IP packet */
#define LUM_TIMESTAMP_BYTES  20u         /**< a timestamp packet */
#define LUM_TLV_PACKET_BYTES 16u         /**< a TLV packet without TLVs */
#define LUM_TLV_HEAD_BYTES   4u          /**< type and length of one TLV */

#define LUM_HEARTBEAT_MS     200u  /**< between two: five a second */
#define LUM_HEARTBEAT_MAX_MS 1000u /**< longest allowed time between two */

/** Time after the last heartbeat when the sensor stops data and laser. */
#define LUM_HEARTBEAT_TIMEOUT_MS 3000u

/** Packet types, byte 8 of the header. */
enum lum_packet_type {
    LUM_TYPE_SET_IP = 5,    /**< new address, client to sensor */
    LUM_TYPE_TIMESTAMP = 6, /**< clock request and answer */
    LUM_TYPE_TLV = 7,       /**< commands, status, text */
    LUM_TYPE_HEARTBEAT = 8  /**< keeps laser and data alive */
};

/** Read a packet's header (section 1).
 * @param type gets byte 8, known or not.
 * @return LUM_OK; LUM_E_FOREIGN if shorter than 12 bytes or without the
 *         magic; LUM_E_TYPE if a reserved byte is set. */
LUM_MUST_CHECK lum_result lum_header_decode(const void *bytes, size_t len,
                                            uint8_t *type);

/** Write a header (section 1). Cannot fail. */
void lum_header_encode(uint8_t out[LUM_HEADER_BYTES], uint8_t type);

/** Write a heartbeat (section 6). Cannot fail. */
void lum_heartbeat_encode(uint8_t out[LUM_HEARTBEAT_BYTES]);

/** Whether an address can be that of one host, and so of a sensor: all but
 * 0.0.0.0, multicast and 255.255.255.255.
 * @param address host order, 10.42.0.37 is 0x0a2a0025. */
bool lum_address_is_host(uint32_t address);

/** Write a set IP packet (section 2).
 * @param address host order.
 * @return LUM_OK; LUM_E_VALUE if lum_address_is_host() is false. */
LUM_MUST_CHECK lum_result lum_set_ip_encode(uint8_t out[LUM_SET_IP_BYTES],
                                            const lum_layout *layout,
                                            uint32_t address);

/** Read a set IP packet (section 2).
 * @param address host order; any value, also one the encoder refuses.
 * @return LUM_OK; as lum_header_decode(); LUM_E_TYPE if of another type;
 *         LUM_E_SHORT below 16 bytes. */
LUM_MUST_CHECK lum_result lum_set_ip_decode(const lum_layout *layout,
                                            const void *bytes, size_t len,
                                            uint32_t *address);

/** A timestamp packet (section 3). */
typedef struct lum_timestamp {
    uint32_t sequence; /**< an answer repeats the request's */
    uint32_t clock_us; /**< sensor clock, wraps at 2^32; 0 in a request */
} lum_timestamp;

/** Write a timestamp packet (section 3). Cannot fail. */
void lum_timestamp_encode(uint8_t out[LUM_TIMESTAMP_BYTES],
                          const lum_timestamp *in);

/** Read a timestamp packet (section 3).
 * @return LUM_OK; as lum_header_decode(); LUM_E_TYPE if of another type;
 *         LUM_E_SHORT below 20 bytes. */
LUM_MUST_CHECK lum_result lum_timestamp_decode(const void *bytes, size_t len,
                                               lum_timestamp *out);

/** One TLV of a packet (section 4). */
typedef struct lum_tlv {
    uint16_t type;        /**< as on the wire, see lum_profile.tlv */
    uint16_t length;      /**< bytes of value, 0..65535 */
    const uint8_t *value; /**< inside the packet; lives as long as it does */
} lum_tlv;

/** The state of an iteration over a packet's TLVs. Only its size is public. */
typedef struct lum_tlv_reader {
    const uint8_t *next; /**< first byte not read */
    size_t left;         /**< bytes from there */
} lum_tlv_reader;

/** Begin to read a TLV packet (section 4).
 * @param sequence gets the packet's sequence number.
 * @param reader   keeps pointing into bytes.
 * @return LUM_OK; as lum_header_decode(); LUM_E_TYPE if of another type;
 *         LUM_E_SHORT below 16 bytes. */
LUM_MUST_CHECK lum_result lum_tlv_open(const void *bytes, size_t len,
                                       uint32_t *sequence,
                                       lum_tlv_reader *reader);

/** Read the next TLV.
 * @return LUM_OK; LUM_END when none is left; LUM_E_MALFORMED when the bytes
 *         left cannot hold the TLV they announce (and from then on LUM_END). */
LUM_MUST_CHECK lum_result lum_tlv_next(lum_tlv_reader *reader, lum_tlv *out);

/** A TLV packet being written. */
typedef struct lum_tlv_writer {
    uint8_t *out; /**< the caller's buffer */
    size_t size;  /**< its bytes */
    size_t len;   /**< bytes written: the packet's length so far */
} lum_tlv_writer;

/** Begin to write a TLV packet (section 4). Without any TLV it is a legal
 * packet, which asks the sensor for its status.
 * @param out kept; caller-owned.
 * @return LUM_OK; LUM_E_SPACE if size is below 16. */
LUM_MUST_CHECK lum_result lum_tlv_begin(lum_tlv_writer *writer, void *out,
                                        size_t size, uint32_t sequence);

/** Append a TLV.
 * @param value length bytes; may be NULL when length is 0.
 * @return LUM_OK; LUM_E_SPACE if it does not fit, then nothing is written. */
LUM_MUST_CHECK lum_result lum_tlv_add(lum_tlv_writer *writer, uint16_t type,
                                      const void *value, uint16_t length);

/** Append a TLV with one u16, such as a status. As lum_tlv_add(). */
LUM_MUST_CHECK lum_result lum_tlv_add_u16(lum_tlv_writer *writer, uint16_t type,
                                          uint16_t value);

/** Read a TLV that holds one u16, such as a status.
 * @return LUM_OK; LUM_E_SHORT if its value is shorter than two bytes. */
LUM_MUST_CHECK lum_result lum_tlv_u16(const lum_tlv *tlv, uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
