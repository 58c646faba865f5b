/** @file
 * A chunk of an MCAP file or of a bag: records that were written, and perhaps
 * compressed, together. Internal to the capture room. */
#ifndef LUM_CAPTURE_CHUNK_H
#define LUM_CAPTURE_CHUNK_H

#include "base/crc32.h"
#include "pcap.h"

/** Most bytes of a chunk's records, packed or not. Writers' chunks have a few
 * MiB. */
#define LUM_CHUNK_RECORDS_MAX ((uint32_t)64 << 20)

/** Most bytes of the name of a compression. */
#define LUM_CHUNK_NAME_MAX 32u

/** Bytes of someone else's. */
typedef struct lum_bytes_at {
    const uint8_t *at;
    size_t len;
} lum_bytes_at;

/** What stands before a chunk's records. */
typedef struct lum_chunk_head {
    char compression[LUM_CHUNK_NAME_MAX + 1]; /**< "": none */
    uint64_t packed;          /**< bytes that follow in the source */
    uint64_t unpacked;        /**< bytes of the records */
    uint32_t crc;             /**< of the records; 0: not known */
    const char *const *known; /**< two names of compressions in such a file */
    const char *fix;          /**< a command that makes chunks to be read */
} lum_chunk_head;

/** Bytes of its own. */
typedef struct lum_chunk_bytes {
    uint8_t *at;
    size_t len;
    size_t room;
} lum_chunk_bytes;

/** Memory for one chunk after the other. All bytes 0: there is none. */
typedef struct lum_chunk {
    lum_chunk_bytes records; /**< until the next chunk is read */
    lum_chunk_bytes packed;
    lum_crc32 crc; /**< set by lum_crc32_init() where heads have check sums */
} lum_chunk;

/** Free its memory. */
void lum_chunk_release(lum_chunk *chunk);

/** Take a name for messages, without bytes that do something to a terminal.
 * @param out has room for len bytes and a NUL. */
void lum_chunk_name(char *out, const uint8_t *name, size_t len);

/** Read the records, of which the source holds the first byte next.
 * @return LUM_PCAP_GO_ON; LUM_PCAP_DAMAGED if it cannot be read, but what
 *         follows it can; LUM_PCAP_FAILED if the source has ended, or without
 *         memory. With the last two there are no records, and any number of
 *         head->packed bytes was taken. */
LUM_MUST_CHECK int lum_chunk_read(lum_chunk *chunk, lum_pcap *reader,
                                  const lum_chunk_head *head, lum_error *error);

/** Check that a chunk that is not compressed is as long as its head says.
 * @return LUM_PCAP_GO_ON, or LUM_PCAP_DAMAGED. */
LUM_MUST_CHECK int lum_chunk_check_plain(const lum_pcap *reader,
                                         const lum_chunk_head *head,
                                         lum_error *error);

#endif
