/** @file
 * A datagram of a recording without packets (a bag, an MCAP file) as an IPv4
 * packet, which is what readers of captures hand out. Internal to the capture
 * room. */
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

/** Read a message of lumsdk_msgs/msg/Datagram.
 * @param message its bytes, with the header of CDR; either byte order.
 * @param out     gets the datagram; its payload lies in the message. Cut short
 *                if the message has less of it than was sent.
 * @param whole   gets the bytes that were sent, as the message says.
 * @return false if it is no such message; out is as it was. */
bool lum_mcap_datagram_read(const uint8_t *message, size_t len, lum_record *out,
                            uint32_t *whole);

#endif
