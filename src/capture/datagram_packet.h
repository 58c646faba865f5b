/** @file
 * A datagram of a recording without packets as an IPv4 packet, which is what
 * readers of captures hand out. Internal to the capture room. */
#ifndef LUM_CAPTURE_DATAGRAM_PACKET_H
#define LUM_CAPTURE_DATAGRAM_PACKET_H

#include "pcap.h"

#include "lum/capture/record.h"

/** Most bytes of a datagram. */
#define LUM_DATAGRAM_BYTES_MAX 65507u

/** Most bytes of its packet. */
#define LUM_DATAGRAM_PACKET_MAX (28u + LUM_DATAGRAM_BYTES_MAX)

/** Its link type. */
#define LUM_DATAGRAM_LINK_TYPE 228u

/** Make a packet.
 * @param whole bytes that were sent, at least those that are there; at most
 *              LUM_DATAGRAM_BYTES_MAX.
 * @param room  LUM_DATAGRAM_PACKET_MAX bytes, which out points to. */
void lum_datagram_packet_make(const lum_record *datagram, uint32_t whole,
                              uint8_t *room, lum_pcap_record *out);

#endif
