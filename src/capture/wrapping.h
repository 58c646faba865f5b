/** @file
 * What packets of a G2 are wrapped in where a capture has them in a way that is
 * not read: tunnels of mirror ports, tags of switches, other link layers. It
 * only names them, and the command that takes them off. Internal to capture. */
#ifndef LUM_CAPTURE_WRAPPING_H
#define LUM_CAPTURE_WRAPPING_H

#include "link.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Most wrappings of a frame that are named. */
#define LUM_WRAPPINGS_MAX 4u

/** Bytes that every text of lum_wrapping_name() and lum_wrapping_remedy()
 * fits, the NUL included. */
#define LUM_WRAPPING_TEXT_BYTES 160u

/** What a frame is wrapped in. Equal ones have equal bytes. */
typedef struct lum_wrapping {
    uint32_t link_type;               /**< of the frame, a LINKTYPE_ value */
    uint16_t cut;                     /**< bytes before what is wrapped */
    uint8_t kinds[LUM_WRAPPINGS_MAX]; /**< from the outside; 0: no more */
    uint8_t is_ethernet; /**< that is an Ethernet frame; 0: an IPv4 packet */
    uint8_t has_no_cut;  /**< bytes taken off would not help */
} lum_wrapping;

/** What looking at a frame shows. */
typedef enum lum_wrapped {
    LUM_WRAPPED_NOT,   /**< in nothing that is known */
    LUM_WRAPPED_OTHER, /**< in something; what is inside is not of a G2, or was
                            not found */
    LUM_WRAPPED_OURS   /**< a packet of a G2 is inside */
} lum_wrapped;

/** Look at a frame that is read as no datagram of a G2.
 * @param frame the captured bytes; none outside of it is read.
 * @param out   written unless the result is ::LUM_WRAPPED_NOT. */
LUM_MUST_CHECK lum_wrapped lum_wrapping_find(uint32_t link_type, lum_span frame,
                                             lum_wrapping *out);

/** What it is called, such as "VXLAN", or "GRE and MPLS".
 * @return out. */
const char *lum_wrapping_name(const lum_wrapping *wrapping,
                              char out[LUM_WRAPPING_TEXT_BYTES]);

/** What makes it readable, as a sentence: a command, or how to record.
 * @return out. */
const char *lum_wrapping_remedy(const lum_wrapping *wrapping,
                                char out[LUM_WRAPPING_TEXT_BYTES]);

#endif
