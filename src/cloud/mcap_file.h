/** @file
 * An MCAP file: records, chunks of messages, and the index at its end, into a
 * sink (https://mcap.dev/spec). It knows no message. Memory grows by a chunk,
 * or as many as there are threads, and by less than 200 bytes for each chunk
 * before it; lum_mcap_expect() makes a chunk small. Internal to cloud.
 *
 * Without memory nothing more is written, and the next call that can fail says
 * so. */
#ifndef LUM_CLOUD_MCAP_FILE_H
#define LUM_CLOUD_MCAP_FILE_H

#include "buffer.h"
#include "mcap_pack.h"
#include "sink.h"

#include "lum/cloud/writer.h"

/** Most channels of a file. */
#define LUM_MCAP_CHANNELS_MAX LUM_MCAP_TOPICS_MAX

/** A chunk ends with the message that makes it so large, */
#define LUM_MCAP_CHUNK_BYTES ((size_t)4 << 20)

/** and before one that is so much later than its first. */
#define LUM_MCAP_CHUNK_NS INT64_C(1000000000)

/** A chunk. */
typedef struct lum_mcap_chunk {
    lum_bytes messages;                       /**< of all channels */
    lum_bytes indexes[LUM_MCAP_CHANNELS_MAX]; /**< where those of each are */
    int64_t begin_ns;                         /**< its earliest message */
    int64_t end_ns;                           /**< its latest */
    lum_mcap_packing packing; /**< its messages, compressed; made after it has
                                   ended, maybe by another thread */
} lum_mcap_chunk;

/** Which records stand in the summary; each kind together. */
typedef enum lum_mcap_group {
    LUM_MCAP_SCHEMAS,
    LUM_MCAP_CHANNELS,
    LUM_MCAP_STATISTICS,
    LUM_MCAP_CHUNKS,
    LUM_MCAP_ATTACHMENTS,
    LUM_MCAP_METADATA,
    LUM_MCAP_GROUPS /**< how many kinds there are */
} lum_mcap_group;

/** A message that goes into the sink while it is made, at the end of a chunk
 * whose sum is written when it is known. */
typedef struct lum_mcap_large {
    bool is_begun;   /**< there is one */
    uint64_t offset; /**< of its chunk */
    uint64_t bytes;  /**< of all messages of the chunk */
    uint32_t sum;    /**< of those put so far */
} lum_mcap_large;

/** A file being written. */
typedef struct lum_mcap_file {
    lum_sink *sink;                    /**< where bytes go; the caller's */
    bool can_patch;                    /**< what is in the sink can be written
                                            again, and nobody reads it yet */
    lum_mcap_large large;              /**< the present message, if it is one */
    lum_mcap_packer *packer;           /**< NULL: chunks are not compressed */
    uint32_t counts[LUM_MCAP_GROUPS];  /**< records so far */
    lum_bytes groups[LUM_MCAP_GROUPS]; /**< those of the summary */
    uint64_t messages[LUM_MCAP_CHANNELS_MAX];    /**< so far; id 1 is first */
    lum_mcap_chunk chunks[LUM_MCAP_THREADS_MAX]; /**< a ring of chunk_max */
    unsigned chunk_max;                          /**< under way at once */
    uint64_t chunks_ended; /**< so far; the present one is behind these */
    uint64_t chunks_put;   /**< of these, into the sink */
    lum_bytes record;      /**< one in the making */
    int64_t begin_ns;      /**< the file's earliest */
    int64_t end_ns;        /**< the file's latest */
    size_t message;        /**< where the present one begins, in its chunk */
    lum_crc32 crc;         /**< its tables */
} lum_mcap_file;

/** Begin a file.
 * @param out zeroed by the caller; lum_mcap_free() whatever the result.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_mcap_begin(lum_mcap_file *out, lum_sink *sink,
                                  const char *library, bool compresses,
                                  lum_error *error);

/** Have chunks compressed by threads, if they are, before the first message.
 * @param threads 1 to LUM_MCAP_THREADS_MAX. */
void lum_mcap_set_threads(lum_mcap_file *file, unsigned threads);

/** Add a channel with a schema of its own, before all messages.
 * @param qos its offered_qos_profiles. */
LUM_MUST_CHECK int lum_mcap_add_channel(lum_mcap_file *file, const char *topic,
                                        const char *type,
                                        const char *definition, const char *qos,
                                        lum_error *error);

/** Add a record of names and texts, as name, text, name, text, ..., NULL. */
LUM_MUST_CHECK int lum_mcap_add_metadata(lum_mcap_file *file, const char *name,
                                         const char *const *pairs,
                                         lum_error *error);

/** Add an attachment; a text. */
LUM_MUST_CHECK int lum_mcap_add_attachment(lum_mcap_file *file,
                                           const char *name,
                                           const char *media_type,
                                           const char *text, lum_error *error);

/** Begin a message.
 * @param channel from 0, in the order in which they were added.
 * @param time_ns since 1970; a chunk may end before it.
 * @param out     what its bytes are appended to, until lum_mcap_end_message().
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_mcap_begin_message(lum_mcap_file *file, unsigned channel,
                                          int64_t time_ns, lum_bytes **out,
                                          lum_error *error);

/** Say how many bytes will be put, and nothing else appended, up to its end: if
 * they are many, they need not be in memory.
 * @return 0, or -1 with the reason: memory, or the sink. */
LUM_MUST_CHECK int lum_mcap_expect(lum_mcap_file *file, size_t n,
                                   lum_error *error);

/** Append some of them; all calls together, as many as were expected.
 * @return as lum_mcap_expect(). */
LUM_MUST_CHECK int lum_mcap_put_expected(lum_mcap_file *file, const void *bytes,
                                         size_t n, lum_error *error);

/** It is whole. */
LUM_MUST_CHECK int lum_mcap_end_message(lum_mcap_file *file, lum_error *error);

/** End the present chunk, if there is one, and put all that have ended into the
 * sink, so that a reader can have what is in them. */
LUM_MUST_CHECK int lum_mcap_end_chunk(lum_mcap_file *file, lum_error *error);

/** End the file. */
LUM_MUST_CHECK int lum_mcap_end(lum_mcap_file *file, lum_error *error);

/** Free what it holds, but not the sink. */
void lum_mcap_free(lum_mcap_file *file);

#endif
