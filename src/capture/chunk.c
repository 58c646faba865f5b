#include "chunk.h"

#include "base/grow.h"
#include "pcap.h"
#include "unpack.h"

#include <stdlib.h>
#include <string.h>

/* Memory grows with what a file has, not with what it says. */
#define STEP_BYTES ((size_t)256 * 1024)

void lum_chunk_release(lum_chunk *chunk)
{
    free(chunk->records.at);
    free(chunk->packed.at);
}

void lum_chunk_name(char *out, const uint8_t *name, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        out[i] = name[i] > ' ' && name[i] < 0x7f ? (char)name[i] : '?';
    }
    out[len] = '\0';
}

static int refuse_for_memory(const lum_pcap *r, uint64_t bytes,
                             lum_error *error)
{
    return lum_pcap_fail(r, error,
                         "not enough memory for a chunk of %llu bytes",
                         (unsigned long long)bytes);
}

/* --- Its head --- */

/* NULL: with the reason in error. */
static const lum_unpacker *find_unpacker(const lum_pcap *r,
                                         const lum_chunk_head *h,
                                         lum_error *error)
{
    const char *library = NULL;
    const lum_unpacker *unpacker = NULL;
    if (strcmp(h->compression, h->known[0]) == 0 ||
        strcmp(h->compression, h->known[1]) == 0) {
        unpacker = lum_unpack_named(h->compression, &library);
    }
    if (unpacker == NULL && library == NULL) {
        (void)lum_pcap_fail(
            r, error, "a chunk is compressed by %s, which is not supported",
            h->compression);
    } else if (unpacker == NULL) {
        (void)lum_pcap_fail(r, error,
                            "a chunk is compressed by %s, and this build has "
                            "no %s: %s makes a readable file",
                            h->compression, library, h->fix);
    }
    return unpacker;
}

int lum_chunk_check_plain(const lum_pcap *reader, const lum_chunk_head *head,
                          lum_error *error)
{
    if (head->packed == head->unpacked) {
        return LUM_PCAP_GO_ON;
    }
    (void)lum_pcap_fail(
        reader, error, "an uncompressed chunk of %llu bytes has %llu",
        (unsigned long long)head->unpacked, (unsigned long long)head->packed);
    return LUM_PCAP_DAMAGED;
}

static int check_lengths(const lum_pcap *r, const lum_chunk_head *h,
                         lum_error *error)
{
    const uint64_t most = h->unpacked > h->packed ? h->unpacked : h->packed;
    if (most > LUM_CHUNK_RECORDS_MAX) {
        (void)lum_pcap_fail(r, error,
                            "a chunk of %llu bytes; at most %lu can be read: "
                            "%s makes a readable file",
                            (unsigned long long)most,
                            (unsigned long)LUM_CHUNK_RECORDS_MAX, h->fix);
        return LUM_PCAP_DAMAGED;
    }
    return h->compression[0] == '\0' ? lum_chunk_check_plain(r, h, error)
                                     : LUM_PCAP_GO_ON;
}

/* --- Its bytes --- */

static bool make_room(lum_chunk_bytes *b, size_t bytes)
{
    uint8_t *at = lum_grown(b->at, b->len, bytes, 1, &b->room);
    b->at = at != NULL ? at : b->at;
    return at != NULL;
}

/* A chunk may be larger than the source's window. */
static int copy(lum_pcap *r, size_t bytes, lum_chunk_bytes *to,
                lum_error *error)
{
    lum_source *s = r->source;
    to->len = 0;
    while (to->len < bytes) {
        if (!lum_source_has(s, 1)) {
            return lum_pcap_fail_cut(r, "chunk", 0, error);
        }
        const size_t rest = bytes - to->len;
        const size_t n = s->left < rest ? s->left : rest;
        if (!make_room(to, n)) {
            return refuse_for_memory(r, bytes, error);
        }
        memcpy(to->at + to->len, s->at, n);
        to->len += n;
        lum_source_take(s, n);
    }
    return LUM_PCAP_GO_ON;
}

/* Exactly so many bytes, then the end. */
static int unpack_all(const lum_pcap *r, const lum_source_functions *f,
                      size_t bytes, lum_chunk_bytes *to, lum_error *error)
{
    uint8_t more = 0;
    lum_error reason = {""};
    int64_t got = 1;
    to->len = 0;
    while (got > 0 && to->len < bytes) {
        const size_t room = bytes - to->len;
        const size_t step = room < STEP_BYTES ? room : STEP_BYTES;
        if (!make_room(to, step)) {
            return refuse_for_memory(r, bytes, error);
        }
        got = f->read(f->context, to->at + to->len, step, &reason);
        to->len += got > 0 ? (size_t)got : 0u;
    }
    if (got > 0 || bytes == 0) {
        got = f->read(f->context, &more, 1, &reason);
    }
    if (got == 0 && to->len == bytes) {
        return LUM_PCAP_GO_ON;
    }
    if (got < 0) {
        (void)lum_pcap_fail(r, error, "a chunk cannot be unpacked: %s",
                            reason.text);
    } else {
        (void)lum_pcap_fail(
            r, error, "a chunk does not unpack to the %zu bytes it declares",
            bytes);
    }
    return LUM_PCAP_DAMAGED;
}

static int unpack(lum_chunk *c, const lum_pcap *r, const lum_unpacker *unpacker,
                  size_t bytes, lum_error *error)
{
    lum_source_functions functions;
    lum_source *packed =
        lum_source_from_memory("a chunk", c->packed.at, c->packed.len);
    if (packed == NULL || lum_unpack_by(unpacker, packed, &functions) != 0) {
        lum_source_close(packed);
        return refuse_for_memory(r, bytes, error);
    }
    const int result = unpack_all(r, &functions, bytes, &c->records, error);
    functions.close(functions.context);
    lum_source_close(packed);
    return result;
}

static int read_records(lum_chunk *c, lum_pcap *r, const lum_chunk_head *h,
                        lum_error *error)
{
    const size_t bytes = (size_t)h->unpacked;
    if (h->compression[0] == '\0') {
        return copy(r, bytes, &c->records, error);
    }
    const lum_unpacker *const unpacker = find_unpacker(r, h, error);
    if (unpacker == NULL) {
        return LUM_PCAP_DAMAGED;
    }
    const int copied = copy(r, (size_t)h->packed, &c->packed, error);
    return copied == LUM_PCAP_GO_ON ? unpack(c, r, unpacker, bytes, error)
                                    : copied;
}

int lum_chunk_read(lum_chunk *chunk, lum_pcap *reader,
                   const lum_chunk_head *head, lum_error *error)
{
    chunk->records.len = 0;
    int result = check_lengths(reader, head, error);
    if (result == LUM_PCAP_GO_ON) {
        result = read_records(chunk, reader, head, error);
    }
    if (result == LUM_PCAP_GO_ON && head->crc != 0 &&
        head->crc != lum_crc32_add(&chunk->crc, 0, chunk->records.at,
                                   chunk->records.len)) {
        (void)lum_pcap_fail(reader, error,
                            "a chunk is damaged: its check sum is wrong");
        result = LUM_PCAP_DAMAGED;
    }
    chunk->records.len = result == LUM_PCAP_GO_ON ? chunk->records.len : 0;
    return result;
}
