/** @file
 * The kind of packet in a datagram (docs/protocol.md, sections 1, 6 and 9). */
#ifndef LUM_PACKET_H
#define LUM_PACKET_H

#include "lum/group.h"
#include "lum/profile.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Kinds of packets, including rejected ones; usable as an index of
 * counters. */
typedef enum lum_packet_kind {
    LUM_PACKET_DATA,         /**< angles or ranges */
    LUM_PACKET_HEARTBEAT,    /**< type 8 of exactly 12 bytes */
    LUM_PACKET_SET_IP,       /**< type 5 */
    LUM_PACKET_TIMESTAMP,    /**< type 6 */
    LUM_PACKET_TLV,          /**< type 7; its TLVs are not checked */
    LUM_PACKET_FOREIGN,      /**< no magic, or shorter than a header */
    LUM_PACKET_UNKNOWN_TYPE, /**< magic, and an unknown type */
    LUM_PACKET_MALFORMED,    /**< too short, or impossible fields */
    LUM_PACKET_UNKNOWN_TAG,  /**< data, neither angles nor ranges */
    LUM_PACKET_KINDS         /**< how many there are */
} lum_packet_kind;

/** Find out a datagram's kind, and read it if it is data.
 * @param bytes any length, any alignment; kept only by group->samples.
 * @param group written only when the answer is LUM_PACKET_DATA.
 * Constant time, reentrant. */
lum_packet_kind lum_packet_decode(const lum_layout *layout, const void *bytes,
                                  size_t len, lum_group *group);

#ifdef __cplusplus
}
#endif

#endif
