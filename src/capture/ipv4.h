/** @file
 * IPv4 and UDP headers. Internal to capture. */
#ifndef LUM_CAPTURE_IPV4_H
#define LUM_CAPTURE_IPV4_H

#include "link.h"
#include "lum/capture/capture.h"

/** Most bytes of an IPv4 packet, header included. */
#define LUM_IPV4_BYTES_MAX 65535u

/** What of a fragment the record does not say. It ends within what one packet
 * can be, and but for the last one at a multiple of 8. */
typedef struct lum_fragment {
    lum_span data;   /**< its part of the datagram, UDP header included */
    uint32_t offset; /**< of data in the datagram, in bytes */
    uint16_t id;     /**< identification */
    bool more;       /**< whether others follow behind it */
} lum_fragment;

/** Tell what an IPv4 packet is.
 * @param packet   as the capture holds it, padding included; none outside of
 *                 it is read.
 * @param out      its kind is set; the addresses, ports and payload as far as
 *                 the kind has them (lum_record); all else is left alone.
 *                 ::LUM_RECORD_FRAGMENT is a fragment of UDP, whole.
 * @param fragment written only for fragments. */
void lum_ipv4_read(lum_span packet, lum_record *out, lum_fragment *fragment);

/** Tell what the payload of an IPv4 packet with UDP is.
 * @param udp   the bytes held.
 * @param whole the bytes there were, udp.len or more.
 * @param out   as lum_ipv4_read(), but for the addresses. */
void lum_udp_read(lum_span udp, size_t whole, lum_record *out);

#endif
