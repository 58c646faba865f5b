/** @file
 * IPv4 and UDP headers, and the reassembly of fragmented datagrams. Internal to
 * capture.
 *
 * Fragments wait by source, destination and id (the protocol is UDP). They are
 * dropped when more than LUM_FRAGMENTS_WAIT_NS of capture time has passed since
 * the first of their datagram came, oldest first when more than
 * LUM_FRAGMENTS_DATAGRAMS wait, and with a fragment that overlaps one of them
 * or contradicts their end. A fragment that only repeats what is there is
 * ignored, also for LUM_FRAGMENTS_WAIT_NS from the first on if its datagram is
 * complete: as many of those as have room beside the waiting ones are known,
 * the latest. */
#ifndef LUM_CAPTURE_FRAGMENTS_H
#define LUM_CAPTURE_FRAGMENTS_H

#include "base/pack.h"
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

/** Most datagrams that wait at a time, or are complete and still known. */
#define LUM_FRAGMENTS_DATAGRAMS 64u

/** How long fragments wait, in capture time. */
#define LUM_FRAGMENTS_WAIT_NS INT64_C(500000000)

/** Datagrams whose fragments wait: 66 KB for each of them, kept
 * until lum_fragments_free(). */
typedef struct lum_fragments lum_fragments;

/** An empty one.
 * @return NULL if there is no memory; freed by lum_fragments_free(). */
LUM_MUST_CHECK lum_fragments *lum_fragments_new(void);

/** Free. NULL is allowed. */
void lum_fragments_free(lum_fragments *fragments);

/** Take a fragment in.
 * @param record its time and addresses are read. Its kind becomes
 *               ::LUM_RECORD_FRAGMENT if the fragment waits or is a repeat;
 *               ::LUM_RECORD_DATAGRAM, with ports and a payload that lives
 *               until the next call, if it completes one; ::LUM_RECORD_OTHER if
 *               it is dropped (also for want of memory) or what it completes is
 *               no datagram. dropped_fragments grows by the others that are
 *               dropped. */
void lum_fragments_add(lum_fragments *fragments, const lum_fragment *fragment,
                       lum_record *record);

/** Those that wait, in either direction; a fragment read behind that repeats
 * nothing of what was complete.
 * @return false if something failed; then none waits. */
bool lum_fragments_pack(lum_fragments *fragments, lum_pack *pack);

/** Drop those that have waited too long.
 * @param now_ns within +-2^62.
 * @return how many fragments. */
uint32_t lum_fragments_expire(lum_fragments *fragments, int64_t now_ns);

/** Drop all.
 * @return how many fragments. */
uint32_t lum_fragments_drop_all(lum_fragments *fragments);

#endif
