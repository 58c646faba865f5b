/* MCAP files (https://mcap.dev/spec): the datagrams in messages of
 * lumsdk_msgs/msg/Datagram, each as an IPv4 packet. The index at the end is
 * not used, so a file may come through a pipe. */
#include "mcap_chunk.h"
#include "mcap_comments.h"
#include "mcap_datagram.h"
#include "pcap_internal.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC_BYTES  8u
#define RECORD_HEAD  9u
#define MESSAGE_HEAD 22u
#define SCHEMA_NAME  "lumsdk_msgs/msg/Datagram"

/* Most bytes of a schema, of a channel, or of a datagram's message; a schema
 * has all definitions that it needs as a text. */
#define RECORD_BYTES_MAX ((uint32_t)1 << 20)

#define IDS 65536u /* of schemas, and of channels */

enum {
    LINKTYPE_IPV4 = 228,
    HEADERS_BYTES = 28, /* of IPv4 and UDP */
    DATAGRAM_BYTES_MAX = 65507,
    IPV4_VERSION_AND_WORDS = 0x45,
    IPV4_TTL = 64,
    IPV4_UDP = 17,
    NAME_BYTES = 80
};

enum opcode {
    OP_HEADER = 1,
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
    PACKET,
    GO_ON
};

struct lum_mcap_reader {
    lum_mcap_chunk *chunk;
    size_t chunk_at;            /* in its records; at their end: none is left */
    uint64_t messages;          /* of all channels, so far */
    bool has_ended;             /* its footer was read */
    bool has_ours;              /* a channel with datagrams was described */
    char other[NAME_BYTES];     /* the first other schema; "": none */
    uint8_t schemas[IDS / 8u];  /* a bit for each one of datagrams */
    uint8_t channels[IDS / 8u]; /* likewise */
    uint8_t packet[HEADERS_BYTES + DATAGRAM_BYTES_MAX];
};

/* A record's bytes, without its opcode and length. */
struct record {
    unsigned opcode;
    const uint8_t *at;
    uint64_t len;
};

static bool has_bit(const uint8_t *bits, unsigned id)
{
    return (bits[id / 8u] >> id % 8u & 1u) != 0;
}

static void set_bit(uint8_t *bits, unsigned id, bool value)
{
    const unsigned bit = 1u << id % 8u;
    bits[id / 8u] =
        (uint8_t)(value ? bits[id / 8u] | bit : bits[id / 8u] & ~bit);
}

/* --- Schemas and channels --- */

/* A text at *at, which then is behind it; NULL where the record ends first. */
static const uint8_t *take_text(const struct record *r, size_t *at, size_t *len)
{
    if (*at > r->len || r->len - *at < 4u) {
        return NULL;
    }
    *len = load_le32(r->at + *at);
    const uint8_t *text = r->at + *at + 4;
    if (*len > r->len - *at - 4u) {
        return NULL;
    }
    *at += 4u + *len;
    return text;
}

static bool is_text(const uint8_t *text, size_t len, const char *wanted)
{
    return len == strlen(wanted) && memcmp(text, wanted, len) == 0;
}

/* For messages: what no terminal takes for a command. */
static void keep_name(char *out, const uint8_t *name, size_t len)
{
    const size_t kept = len < NAME_BYTES - 1u ? len : NAME_BYTES - 1u;
    for (size_t i = 0; i < kept; i++) {
        out[i] = name[i] > ' ' && name[i] < 0x7f ? (char)name[i] : '?';
    }
    out[kept] = '\0';
}

static int too_short(const lum_pcap *r, const char *what, lum_error *error)
{
    return lum_pcap_fail(r, error, "a %s is shorter than what it says it has",
                         what);
}

static int read_schema(lum_pcap *r, const struct record *record,
                       lum_error *error)
{
    lum_mcap_reader *m = r->mcap;
    size_t at = 2;
    size_t name_len = 0;
    size_t encoding_len = 0;
    const uint8_t *name = take_text(record, &at, &name_len);
    const uint8_t *encoding = take_text(record, &at, &encoding_len);
    if (name == NULL || encoding == NULL) {
        return too_short(r, "schema", error);
    }
    const bool is_ours = is_text(name, name_len, SCHEMA_NAME) &&
                         is_text(encoding, encoding_len, "ros2msg");
    set_bit(m->schemas, load_le16(record->at), is_ours);
    if (!is_ours && m->other[0] == '\0') {
        keep_name(m->other, name, name_len);
    }
    return GO_ON;
}

static int read_channel(lum_pcap *r, const struct record *record,
                        lum_error *error)
{
    lum_mcap_reader *m = r->mcap;
    size_t at = 4;
    size_t len = 0;
    size_t encoding_len = 0;
    const uint8_t *topic = take_text(record, &at, &len);
    const uint8_t *encoding = take_text(record, &at, &encoding_len);
    if (topic == NULL || encoding == NULL) {
        return too_short(r, "channel", error);
    }
    const bool is_ours = has_bit(m->schemas, load_le16(record->at + 2)) &&
                         is_text(encoding, encoding_len, "cdr");
    set_bit(m->channels, load_le16(record->at), is_ours);
    m->has_ours = m->has_ours || is_ours;
    return GO_ON;
}

/* --- Messages --- */

static void make_packet(lum_mcap_reader *m, const lum_record *datagram,
                        uint32_t whole, lum_pcap_record *out)
{
    uint8_t *p = m->packet;
    memset(p, 0, HEADERS_BYTES);
    p[0] = IPV4_VERSION_AND_WORDS;
    store_be16(p + 2, HEADERS_BYTES + whole);
    p[8] = IPV4_TTL;
    p[9] = IPV4_UDP;
    store_be32(p + 12, datagram->source);
    store_be32(p + 16, datagram->destination);
    store_be16(p + 20, datagram->source_port);
    store_be16(p + 22, datagram->destination_port);
    store_be16(p + 24, 8u + whole);
    if (datagram->len != 0) {
        memcpy(p + HEADERS_BYTES, datagram->payload, datagram->len);
    }
    *out = (lum_pcap_record){.time_ns = datagram->time_ns,
                             .bytes = p,
                             .len = HEADERS_BYTES + (uint32_t)datagram->len,
                             .whole = HEADERS_BYTES + whole,
                             .link_type = LINKTYPE_IPV4};
}

/* Whether a message of which at least the channel is at hand has a datagram. */
static bool is_ours(const lum_pcap *r, const uint8_t *message)
{
    return has_bit(r->mcap->channels, load_le16(message));
}

static int read_message(lum_pcap *r, const struct record *record,
                        lum_pcap_record *out, lum_error *error)
{
    lum_record datagram;
    uint32_t whole = 0;
    if (record->len < MESSAGE_HEAD ||
        !lum_mcap_datagram_read(record->at + MESSAGE_HEAD,
                                (size_t)record->len - MESSAGE_HEAD, &datagram,
                                &whole) ||
        whole > DATAGRAM_BYTES_MAX) {
        return lum_pcap_fail(
            r, error, "a message of " SCHEMA_NAME " does not hold a datagram");
    }
    make_packet(r->mcap, &datagram, whole, out);
    return PACKET;
}

/* A record whose bytes are at hand. */
static int read_record(lum_pcap *r, const struct record *record,
                       lum_pcap_record *out, lum_error *error)
{
    if (record->opcode == OP_SCHEMA) {
        return record->len < 2u ? too_short(r, "schema", error)
                                : read_schema(r, record, error);
    }
    if (record->opcode == OP_CHANNEL) {
        return record->len < 4u ? too_short(r, "channel", error)
                                : read_channel(r, record, error);
    }
    if (record->opcode != OP_MESSAGE) {
        return GO_ON;
    }
    r->mcap->messages++;
    if (record->len < 2u) {
        return too_short(r, "message", error);
    }
    return is_ours(r, record->at) ? read_message(r, record, out, error) : GO_ON;
}

/* --- Records in a chunk --- */

static int next_in_chunk(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_mcap_reader *m = r->mcap;
    const lum_bytes_at all = lum_mcap_chunk_records(m->chunk);
    const size_t left = all.len - m->chunk_at;
    const uint8_t *at = all.at + m->chunk_at;
    if (left < RECORD_HEAD || load_le64(at + 1) > left - RECORD_HEAD) {
        return lum_pcap_fail(r, error,
                             "a record of a chunk is longer than "
                             "what is left of the chunk");
    }
    const struct record record = {at[0], at + RECORD_HEAD, load_le64(at + 1)};
    m->chunk_at += RECORD_HEAD + (size_t)record.len;
    return read_record(r, &record, out, error);
}

static bool is_in_chunk(const lum_mcap_reader *m)
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
static int skip(lum_pcap *r, uint64_t len, lum_error *error)
{
    return lum_source_skip(r->source, RECORD_HEAD) &&
                   lum_source_skip(r->source, len)
               ? GO_ON
               : cut(r, len > UINT64_MAX - RECORD_HEAD ? 0 : RECORD_HEAD + len,
                     error);
}

/* A record that is looked at as a whole. */
static int take_record(lum_pcap *r, struct record *record, lum_pcap_record *out,
                       lum_error *error)
{
    lum_source *s = r->source;
    if (record->len > RECORD_BYTES_MAX) {
        return lum_pcap_fail(r, error,
                             "a record of type %u has %llu bytes; at most %lu "
                             "are possible",
                             record->opcode, (unsigned long long)record->len,
                             (unsigned long)RECORD_BYTES_MAX);
    }
    const size_t all = RECORD_HEAD + (size_t)record->len;
    if (!lum_source_has(s, all)) {
        return cut(r, all, error);
    }
    record->at = s->at + RECORD_HEAD;
    const int result = read_record(r, record, out, error);
    lum_source_take(s, all);
    return result;
}

/* Others' may have any length. */
static int take_message(lum_pcap *r, struct record *record,
                        lum_pcap_record *out, lum_error *error)
{
    if (record->len >= 2u) {
        if (!lum_source_has(r->source, RECORD_HEAD + 2u)) {
            return cut(r, 0, error);
        }
        if (!is_ours(r, r->source->at + RECORD_HEAD)) {
            r->mcap->messages++;
            return skip(r, record->len, error);
        }
    }
    return take_record(r, record, out, error);
}

static int take_chunk(lum_pcap *r, const struct record *record,
                      lum_error *error)
{
    lum_source_take(r->source, RECORD_HEAD);
    r->mcap->chunk_at = 0;
    return lum_mcap_chunk_read(r->mcap->chunk, r, record->len, error) == 0
               ? GO_ON
               : FAILED;
}

/* A chunk that was passed over, since it was damaged to look like another
 * record, is noticed here. */
static int take_statistics(lum_pcap *r, const struct record *record,
                           lum_error *error)
{
    if (record->len < 8u) {
        return too_short(r, "record of statistics", error);
    }
    if (!lum_source_has(r->source, RECORD_HEAD + 8u)) {
        return cut(r, 0, error);
    }
    const uint64_t messages = load_le64(r->source->at + RECORD_HEAD);
    if (messages != r->mcap->messages) {
        return lum_pcap_fail(r, error,
                             "%llu messages were there, but its statistics "
                             "count %llu",
                             (unsigned long long)r->mcap->messages,
                             (unsigned long long)messages);
    }
    return skip(r, record->len, error);
}

static void take_comment(void *context, const uint8_t *text, size_t len)
{
    const lum_pcap *r = context;
    if (r->take_option != NULL) {
        r->take_option(r->option_context, LUM_PCAP_SECTION, LUM_PCAP_COMMENT,
                       text, len);
    }
}

/* Others' may have any length. */
static int take_metadata(lum_pcap *r, const struct record *record,
                         lum_error *error)
{
    lum_source *s = r->source;
    if (record->len <= RECORD_BYTES_MAX &&
        lum_source_has(s, RECORD_HEAD + (size_t)record->len)) {
        lum_mcap_comments_read(s->at + RECORD_HEAD, (size_t)record->len,
                               take_comment, r);
    }
    return skip(r, record->len, error);
}

static bool has_magic(const lum_source *s)
{
    static const uint8_t magic[MAGIC_BYTES] = {0x89, 'M', 'C',  'A',
                                               'P',  '0', '\r', '\n'};
    return memcmp(s->at, magic, MAGIC_BYTES) == 0;
}

/* The footer, the magic again, and nothing. */
static int take_footer(lum_pcap *r, const struct record *record,
                       lum_error *error)
{
    lum_source *s = r->source;
    const int skipped = skip(r, record->len, error);
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
    r->mcap->has_ended = true;
    if (lum_source_has(s, 1)) {
        return lum_pcap_fail(r, error, "there are bytes behind its footer");
    }
    return ENDED;
}

static int next_in_file(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (r->mcap->has_ended) {
        return ENDED;
    }
    if (!lum_source_has(s, RECORD_HEAD)) {
        return s->left != 0 || s->has_failed
                   ? cut(r, 0, error)
                   : lum_pcap_fail(r, error,
                                   "the file ends without a footer: it is cut "
                                   "short, or was not written to its end");
    }
    struct record record = {s->at[0], NULL, load_le64(s->at + 1)};
    switch (record.opcode) {
    case 0:
        return lum_pcap_fail(r, error, "a record of type 0");
    case OP_SCHEMA:
    case OP_CHANNEL:
        return take_record(r, &record, out, error);
    case OP_MESSAGE:
        return take_message(r, &record, out, error);
    case OP_CHUNK:
        return take_chunk(r, &record, error);
    case OP_STATISTICS:
        return take_statistics(r, &record, error);
    case OP_METADATA:
        return take_metadata(r, &record, error);
    case OP_FOOTER:
        return take_footer(r, &record, error);
    default:
        return skip(r, record.len, error);
    }
}

static int next_step(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    return is_in_chunk(r->mcap) ? next_in_chunk(r, out, error)
                                : next_in_file(r, out, error);
}

static int next_packet(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    int result = GO_ON;
    while (result == GO_ON) {
        result = next_step(r, out, error);
    }
    return result;
}

/* --- The start and the end --- */

bool lum_mcap_is(lum_source *source)
{
    return lum_source_has(source, MAGIC_BYTES) && has_magic(source);
}

void lum_mcap_reader_free(lum_mcap_reader *reader)
{
    if (reader != NULL) {
        lum_mcap_chunk_free(reader->chunk);
        free(reader);
    }
}

static int refuse_without_packets(const lum_mcap_reader *m, lum_error *error)
{
    return lum_error_set(
        error,
        "it has no packets of a sensor, %s%s; clouds cannot be decoded again",
        m->other[0] != '\0' ? "only messages such as " : "and no messages",
        m->other);
}

int lum_mcap_reader_begin(lum_pcap *reader, uint32_t *link_type,
                          lum_error *error)
{
    const lum_pcap_interface interface = {.link_type = LINKTYPE_IPV4};
    lum_pcap_record none;
    lum_mcap_reader *m = calloc(1, sizeof *m);
    reader->mcap = m;
    reader->next = next_packet;
    if (m == NULL || (m->chunk = lum_mcap_chunk_new()) == NULL) {
        return lum_error_set(error, "not enough memory to read an MCAP file");
    }
    lum_source_take(reader->source, MAGIC_BYTES);
    int result = GO_ON;
    while (result == GO_ON && !m->has_ours) {
        result = next_step(reader, &none, error);
    }
    if (result == ENDED) {
        return refuse_without_packets(m, error);
    }
    if (result == FAILED ||
        lum_pcap_add_interface(reader, &interface, error) != 0) {
        return -1;
    }
    *link_type = LINKTYPE_IPV4;
    return reader->has_wanted;
}
