#include "mcap_records.h"

#include "pcap_internal.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC_BYTES  8u
#define RECORD_HEAD  9u
#define MESSAGE_HEAD 22u

enum opcode {
    OP_FOOTER = 2,
    OP_SCHEMA = 3,
    OP_CHANNEL = 4,
    OP_MESSAGE = 5,
    OP_CHUNK = 6,
    OP_STATISTICS = 11,
    OP_METADATA = 12
};

/* What a step led to. */
enum step {
    FAILED = -1,
    ENDED,
    RECORD,
    GO_ON
};

struct lum_mcap_records {
    lum_pcap *reader;
    lum_mcap_wanted wanted;
    lum_mcap_chunk *chunk;
    size_t chunk_at;   /* in its records; at their end: none is left */
    uint64_t messages; /* of all channels, so far */
    bool has_ended;    /* its footer was read */
};

/* A record's bytes, without its opcode and length. */
struct raw {
    unsigned opcode;
    const uint8_t *at;
    uint64_t len;
};

/* --- What a record says --- */

bool lum_mcap_take_text(lum_bytes_at *from, lum_bytes_at *out)
{
    if (from->len < 4u || load_le32(from->at) > from->len - 4u) {
        return false;
    }
    *out = (lum_bytes_at){from->at + 4, load_le32(from->at)};
    from->at += 4u + out->len;
    from->len -= 4u + out->len;
    return true;
}

bool lum_mcap_is_text(lum_bytes_at text, const char *wanted)
{
    return text.len == strlen(wanted) &&
           (text.len == 0 || memcmp(text.at, wanted, text.len) == 0);
}

static int too_short(const lum_mcap_records *m, const char *what,
                     lum_error *error)
{
    return lum_pcap_fail(m->reader, error,
                         "a %s is shorter than what it says it has", what);
}

static int read_schema(const lum_mcap_records *m, const struct raw *raw,
                       lum_mcap_record *out, lum_error *error)
{
    if (raw->len < 2u) {
        return too_short(m, "schema", error);
    }
    *out =
        (lum_mcap_record){.kind = LUM_MCAP_IS_SCHEMA, .id = load_le16(raw->at)};
    out->rest = (lum_bytes_at){raw->at + 2, (size_t)raw->len - 2u};
    return lum_mcap_take_text(&out->rest, &out->name) &&
                   lum_mcap_take_text(&out->rest, &out->encoding)
               ? RECORD
               : too_short(m, "schema", error);
}

static int read_channel(const lum_mcap_records *m, const struct raw *raw,
                        lum_mcap_record *out, lum_error *error)
{
    if (raw->len < 4u) {
        return too_short(m, "channel", error);
    }
    *out = (lum_mcap_record){.kind = LUM_MCAP_IS_CHANNEL,
                             .id = load_le16(raw->at),
                             .schema = load_le16(raw->at + 2)};
    out->rest = (lum_bytes_at){raw->at + 4, (size_t)raw->len - 4u};
    return lum_mcap_take_text(&out->rest, &out->name) &&
                   lum_mcap_take_text(&out->rest, &out->encoding)
               ? RECORD
               : too_short(m, "channel", error);
}

/* Of which at least the channel is at hand. */
static bool is_wanted(const lum_mcap_records *m, const uint8_t *message)
{
    return m->wanted.wants(m->wanted.context, load_le16(message));
}

static int read_message(lum_mcap_records *m, const struct raw *raw,
                        lum_mcap_record *out, lum_error *error)
{
    m->messages++;
    if (raw->len < 2u) {
        return too_short(m, "message", error);
    }
    if (!is_wanted(m, raw->at)) {
        return GO_ON;
    }
    if (raw->len < MESSAGE_HEAD) {
        return too_short(m, "message", error);
    }
    *out = (lum_mcap_record){.kind = LUM_MCAP_IS_MESSAGE,
                             .id = load_le16(raw->at),
                             .log_ns = load_le64(raw->at + 6)};
    out->rest =
        (lum_bytes_at){raw->at + MESSAGE_HEAD, (size_t)raw->len - MESSAGE_HEAD};
    return RECORD;
}

/* A record whose bytes are at hand. */
static int read_raw(lum_mcap_records *m, const struct raw *raw,
                    lum_mcap_record *out, lum_error *error)
{
    switch (raw->opcode) {
    case OP_SCHEMA:
        return read_schema(m, raw, out, error);
    case OP_CHANNEL:
        return read_channel(m, raw, out, error);
    case OP_MESSAGE:
        return read_message(m, raw, out, error);
    default:
        return GO_ON;
    }
}

/* --- Records in a chunk --- */

static int next_in_chunk(lum_mcap_records *m, lum_mcap_record *out,
                         lum_error *error)
{
    const lum_bytes_at all = lum_mcap_chunk_records(m->chunk);
    const size_t left = all.len - m->chunk_at;
    const uint8_t *at = all.at + m->chunk_at;
    if (left < RECORD_HEAD || load_le64(at + 1) > left - RECORD_HEAD) {
        return lum_pcap_fail(m->reader, error,
                             "a record of a chunk is longer than "
                             "what is left of the chunk");
    }
    const struct raw raw = {at[0], at + RECORD_HEAD, load_le64(at + 1)};
    m->chunk_at += RECORD_HEAD + (size_t)raw.len;
    return read_raw(m, &raw, out, error);
}

static bool is_in_chunk(const lum_mcap_records *m)
{
    return m->chunk_at < lum_mcap_chunk_records(m->chunk).len;
}

/* --- Records of the file --- */

static int cut(const lum_pcap *r, uint64_t all, lum_error *error)
{
    const lum_source *s = r->source;
    return lum_pcap_fail_cut(r, "record", s->end - r->at, all, error);
}

/* Behind its head, which is at hand. */
static int skip(const lum_pcap *r, uint64_t len, lum_error *error)
{
    return lum_source_skip(r->source, RECORD_HEAD) &&
                   lum_source_skip(r->source, len)
               ? GO_ON
               : cut(r, len > UINT64_MAX - RECORD_HEAD ? 0 : RECORD_HEAD + len,
                     error);
}

/* A record that is looked at as a whole. Its bytes stay in place until more are
 * requested. */
static int take_record(lum_mcap_records *m, struct raw *raw, uint32_t max,
                       lum_mcap_record *out, lum_error *error)
{
    const lum_pcap *r = m->reader;
    lum_source *s = r->source;
    if (raw->len > max) {
        return lum_pcap_fail(r, error,
                             "a record of type %u has %llu bytes; at most %lu "
                             "are possible",
                             raw->opcode, (unsigned long long)raw->len,
                             (unsigned long)max);
    }
    const size_t all = RECORD_HEAD + (size_t)raw->len;
    if (!lum_source_has(s, all)) {
        return cut(r, all, error);
    }
    raw->at = s->at + RECORD_HEAD;
    const int result = read_raw(m, raw, out, error);
    lum_source_take(s, all);
    return result;
}

static int take_message(lum_mcap_records *m, struct raw *raw,
                        lum_mcap_record *out, lum_error *error)
{
    const lum_pcap *r = m->reader;
    if (raw->len >= 2u) {
        if (!lum_source_has(r->source, RECORD_HEAD + 2u)) {
            return cut(r, 0, error);
        }
        if (!is_wanted(m, r->source->at + RECORD_HEAD)) {
            m->messages++;
            return skip(r, raw->len, error);
        }
    }
    return take_record(m, raw, m->wanted.bytes_max, out, error);
}

static int take_chunk(lum_mcap_records *m, const struct raw *raw,
                      lum_error *error)
{
    lum_source_take(m->reader->source, RECORD_HEAD);
    m->chunk_at = 0;
    return lum_mcap_chunk_read(m->chunk, m->reader, raw->len, error) == 0
               ? GO_ON
               : FAILED;
}

/* A chunk that was passed over, since it was damaged to look like another
 * record, is noticed here. */
static int take_statistics(const lum_mcap_records *m, const struct raw *raw,
                           lum_error *error)
{
    const lum_pcap *r = m->reader;
    if (raw->len < 8u) {
        return too_short(m, "record of statistics", error);
    }
    if (!lum_source_has(r->source, RECORD_HEAD + 8u)) {
        return cut(r, 0, error);
    }
    const uint64_t messages = load_le64(r->source->at + RECORD_HEAD);
    if (messages != m->messages) {
        return lum_pcap_fail(r, error,
                             "%llu messages were there, but its statistics "
                             "count %llu",
                             (unsigned long long)m->messages,
                             (unsigned long long)messages);
    }
    return skip(r, raw->len, error);
}

/* Others' may have any length. */
static int take_metadata(const lum_mcap_records *m, const struct raw *raw,
                         lum_mcap_record *out, lum_error *error)
{
    lum_source *s = m->reader->source;
    if (raw->len > LUM_MCAP_RECORD_BYTES_MAX ||
        !lum_source_has(s, RECORD_HEAD + (size_t)raw->len)) {
        return skip(m->reader, raw->len, error);
    }
    *out = (lum_mcap_record){.kind = LUM_MCAP_IS_METADATA};
    out->rest = (lum_bytes_at){s->at + RECORD_HEAD, (size_t)raw->len};
    lum_source_take(s, RECORD_HEAD + (size_t)raw->len);
    return RECORD;
}

static bool has_magic(const lum_source *s)
{
    static const uint8_t magic[MAGIC_BYTES] = {0x89, 'M', 'C',  'A',
                                               'P',  '0', '\r', '\n'};
    return memcmp(s->at, magic, MAGIC_BYTES) == 0;
}

/* The footer, the magic again, and nothing. */
static int take_footer(lum_mcap_records *m, const struct raw *raw,
                       lum_error *error)
{
    const lum_pcap *r = m->reader;
    lum_source *s = r->source;
    const int skipped = skip(r, raw->len, error);
    if (skipped != GO_ON) {
        return skipped;
    }
    if (!lum_source_has(s, MAGIC_BYTES)) {
        return cut(r, 0, error);
    }
    if (!has_magic(s)) {
        return lum_pcap_fail(r, error,
                             "its footer is not followed by an MCAP file's "
                             "last bytes");
    }
    lum_source_take(s, MAGIC_BYTES);
    m->has_ended = true;
    if (lum_source_has(s, 1)) {
        return lum_pcap_fail(r, error, "there are bytes behind its footer");
    }
    return ENDED;
}

static int next_in_file(lum_mcap_records *m, lum_mcap_record *out,
                        lum_error *error)
{
    lum_pcap *r = m->reader;
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (m->has_ended) {
        return ENDED;
    }
    if (!lum_source_has(s, RECORD_HEAD)) {
        return s->left != 0 || s->has_failed
                   ? cut(r, 0, error)
                   : lum_pcap_fail(r, error,
                                   "the file ends without a footer: it is cut "
                                   "short, or was not written to its end");
    }
    struct raw raw = {s->at[0], NULL, load_le64(s->at + 1)};
    switch (raw.opcode) {
    case 0:
        return lum_pcap_fail(r, error, "a record of type 0");
    case OP_SCHEMA:
    case OP_CHANNEL:
        return take_record(m, &raw, LUM_MCAP_RECORD_BYTES_MAX, out, error);
    case OP_MESSAGE:
        return take_message(m, &raw, out, error);
    case OP_CHUNK:
        return take_chunk(m, &raw, error);
    case OP_STATISTICS:
        return take_statistics(m, &raw, error);
    case OP_METADATA:
        return take_metadata(m, &raw, out, error);
    case OP_FOOTER:
        return take_footer(m, &raw, error);
    default:
        return skip(r, raw.len, error);
    }
}

int lum_mcap_records_next(lum_mcap_records *records, lum_mcap_record *out,
                          lum_error *error)
{
    int result = GO_ON;
    while (result == GO_ON) {
        result = is_in_chunk(records) ? next_in_chunk(records, out, error)
                                      : next_in_file(records, out, error);
    }
    return result;
}

/* --- The start and the end --- */

bool lum_mcap_is(lum_source *source)
{
    return lum_source_has(source, MAGIC_BYTES) && has_magic(source);
}

lum_mcap_records *lum_mcap_records_new(lum_pcap *reader,
                                       const lum_mcap_wanted *wanted)
{
    lum_mcap_records *m = calloc(1, sizeof *m);
    if (m == NULL || (m->chunk = lum_mcap_chunk_new()) == NULL) {
        free(m);
        return NULL;
    }
    m->reader = reader;
    m->wanted = *wanted;
    lum_source_take(reader->source, MAGIC_BYTES);
    return m;
}

void lum_mcap_records_free(lum_mcap_records *records)
{
    if (records != NULL) {
        lum_mcap_chunk_free(records->chunk);
        free(records);
    }
}
