/* MCAP files in the making, for the tests of their readers. */
#ifndef LUM_TESTS_MCAP_IMAGE_H
#define LUM_TESTS_MCAP_IMAGE_H

#include <stddef.h>
#include <stdint.h>

enum {
    OP_HEADER = 1,
    OP_FOOTER,
    OP_SCHEMA,
    OP_CHANNEL,
    OP_MESSAGE,
    OP_CHUNK,
    OP_MESSAGE_INDEX,
    OP_CHUNK_INDEX,
    OP_STATISTICS = 11,
    OP_SUMMARY_OFFSET = 14,
    OP_DATA_END,
    OP_OWN = 0x80
};

/* Bytes of a file, or of a chunk's records. */
typedef struct image {
    uint8_t *bytes;
    size_t len;
    size_t room;
    uint64_t messages;
} image;

/* What a chunk's head says besides. */
struct chunk {
    const char *compression;
    uint32_t crc;
    uint64_t unpacked;
    uint64_t packed;
};

void put(image *im, const void *bytes, size_t len);
void set_int(const image *im, size_t at, uint64_t value, size_t len);
void put_int(image *im, uint64_t value, size_t len);
void put_text(image *im, const char *text);

/* Returns where it begins, for end_record(). */
size_t begin_record(image *im, unsigned opcode);
void end_record(const image *im, size_t from);

/* Of so many zeros. */
void put_record(image *im, unsigned opcode, size_t len);

/* Of type ros2msg. */
void put_schema(image *im, unsigned id, const char *name);
void put_channel(image *im, unsigned id, unsigned schema, const char *topic,
                 const char *encoding);

/* Up to the header, and from the end of the data on. */
image begin_file(void);
void end_file(image *im);

/* Likewise, with schemas and channels in the summary. */
void end_file_with(image *im, const image *described);

void put_chunk_as(image *im, const image *bytes, const struct chunk *c);

/* Chunks of records, which they take over. */
void put_plain(image *im, image *records);
void put_zstd(image *im, image *records);
void put_lz4(image *im, image *records);

/* Bytes as zstd, or lz4, has them that did not make them shorter; fewer than
 * 64 KiB. */
image stored(const image *records);
image stored_lz4(const image *records);

#endif
