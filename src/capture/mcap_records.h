/** @file
 * The records of an MCAP file (https://mcap.dev/spec) that have to do with
 * messages, in chunks and beside them. The index at the end is not used, so a
 * file may come through a pipe: a record is handed out when its bytes, or its
 * chunk's, are there. Internal to the capture room. */
#ifndef LUM_CAPTURE_MCAP_RECORDS_H
#define LUM_CAPTURE_MCAP_RECORDS_H

#include "chunk.h"

/** Most bytes of a schema or of a channel; a schema has all definitions that it
 * needs as a text. */
#define LUM_MCAP_RECORD_BYTES_MAX ((uint32_t)1 << 20)

/** How many schemas have an id, and how many channels. */
#define LUM_MCAP_IDS 65536u

/** What a record describes. */
typedef enum lum_mcap_kind {
    LUM_MCAP_IS_SCHEMA,
    LUM_MCAP_IS_CHANNEL,
    LUM_MCAP_IS_MESSAGE,
    LUM_MCAP_IS_METADATA
} lum_mcap_kind;

/** A record, its texts without a NUL. Live until the next one. */
typedef struct lum_mcap_record {
    lum_mcap_kind kind;
    unsigned id;           /**< the schema's; else the channel's; 0 */
    unsigned schema;       /**< of a channel; 0: it has none */
    uint64_t log_ns;       /**< of a message, since 1970 */
    lum_bytes_at name;     /**< of a schema; a channel's topic */
    lum_bytes_at encoding; /**< of a schema's text; of a channel's messages */
    lum_bytes_at
        rest; /**< a schema's text with its length; the pairs of a
                   channel's metadata; a message's bytes; all of metadata */
} lum_mcap_record;

/** What is to be done with the messages of a channel. */
typedef enum lum_mcap_want {
    LUM_MCAP_PASS_OVER, /**< whatever their length */
    LUM_MCAP_HAND_OUT,
    LUM_MCAP_UNKNOWN /**< it was not described: they count as damaged */
} lum_mcap_want;

/** Which messages are handed out. */
typedef struct lum_mcap_wanted {
    lum_mcap_want (*wants)(const void *context, unsigned channel);
    const void *context;
    uint32_t bytes_max; /**< of the record of such a message beside chunks; less
                             than LUM_SOURCE_WINDOW_MAX */
} lum_mcap_wanted;

/** What is read of a file. */
typedef struct lum_mcap_records lum_mcap_records;

/** Begin behind the file's magic.
 * @param reader borrowed: its source, and its place for messages.
 * @return NULL without memory. */
LUM_MUST_CHECK lum_mcap_records *lum_mcap_records_new(
    lum_pcap *reader, const lum_mcap_wanted *wanted);

/** Free it. NULL is allowed. */
void lum_mcap_records_free(lum_mcap_records *records);

/** The next record. Metadata that is longer than LUM_MCAP_RECORD_BYTES_MAX is
 * passed over. So are damaged chunks and records whose length is known, which
 * the reader counts; behind the first of them, schemas and channels come that
 * the end of the file has again, if the source can be read from there.
 * @return 1; 0 at the end; -1 where it cannot be read any further, with the
 *         byte and the reason in error. */
LUM_MUST_CHECK int lum_mcap_records_next(lum_mcap_records *records,
                                         lum_mcap_record *out,
                                         lum_error *error);

/** Take a text that begins *from, as MCAP has them.
 * @return false if *from is too short for it. */
LUM_MUST_CHECK bool lum_mcap_take_text(lum_bytes_at *from, lum_bytes_at *out);

/** Whether it is that text. */
bool lum_mcap_is_text(lum_bytes_at text, const char *wanted);

#endif
