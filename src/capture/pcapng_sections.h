/** @file
 * The sections and interfaces that a pcapng file describes, and the options of
 * its blocks. They are the only ones to change a reader's interfaces and
 * is_lost while a pcapng file is read. Internal to that reader; the writer has
 * its numbers. */
#ifndef LUM_CAPTURE_PCAPNG_SECTIONS_H
#define LUM_CAPTURE_PCAPNG_SECTIONS_H

#include "pcap.h"

/* Types of blocks that are read. */
enum {
    LUM_PCAPNG_SECTION = 0x0a0d0d0a, /* the same in either byte order */
    LUM_PCAPNG_INTERFACE = 1,
    LUM_PCAPNG_PACKET = 2, /* obsolete */
    LUM_PCAPNG_SIMPLE_PACKET = 3,
    LUM_PCAPNG_ENHANCED_PACKET = 6
};

/** Bytes of a block's trailer: its length again. */
#define LUM_PCAPNG_TRAILER_BYTES 4u

/** A block at hand, from its header to behind its trailer. */
typedef struct lum_pcapng_block {
    const uint8_t *at;
    uint32_t type;
    uint32_t len;
} lum_pcapng_block;

/** Bytes of a value with what fills it up to a multiple of 4. */
static inline size_t lum_pcapng_padded(size_t len)
{
    return (len + 3u) / 4u * 4u;
}

/** Say that a block has too few bytes for its type.
 * @return -1. */
int lum_pcapng_fail_short(const lum_pcap *reader, const lum_pcapng_block *block,
                          lum_error *error);

/** Hand out the options of a block, if the reader's caller asked for them.
 * @param from where they begin in the block. */
void lum_pcapng_hand_out_options(const lum_pcap *reader, lum_pcap_place place,
                                 const lum_pcapng_block *block, size_t from);

/** Read a section or an interface.
 * @return LUM_PCAP_GO_ON; LUM_PCAP_DAMAGED or LUM_PCAP_FAILED with the reason
 *         in error. */
int lum_pcapng_describe(lum_pcap *reader, const lum_pcapng_block *block,
                        lum_error *error);

/** A block is too long to be read: what follows a section or an interface knows
 * that it was there.
 * @return LUM_PCAP_DAMAGED, with error as it is; or LUM_PCAP_FAILED. */
int lum_pcapng_lose(lum_pcap *reader, const lum_pcapng_block *block,
                    lum_error *error);

#endif
