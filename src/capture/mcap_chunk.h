/** @file
 * The records of a chunk of an MCAP file, unpacked and checked. Internal to the
 * capture room. */
#ifndef LUM_CAPTURE_MCAP_CHUNK_H
#define LUM_CAPTURE_MCAP_CHUNK_H

#include "pcap.h"

/** Most bytes of a chunk's records, packed or not. Writers' chunks have a few
 * MiB. */
#define LUM_MCAP_CHUNK_RECORDS_MAX ((uint32_t)64 << 20)

/** Memory for one chunk after the other. */
typedef struct lum_mcap_chunk lum_mcap_chunk;

/** Bytes of someone else's. */
typedef struct lum_bytes_at {
    const uint8_t *at;
    size_t len;
} lum_bytes_at;

/** Make it, without any records.
 * @return NULL without memory. */
LUM_MUST_CHECK lum_mcap_chunk *lum_mcap_chunk_new(void);

/** Free it. NULL is allowed. */
void lum_mcap_chunk_free(lum_mcap_chunk *chunk);

/** Read a chunk, behind the head of its record.
 * @param len what that head says.
 * @return 0; -1 with the reason in error, and without any records. */
LUM_MUST_CHECK int lum_mcap_chunk_read(lum_mcap_chunk *chunk, lum_pcap *reader,
                                       uint64_t len, lum_error *error);

/** Its records, until the next chunk is read. */
lum_bytes_at lum_mcap_chunk_records(const lum_mcap_chunk *chunk);

#endif
