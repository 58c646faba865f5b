#include "mcap_chunk.h"

#include "base/crc32.h"
#include "pcap_internal.h"
#include "unpack.h"

#include <stdlib.h>
#include <string.h>

enum {
    HEAD_BYTES = 32, /* up to the name of the compression, and its length */
    NAME_BYTES_MAX = 32,
    LENGTH_BYTES = 8 /* of the records, behind the name */
};

/* Memory grows with what a file has, not with what it says. */
#define ROOM_MIN ((size_t)256 * 1024)

struct buffer {
    uint8_t *at;
    size_t len;
    size_t room;
};

struct lum_mcap_chunk {
    struct buffer records;
    struct buffer packed;
    lum_crc32 crc;
};

/* What stands before a chunk's records. */
struct head {
    uint64_t unpacked;
    uint64_t packed;
    uint32_t crc;
    char compression[NAME_BYTES_MAX + 1];
};

lum_mcap_chunk *lum_mcap_chunk_new(void)
{
    lum_mcap_chunk *c = calloc(1, sizeof *c);
    if (c != NULL) {
        lum_crc32_init(&c->crc);
    }
    return c;
}

void lum_mcap_chunk_free(lum_mcap_chunk *chunk)
{
    if (chunk != NULL) {
        free(chunk->records.at);
        free(chunk->packed.at);
        free(chunk);
    }
}

lum_bytes_at lum_mcap_chunk_records(const lum_mcap_chunk *chunk)
{
    return (lum_bytes_at){chunk->records.at, chunk->records.len};
}

/* --- The head --- */

static int too_large(const lum_pcap *r, uint64_t bytes, lum_error *error)
{
    return lum_pcap_fail(
        r, error, "a chunk of %llu bytes; at most %lu can be read",
        (unsigned long long)bytes, (unsigned long)LUM_MCAP_CHUNK_RECORDS_MAX);
}

/* More bytes of the record, of which *left are; they stay until taken. */
static int need(lum_pcap *r, size_t bytes, uint64_t left, lum_error *error)
{
    lum_source *s = r->source;
    if (bytes > left) {
        return lum_pcap_fail(r, error,
                             "a chunk is shorter than what it says it has");
    }
    if (!lum_source_has(s, bytes)) {
        return lum_pcap_fail_cut(r, "chunk", s->end - r->at, 0, error);
    }
    return 0;
}

static int check_head(const lum_pcap *r, const struct head *head,
                      lum_error *error)
{
    const bool is_plain = head->compression[0] == '\0';
    if (head->unpacked > LUM_MCAP_CHUNK_RECORDS_MAX ||
        head->packed > LUM_MCAP_CHUNK_RECORDS_MAX) {
        return too_large(
            r, head->unpacked > head->packed ? head->unpacked : head->packed,
            error);
    }
    if (is_plain && head->packed != head->unpacked) {
        return lum_pcap_fail(
            r, error, "an uncompressed chunk of %lu bytes has %lu",
            (unsigned long)head->unpacked, (unsigned long)head->packed);
    }
    if (is_plain || strcmp(head->compression, "zstd") == 0) {
        return lum_unpack_zstd != NULL || is_plain
                   ? 0
                   : lum_pcap_fail(r, error,
                                   "a chunk is compressed by zstd, and this "
                                   "build has no libzstd: use mcap compress "
                                   "--compression none");
    }
    return lum_pcap_fail(r, error,
                         "a chunk is compressed by %s, which is not read: use "
                         "mcap compress --compression zstd",
                         head->compression);
}

/* Without bytes that do something to a terminal. */
static void set_name(struct head *head, const uint8_t *name, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        head->compression[i] =
            name[i] > ' ' && name[i] < 0x7f ? (char)name[i] : '?';
    }
    head->compression[len] = '\0';
}

static int read_head(lum_pcap *r, uint64_t *left, struct head *head,
                     lum_error *error)
{
    lum_source *s = r->source;
    if (need(r, HEAD_BYTES, *left, error) != 0) {
        return -1;
    }
    head->unpacked = load_le64(s->at + 16);
    head->crc = load_le32(s->at + 24);
    const size_t len = load_le32(s->at + 28);
    if (len > NAME_BYTES_MAX) {
        return lum_pcap_fail(
            r, error, "a chunk's compression has a name of %zu bytes", len);
    }
    const size_t all = HEAD_BYTES + len + LENGTH_BYTES;
    if (need(r, all, *left, error) != 0) {
        return -1;
    }
    set_name(head, s->at + HEAD_BYTES, len);
    head->packed = load_le64(s->at + HEAD_BYTES + len);
    lum_source_take(s, all);
    *left -= all;
    if (head->packed > *left) {
        return lum_pcap_fail(r, error,
                             "a chunk is shorter than what it says it has");
    }
    return check_head(r, head, error);
}

/* --- The records --- */

static int refuse_for_memory(const lum_pcap *r, size_t bytes, lum_error *error)
{
    return lum_pcap_fail(r, error, "not enough memory for a chunk of %zu bytes",
                         bytes);
}

static bool make_room(struct buffer *b, size_t bytes)
{
    size_t room = b->room != 0 ? b->room : ROOM_MIN;
    while (room < bytes) {
        room *= 2u;
    }
    if (room != b->room) {
        uint8_t *more = realloc(b->at, room);
        if (more == NULL) {
            return false;
        }
        b->at = more;
        b->room = room;
    }
    return true;
}

/* A chunk may be larger than the source's window. */
static int copy(lum_pcap *r, size_t bytes, struct buffer *to, lum_error *error)
{
    lum_source *s = r->source;
    to->len = 0;
    while (to->len < bytes) {
        if (!lum_source_has(s, 1)) {
            return lum_pcap_fail_cut(r, "chunk", s->end - r->at, 0, error);
        }
        const size_t rest = bytes - to->len;
        const size_t n = s->left < rest ? s->left : rest;
        if (!make_room(to, to->len + n)) {
            return refuse_for_memory(r, bytes, error);
        }
        memcpy(to->at + to->len, s->at, n);
        to->len += n;
        lum_source_take(s, n);
    }
    return 0;
}

static int wrong_length(const lum_pcap *r, size_t bytes, lum_error *error)
{
    return lum_pcap_fail(r, error,
                         "a chunk does not unpack to the %zu bytes that it "
                         "says",
                         bytes);
}

/* Exactly so many bytes, then the end. */
static int unpack_all(const lum_pcap *r, const lum_source_functions *f,
                      size_t bytes, struct buffer *to, lum_error *error)
{
    uint8_t more = 0;
    lum_error reason = {""};
    int64_t got = 1;
    to->len = 0;
    while (got > 0 && to->len < bytes) {
        const size_t room = bytes - to->len;
        const size_t step = room < ROOM_MIN ? room : ROOM_MIN;
        if (!make_room(to, to->len + step)) {
            return refuse_for_memory(r, bytes, error);
        }
        got = f->read(f->context, to->at + to->len, step, &reason);
        to->len += got > 0 ? (size_t)got : 0u;
    }
    if (got > 0 || bytes == 0) {
        got = f->read(f->context, &more, 1, &reason);
    }
    if (got < 0) {
        return lum_pcap_fail(r, error, "a chunk cannot be unpacked: %s",
                             reason.text);
    }
    return got == 0 && to->len == bytes ? 0 : wrong_length(r, bytes, error);
}

static int unpack(lum_mcap_chunk *c, const lum_pcap *r, size_t bytes,
                  lum_error *error)
{
    lum_source_functions functions;
    lum_source *packed =
        lum_source_from_memory("a chunk", c->packed.at, c->packed.len);
    if (packed == NULL || lum_unpack_zstd(packed, &functions) != 0) {
        lum_source_close(packed);
        return refuse_for_memory(r, bytes, error);
    }
    const int result = unpack_all(r, &functions, bytes, &c->records, error);
    functions.close(functions.context);
    lum_source_close(packed);
    return result;
}

static int read_records(lum_mcap_chunk *c, lum_pcap *r, const struct head *head,
                        lum_error *error)
{
    const size_t bytes = (size_t)head->unpacked;
    if (head->compression[0] == '\0') {
        return copy(r, bytes, &c->records, error);
    }
    return copy(r, (size_t)head->packed, &c->packed, error) == 0
               ? unpack(c, r, bytes, error)
               : -1;
}

static int check_crc(const lum_mcap_chunk *c, const lum_pcap *r, uint32_t crc,
                     lum_error *error)
{
    return crc == 0 || crc == lum_crc32_add(&c->crc, 0, c->records.at,
                                            c->records.len)
               ? 0
               : lum_pcap_fail(r, error,
                               "a chunk is damaged: its check sum is wrong");
}

int lum_mcap_chunk_read(lum_mcap_chunk *chunk, lum_pcap *reader, uint64_t len,
                        lum_error *error)
{
    lum_pcap *r = reader;
    uint64_t left = len;
    struct head head = {.unpacked = 0};
    chunk->records.len = 0;
    if (read_head(r, &left, &head, error) != 0 ||
        read_records(chunk, r, &head, error) != 0 ||
        check_crc(chunk, r, head.crc, error) != 0) {
        chunk->records.len = 0;
        return -1;
    }
    if (!lum_source_skip(r->source, left - head.packed)) {
        chunk->records.len = 0;
        return lum_pcap_fail_cut(r, "chunk", r->source->end - r->at, 0, error);
    }
    return 0;
}
