/** @file
 * Link layers: from a captured frame to the IPv4 packet in it. Internal to
 * capture. */
#ifndef LUM_CAPTURE_LINK_H
#define LUM_CAPTURE_LINK_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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

#endif
