/** @file
 * Link layers: from a captured frame to the IPv4 packet in it. Internal to
 * capture. */
#ifndef LUM_CAPTURE_LINK_H
#define LUM_CAPTURE_LINK_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Link types as files have them: https://www.tcpdump.org/linktypes.html */
enum {
    LINKTYPE_NULL = 0,
    LINKTYPE_ETHERNET = 1,
    LINKTYPE_RAW_OLD = 12, /**< some systems' own number of it */
    LINKTYPE_RAW = 101,
    LINKTYPE_LOOP = 108,
    LINKTYPE_LINUX_SLL = 113,
    LINKTYPE_IPV4 = 228,
    LINKTYPE_LINUX_SLL2 = 276
};

/** Bytes of headers, without tags and options. */
enum {
    ETHERNET_BYTES = 14,
    SLL_BYTES = 16,
    SLL2_BYTES = 20,
    IPV4_BYTES = 20,
    UDP_BYTES = 8
};

/** Some of a frame's bytes. */
typedef struct lum_span {
    const uint8_t *at; /**< the first */
    size_t len;        /**< how many */
} lum_span;

/** Find the IPv4 packet of a frame.
 * @param frame  the captured bytes; none outside of it is read.
 * @param packet gets the bytes behind the link layer's headers, padding
 *               included; written only on success.
 * @return whether the frame says that it holds IPv4. */
typedef bool lum_link_reader(lum_span frame, lum_span *packet);

/** The reader of a link type.
 * @param link_type as a file has it, a LINKTYPE_ value.
 * @return NULL if the type is not supported. */
LUM_MUST_CHECK lum_link_reader *lum_link_find(uint32_t link_type);

/** The link types that have a reader, in words, for messages. */
const char *lum_link_supported(void);

/** What a link type is called, for messages; "unknown" of most. */
const char *lum_link_name(uint32_t link_type);

/** Find a packet of a G2 that is not read as the frame stands: in a tunnel,
 * behind a switch's tags, or on a link layer that is not read.
 * @param frame the captured bytes; none outside of it is read.
 * @return bytes before its IPv4 header; 0: there is none, or it is read. */
size_t lum_link_find_hidden(uint32_t link_type, lum_span frame);

/** Bytes that every text of lum_link_fix() fits, the NUL included. */
#define LUM_LINK_FIX_BYTES 96u

/** What makes such a packet readable: a command, or how to record.
 * @param hidden_at from lum_link_find_hidden().
 * @return out. */
const char *lum_link_fix(uint32_t link_type, size_t hidden_at,
                         char out[LUM_LINK_FIX_BYTES]);

#endif
