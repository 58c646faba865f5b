#include "mcap_chunk.h"

#include "pcap_internal.h"
#include "unpack.h"

enum {
    HEAD_BYTES = 32, /* up to the name of the compression, and its length */
    LENGTH_BYTES = 8 /* of the records, behind the name */
};

static int too_short(const lum_pcap *r, lum_error *error)
{
    (void)lum_pcap_fail(r, error,
                        "a chunk is shorter than what it says it has");
    return LUM_PCAP_DAMAGED;
}

/* More bytes of the record, of which left are; they stay until taken. */
static int need(lum_pcap *r, size_t bytes, uint64_t left, lum_error *error)
{
    lum_source *s = r->source;
    if (bytes > left) {
        return too_short(r, error);
    }
    if (!lum_source_has(s, bytes)) {
        return lum_pcap_fail_cut(r, "chunk", 0, error);
    }
    return LUM_PCAP_GO_ON;
}

static int read_head(lum_pcap *r, uint64_t left, lum_chunk_head *head,
                     lum_error *error)
{
    lum_source *s = r->source;
    int result = need(r, HEAD_BYTES, left, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    head->unpacked = load_le64(s->at + 16);
    head->crc = load_le32(s->at + 24);
    const size_t len = load_le32(s->at + 28);
    if (len > LUM_CHUNK_NAME_MAX) {
        (void)lum_pcap_fail(
            r, error, "a chunk's compression has a name of %zu bytes", len);
        return LUM_PCAP_DAMAGED;
    }
    const size_t all = HEAD_BYTES + len + LENGTH_BYTES;
    result = need(r, all, left, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    lum_chunk_name(head->compression, s->at + HEAD_BYTES, len);
    head->packed = load_le64(s->at + HEAD_BYTES + len);
    lum_source_take(s, all);
    return head->packed <= left - all ? LUM_PCAP_GO_ON : too_short(r, error);
}

int lum_mcap_chunk_read(lum_chunk *chunk, lum_pcap *reader, uint64_t len,
                        lum_error *error)
{
    static const char *const known[] = {"zstd", "lz4"};
    lum_source *s = reader->source;
    const uint64_t begin = lum_source_offset(s);
    lum_chunk_head head = {.known = known,
                           .remedy = lum_unpack_zstd != NULL
                                         ? "mcap compress"
                                         : "mcap decompress"};
    lum_chunk_clear(chunk);
    int result = read_head(reader, len, &head, error);
    if (result == LUM_PCAP_GO_ON) {
        result = lum_chunk_read(chunk, reader, &head, error);
    }
    if (result != LUM_PCAP_FAILED &&
        !lum_source_skip(s, len - (lum_source_offset(s) - begin))) {
        lum_chunk_clear(chunk);
        return lum_pcap_fail_cut(reader, "chunk", 0, error);
    }
    return result;
}
