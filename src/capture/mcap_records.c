#include "mcap_records.h"

#include "pcap.h"
#include "unpack.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC_BYTES  8u
#define RECORD_HEAD  9u
#define MESSAGE_HEAD 22u
#define FOOTER_BYTES 20u
#define CHUNK_HEAD   32u /* up to the name of the compression */
#define CHUNK_LENGTH 8u  /* of its records, behind that name */

enum opcode {
    OP_FOOTER = 2,
    OP_SCHEMA = 3,
    OP_CHANNEL = 4,
    OP_MESSAGE = 5,
    OP_CHUNK = 6,
    OP_STATISTICS = 11,
    OP_METADATA = 12
};

struct lum_mcap_records {
    lum_pcap *reader;
    lum_mcap_wanted wanted;
    lum_chunk chunk;
    size_t chunk_at;   /* in its records; at their end: none is left */
    uint64_t messages; /* of all channels, so far */
    bool has_ended;    /* its footer was read */
    bool has_salvaged; /* what the end of the file describes was looked for */
    bool is_salvaging; /* that is read now */
    uint64_t back;     /* to be read behind that */
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
    if (from->len < 4u || load_u32(from->at) > from->len - 4u) {
        return false;
    }
    *out = (lum_bytes_at){from->at + 4, load_u32(from->at)};
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
    (void)lum_pcap_fail(m->reader, error, "a %s is shorter than it declares",
                        what);
    return LUM_PCAP_DAMAGED;
}

static int read_schema(const lum_mcap_records *m, const struct raw *raw,
                       lum_mcap_record *out, lum_error *error)
{
    if (raw->len < 2u) {
        return too_short(m, "schema", error);
    }
    *out =
        (lum_mcap_record){.kind = LUM_MCAP_IS_SCHEMA, .id = load_u16(raw->at)};
    out->rest = (lum_bytes_at){raw->at + 2, (size_t)raw->len - 2u};
    return lum_mcap_take_text(&out->rest, &out->name) &&
                   lum_mcap_take_text(&out->rest, &out->encoding)
               ? LUM_PCAP_READ
               : too_short(m, "schema", error);
}

static int read_channel(const lum_mcap_records *m, const struct raw *raw,
                        lum_mcap_record *out, lum_error *error)
{
    if (raw->len < 4u) {
        return too_short(m, "channel", error);
    }
    *out = (lum_mcap_record){.kind = LUM_MCAP_IS_CHANNEL,
                             .id = load_u16(raw->at),
                             .schema = load_u16(raw->at + 2)};
    out->rest = (lum_bytes_at){raw->at + 4, (size_t)raw->len - 4u};
    return lum_mcap_take_text(&out->rest, &out->name) &&
                   lum_mcap_take_text(&out->rest, &out->encoding)
               ? LUM_PCAP_READ
               : too_short(m, "channel", error);
}

static int not_described(const lum_mcap_records *m, unsigned channel,
                         lum_error *error)
{
    (void)lum_pcap_fail(m->reader, error,
                        "a message of channel %u, which was not described "
                        "before",
                        channel);
    return LUM_PCAP_DAMAGED;
}

/* Of which at least the channel is at hand: LUM_PCAP_READ, LUM_PCAP_GO_ON or
 * LUM_PCAP_DAMAGED. */
static int look_at_message(const lum_mcap_records *m, const uint8_t *message,
                           lum_error *error)
{
    const unsigned channel = load_u16(message);
    const lum_mcap_want want = m->wanted.wants(m->wanted.context, channel);
    if (want == LUM_MCAP_UNKNOWN) {
        return not_described(m, channel, error);
    }
    return want == LUM_MCAP_HAND_OUT ? LUM_PCAP_READ : LUM_PCAP_GO_ON;
}

static int read_message(lum_mcap_records *m, const struct raw *raw,
                        lum_mcap_record *out, lum_error *error)
{
    m->messages++;
    if (raw->len < 2u) {
        return too_short(m, "message", error);
    }
    const int look = look_at_message(m, raw->at, error);
    if (look != LUM_PCAP_READ) {
        return look;
    }
    if (raw->len < MESSAGE_HEAD) {
        return too_short(m, "message", error);
    }
    *out = (lum_mcap_record){.kind = LUM_MCAP_IS_MESSAGE,
                             .id = load_u16(raw->at),
                             .log_ns = load_u64(raw->at + 6)};
    out->rest =
        (lum_bytes_at){raw->at + MESSAGE_HEAD, (size_t)raw->len - MESSAGE_HEAD};
    return LUM_PCAP_READ;
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
        return LUM_PCAP_GO_ON;
    }
}

/* --- Records in a chunk --- */

static int next_in_chunk(lum_mcap_records *m, lum_mcap_record *out,
                         lum_error *error)
{
    const lum_chunk_bytes all = m->chunk.records;
    const size_t left = all.len - m->chunk_at;
    const uint8_t *at = all.at + m->chunk_at;
    if (left < RECORD_HEAD || load_u64(at + 1) > left - RECORD_HEAD) {
        m->chunk_at = all.len;
        (void)lum_pcap_fail(
            m->reader, error,
            "a record of a chunk is longer than the rest of the chunk");
        return LUM_PCAP_DAMAGED;
    }
    const struct raw raw = {at[0], at + RECORD_HEAD, load_u64(at + 1)};
    m->chunk_at += RECORD_HEAD + (size_t)raw.len;
    return read_raw(m, &raw, out, error);
}

static bool is_in_chunk(const lum_mcap_records *m)
{
    return m->chunk_at < m->chunk.records.len;
}

/* --- Records of the file --- */

/* Behind its head, which is at hand. */
static int skip(const lum_pcap *r, uint64_t len, lum_error *error)
{
    return lum_source_skip(r->source, RECORD_HEAD) &&
                   lum_source_skip(r->source, len)
               ? LUM_PCAP_GO_ON
               : lum_pcap_fail_cut(
                     r, "record",
                     len > UINT64_MAX - RECORD_HEAD ? 0 : RECORD_HEAD + len,
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
        const int skipped = skip(r, raw->len, error);
        if (skipped != LUM_PCAP_GO_ON) {
            return skipped;
        }
        (void)lum_pcap_fail(r, error,
                            "a record of type %u has %llu bytes; at most %lu "
                            "are possible",
                            raw->opcode, (unsigned long long)raw->len,
                            (unsigned long)max);
        return LUM_PCAP_DAMAGED;
    }
    const size_t all = RECORD_HEAD + (size_t)raw->len;
    if (!lum_source_has(s, all)) {
        return lum_pcap_fail_cut(r, "record", all, error);
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
            return lum_pcap_fail_cut(r, "record", 0, error);
        }
        const int look = look_at_message(m, r->source->at + RECORD_HEAD, error);
        if (look != LUM_PCAP_READ) {
            lum_error why = {""};
            m->messages++;
            const int skipped = skip(r, raw->len, &why);
            *error = skipped == LUM_PCAP_GO_ON ? *error : why;
            return skipped == LUM_PCAP_GO_ON ? look : skipped;
        }
    }
    return take_record(m, raw, m->wanted.bytes_max, out, error);
}

/* More bytes of the record, of which left are; they stay until taken. */
static int need(const lum_mcap_records *m, size_t bytes, uint64_t left,
                lum_error *error)
{
    const lum_pcap *r = m->reader;
    if (bytes > left) {
        return too_short(m, "chunk", error);
    }
    if (!lum_source_has(r->source, bytes)) {
        return lum_pcap_fail_cut(r, "chunk", 0, error);
    }
    return LUM_PCAP_GO_ON;
}

static int read_chunk_head(const lum_mcap_records *m, uint64_t left,
                           lum_chunk_head *head, lum_error *error)
{
    lum_source *s = m->reader->source;
    int result = need(m, CHUNK_HEAD, left, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    head->unpacked = load_u64(s->at + 16);
    head->crc = load_u32(s->at + 24);
    const size_t len = load_u32(s->at + 28);
    if (len > LUM_CHUNK_NAME_MAX) {
        (void)lum_pcap_fail(m->reader, error,
                            "a chunk's compression has a name of %zu bytes",
                            len);
        return LUM_PCAP_DAMAGED;
    }
    const size_t all = CHUNK_HEAD + len + CHUNK_LENGTH;
    result = need(m, all, left, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    lum_chunk_name(head->compression, s->at + CHUNK_HEAD, len);
    head->packed = load_u64(s->at + CHUNK_HEAD + len);
    lum_source_take(s, all);
    return head->packed <= left - all ? LUM_PCAP_GO_ON
                                      : too_short(m, "chunk", error);
}

/* All of its record is taken, also if it is damaged. */
static int take_chunk(lum_mcap_records *m, const struct raw *raw,
                      lum_error *error)
{
    static const char *const known[] = {"zstd", "lz4"};
    lum_source *s = m->reader->source;
    lum_chunk_head head = {.known = known,
                           .fix = lum_unpack_zstd != NULL ? "mcap compress"
                                                          : "mcap decompress"};
    lum_source_take(s, RECORD_HEAD);
    const uint64_t begin = lum_source_offset(s);
    m->chunk_at = 0;
    m->chunk.records.len = 0;
    int result = read_chunk_head(m, raw->len, &head, error);
    if (result == LUM_PCAP_GO_ON) {
        result = lum_chunk_read(&m->chunk, m->reader, &head, error);
    }
    if (result != LUM_PCAP_FAILED &&
        !lum_source_skip(s, raw->len - (lum_source_offset(s) - begin))) {
        m->chunk.records.len = 0;
        return lum_pcap_fail_cut(m->reader, "chunk", 0, error);
    }
    return result;
}

/* A chunk that was passed over, since it was damaged to look like another
 * record, is noticed here. How many messages a damaged one had is not known. */
static int take_statistics(const lum_mcap_records *m, const struct raw *raw,
                           lum_error *error)
{
    const lum_pcap *r = m->reader;
    if (raw->len < 8u) {
        const int skipped = skip(r, raw->len, error);
        return skipped == LUM_PCAP_GO_ON
                   ? too_short(m, "record of statistics", error)
                   : skipped;
    }
    if (!lum_source_has(r->source, RECORD_HEAD + 8u)) {
        return lum_pcap_fail_cut(r, "record", 0, error);
    }
    const uint64_t messages = load_u64(r->source->at + RECORD_HEAD);
    if (messages != m->messages && r->damaged == 0) {
        return lum_pcap_fail(
            r, error, "%llu messages were read, but its statistics count %llu",
            (unsigned long long)m->messages, (unsigned long long)messages);
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
    return LUM_PCAP_READ;
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
    if (skipped != LUM_PCAP_GO_ON) {
        return skipped;
    }
    if (!lum_source_has(s, MAGIC_BYTES)) {
        return lum_pcap_fail_cut(r, "record", 0, error);
    }
    if (!has_magic(s)) {
        return lum_pcap_fail(r, error,
                             "its footer is not followed by an MCAP file's "
                             "last bytes");
    }
    lum_source_take(s, MAGIC_BYTES);
    m->has_ended = true;
    if (lum_source_has(s, 1)) {
        return lum_pcap_fail(r, error, "bytes follow its footer");
    }
    return LUM_PCAP_ENDED;
}

static int next_in_file(lum_mcap_records *m, lum_mcap_record *out,
                        lum_error *error)
{
    lum_pcap *r = m->reader;
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (m->has_ended) {
        return LUM_PCAP_ENDED;
    }
    if (!lum_source_has(s, RECORD_HEAD)) {
        return s->left != 0 || s->has_failed
                   ? lum_pcap_fail_cut(r, "record", 0, error)
                   : lum_pcap_fail(r, error,
                                   "the file ends without a footer: it was cut "
                                   "short or never finished");
    }
    struct raw raw = {s->at[0], NULL, load_u64(s->at + 1)};
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

/* --- What a damaged part has described --- */

static int go_back(lum_mcap_records *m, lum_error *error)
{
    m->is_salvaging = false;
    return lum_source_seek(m->reader->source, m->back, error) == 0
               ? LUM_PCAP_GO_ON
               : LUM_PCAP_FAILED;
}

/* The source is at the summary then; 0: there is none. */
static bool find_summary(lum_source *s)
{
    const size_t all = RECORD_HEAD + FOOTER_BYTES + MAGIC_BYTES;
    const uint64_t total = s->functions.total;
    if (total < all || lum_source_seek(s, total - all, NULL) != 0 ||
        !lum_source_has(s, all) || s->at[0] != OP_FOOTER ||
        load_u64(s->at + 1) != FOOTER_BYTES) {
        return false;
    }
    const uint64_t summary = load_u64(s->at + RECORD_HEAD);
    return summary >= MAGIC_BYTES && summary < total - all &&
           lum_source_seek(s, summary, NULL) == 0;
}

/* Writers describe a channel once in the data, and again at the end. */
static int begin_salvage(lum_mcap_records *m, lum_error *error)
{
    lum_source *s = m->reader->source;
    if (m->has_salvaged || !lum_source_can_seek(s)) {
        return LUM_PCAP_GO_ON;
    }
    m->has_salvaged = true;
    m->back = lum_source_offset(s);
    m->is_salvaging = true;
    return find_summary(s) ? LUM_PCAP_GO_ON : go_back(m, error);
}

/* Up to what is no longer part of a good summary. */
static int next_of_summary(lum_mcap_records *m, lum_mcap_record *out,
                           lum_error *error)
{
    lum_source *s = m->reader->source;
    lum_error none = {""};
    int result = LUM_PCAP_FAILED;
    if (lum_source_has(s, RECORD_HEAD)) {
        struct raw raw = {s->at[0], NULL, load_u64(s->at + 1)};
        if (raw.opcode == OP_SCHEMA || raw.opcode == OP_CHANNEL) {
            result =
                take_record(m, &raw, LUM_MCAP_RECORD_BYTES_MAX, out, &none);
        } else if (raw.opcode != OP_FOOTER && raw.opcode != 0) {
            result = skip(m->reader, raw.len, &none);
        }
    }
    return result == LUM_PCAP_READ || result == LUM_PCAP_GO_ON
               ? result
               : go_back(m, error);
}

static int next_step(lum_mcap_records *m, lum_mcap_record *out,
                     lum_error *error)
{
    if (m->is_salvaging) {
        return next_of_summary(m, out, error);
    }
    return is_in_chunk(m) ? next_in_chunk(m, out, error)
                          : next_in_file(m, out, error);
}

int lum_mcap_records_next(lum_mcap_records *records, lum_mcap_record *out,
                          lum_error *error)
{
    lum_error why; /* clearing all of it takes as long as a message */
    int result = LUM_PCAP_GO_ON;
    why.text[0] = '\0';
    while (result == LUM_PCAP_GO_ON) {
        result = next_step(records, out, &why);
        if (result == LUM_PCAP_DAMAGED) {
            lum_pcap_note_damage(records->reader, &why);
            result = begin_salvage(records, &why);
        }
    }
    return result == LUM_PCAP_FAILED ? lum_error_set(error, "%s", why.text)
                                     : result;
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
    if (m != NULL) {
        lum_crc32_init(&m->chunk.crc);
        m->reader = reader;
        m->wanted = *wanted;
        lum_source_take(reader->source, MAGIC_BYTES);
    }
    return m;
}

void lum_mcap_records_free(lum_mcap_records *records)
{
    if (records != NULL) {
        lum_chunk_release(&records->chunk);
        free(records);
    }
}
