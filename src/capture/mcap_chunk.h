/** @file
 * The records of a chunk of an MCAP file, unpacked and checked. Internal to the
 * capture room. */
#ifndef LUM_CAPTURE_MCAP_CHUNK_H
#define LUM_CAPTURE_MCAP_CHUNK_H

#include "chunk.h"

/** Read a chunk, behind the head of its record; all of the record is taken,
 * also if it is damaged.
 * @param len what that head says.
 * @return as lum_chunk_read(). */
LUM_MUST_CHECK int lum_mcap_chunk_read(lum_chunk *chunk, lum_pcap *reader,
                                       uint64_t len, lum_error *error);

#endif
