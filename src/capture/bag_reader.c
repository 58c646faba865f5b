/* Bags of ROS 1, format 2.0 (https://wiki.ros.org/Bags/Format/2.0): the packets
 * in messages of lumsdk_ros/Packets, each as an IPv4 packet. The index is not
 * used, so a bag may come through a pipe; but where a part is damaged, the
 * connections that it has again are read if they can be. */
#include "bag_packets.h"
#include "chunk.h"
#include "datagram_packet.h"
#include "pcap.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC       "#ROSBAG V2.0\n"
#define MAGIC_BYTES (sizeof MAGIC - 1u)
#define TYPE        "lumsdk_ros/Packets"

/* Most bytes of a record's header, and of a connection's, which has the
 * definition of its messages as a text. */
#define HEADER_BYTES_MAX ((uint32_t)1 << 16)
#define CONNECTION_MAX   ((uint32_t)1 << 20)

#define CONNECTIONS 65536u

enum opcode {
    OP_MESSAGE = 2,
    OP_BAG = 3,
    OP_CHUNK = 5,
    OP_CONNECTION = 7
};

struct lum_bag_reader {
    lum_bag_packets *packets;
    lum_chunk chunk;    /* one that is compressed */
    lum_source *inner;  /* its records; NULL: none is read */
    uint64_t chunk_end; /* of one that is not, in the source */
    uint64_t index;     /* where connections stand again; 0: not known */
    bool has_salvaged;  /* they were looked for */
    bool has_ours;      /* a connection with packets was described */
    bool has_message;   /* and one of its messages came */
    int end;            /* LUM_PCAP_GO_ON until it ended or failed */
    lum_error error;    /* of the failure */
    uint8_t ours[CONNECTIONS / 8u];  /* a bit for each such connection */
    uint8_t known[CONNECTIONS / 8u]; /* and of any kind */
    uint8_t packet[LUM_DATAGRAM_PACKET_MAX];
};

/* A record, whose header is at hand. */
struct record {
    lum_bytes_at header;
    uint32_t data_len;
};

/* --- Headers --- */

/* The value of a field; its bytes are NULL where there is none. */
static lum_bytes_at find(lum_bytes_at fields, const char *name)
{
    const size_t name_len = strlen(name);
    while (fields.len >= 4u) {
        const uint32_t n = load_u32(fields.at);
        const uint8_t *field = fields.at + 4;
        if (n > fields.len - 4u) {
            break;
        }
        if (n > name_len && memcmp(field, name, name_len) == 0 &&
            field[name_len] == '=') {
            return (lum_bytes_at){field + name_len + 1u, n - name_len - 1u};
        }
        fields.at += 4u + n;
        fields.len -= 4u + n;
    }
    return (lum_bytes_at){NULL, 0};
}

static bool is(lum_bytes_at value, const char *wanted)
{
    return value.at != NULL && value.len == strlen(wanted) &&
           memcmp(value.at, wanted, value.len) == 0;
}

/* One of four bytes; UINT32_MAX: there is none. */
static uint32_t number(lum_bytes_at header, const char *name)
{
    const lum_bytes_at value = find(header, name);
    return value.at != NULL && value.len == 4u ? load_u32(value.at)
                                               : UINT32_MAX;
}

static unsigned opcode_of(lum_bytes_at header)
{
    const lum_bytes_at op = find(header, "op");
    return op.at != NULL && op.len == 1u ? op.at[0] : 0;
}

static bool has_bit(const uint8_t *bits, uint32_t id)
{
    return id < CONNECTIONS && (bits[id / 8u] >> id % 8u & 1u) != 0;
}

/* --- Records --- */

/* Records of a compressed chunk stand in memory. */
static lum_source *current(const lum_pcap *r)
{
    return r->bag->inner != NULL ? r->bag->inner : r->source;
}

/* How many bytes records may have here; UINT64_MAX: as many as there are. */
static uint64_t room_of(const lum_pcap *r)
{
    const lum_bag_reader *b = r->bag;
    if (b->inner != NULL) {
        return b->inner->left;
    }
    const uint64_t at = lum_source_offset(r->source);
    return at < b->chunk_end ? b->chunk_end - at : UINT64_MAX;
}

static int skip(const lum_pcap *r, uint64_t bytes, lum_error *error)
{
    return lum_source_skip(current(r), bytes)
               ? LUM_PCAP_GO_ON
               : lum_pcap_fail_cut(r, "record", 0, error);
}

/* What is left of the chunk cannot be read. */
static int leave_chunk(lum_pcap *r, const char *what, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    const int skipped = skip(r, room_of(r), error);
    b->chunk_end = 0;
    if (skipped == LUM_PCAP_GO_ON) {
        (void)lum_pcap_fail(
            r, error, "%s of a chunk is longer than the rest of the chunk",
            what);
    }
    return skipped == LUM_PCAP_GO_ON ? LUM_PCAP_DAMAGED : skipped;
}

/* The header of the next record is at hand then, with the length behind it. */
static int read_header(lum_pcap *r, struct record *out, lum_error *error)
{
    lum_source *s = current(r);
    const uint64_t room = room_of(r);
    r->at = s == r->source ? lum_source_offset(s) : r->at;
    if (room < 8u) {
        return leave_chunk(r, "a record", error);
    }
    if (!lum_source_has(s, 4)) {
        return s->left != 0 || s->has_failed
                   ? lum_pcap_fail_cut(r, "record", 0, error)
                   : LUM_PCAP_ENDED;
    }
    const uint32_t len = load_u32(s->at);
    const size_t all = 8u + (size_t)len;
    if (all > room) {
        return leave_chunk(r, "the header of a record", error);
    }
    if (len > HEADER_BYTES_MAX) {
        return lum_pcap_fail(r, error,
                             "the header of a record has %lu bytes; at most "
                             "%lu are possible",
                             (unsigned long)len,
                             (unsigned long)HEADER_BYTES_MAX);
    }
    if (!lum_source_has(s, all)) {
        return lum_pcap_fail_cut(r, "record", all, error);
    }
    out->header = (lum_bytes_at){s->at + 4, len};
    out->data_len = load_u32(s->at + 4u + len);
    return out->data_len <= room - all ? LUM_PCAP_GO_ON
                                       : leave_chunk(r, "a record", error);
}

/* A record that is looked at as a whole; its header moves with it. */
static int has_data(lum_pcap *r, struct record *record, uint32_t most,
                    const char *what, lum_bytes_at *data, lum_error *error)
{
    const size_t head = 8u + record->header.len;
    lum_source *s = current(r);
    if (record->data_len > most) {
        (void)lum_pcap_fail(
            r, error, "%s has %lu bytes; at most %lu are possible", what,
            (unsigned long)record->data_len, (unsigned long)most);
        return LUM_PCAP_DAMAGED;
    }
    if (!lum_source_has(s, head + record->data_len)) {
        return lum_pcap_fail_cut(r, "record", head + record->data_len, error);
    }
    record->header.at = s->at + 4;
    *data = (lum_bytes_at){s->at + head, record->data_len};
    return LUM_PCAP_GO_ON;
}

static int take_connection(lum_pcap *r, struct record *record, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_bytes_at data = {NULL, 0};
    const int result =
        has_data(r, record, CONNECTION_MAX, "a connection", &data, error);
    const uint32_t id =
        result == LUM_PCAP_GO_ON ? number(record->header, "conn") : CONNECTIONS;
    if (id < CONNECTIONS) {
        b->known[id / 8u] |= (uint8_t)(1u << id % 8u);
        if (is(find(data, "type"), TYPE)) {
            b->ours[id / 8u] |= (uint8_t)(1u << id % 8u);
            b->has_ours = true;
        }
    }
    return result;
}

static int take_message(lum_pcap *r, struct record *record, lum_error *error)
{
    lum_bytes_at data = {NULL, 0};
    const uint32_t id = number(record->header, "conn");
    if (!has_bit(r->bag->known, id)) {
        (void)lum_pcap_fail(r, error,
                            "a message of connection %lu, which was not "
                            "described before",
                            (unsigned long)id);
        return LUM_PCAP_DAMAGED;
    }
    if (!has_bit(r->bag->ours, id)) {
        return LUM_PCAP_GO_ON;
    }
    const int result = has_data(r, record, LUM_BAG_MESSAGE_MAX,
                                "a message of " TYPE, &data, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    const int added = lum_bag_packets_add(r->bag->packets, data.at, data.len);
    if (added < 0) {
        return lum_pcap_fail(r, error, "not enough memory for a message");
    }
    if (added == 0) {
        (void)lum_pcap_fail(r, error,
                            "a message of " TYPE " contradicts itself");
        return LUM_PCAP_DAMAGED;
    }
    r->bag->has_message = true;
    return LUM_PCAP_GO_ON;
}

/* --- Chunks --- */

static int unpack_chunk(lum_pcap *r, const lum_chunk_head *head,
                        lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_source *s = r->source;
    const uint64_t end = b->chunk_end;
    const int result = lum_chunk_read(&b->chunk, r, head, error);
    if (result != LUM_PCAP_FAILED &&
        !lum_source_skip(s, end - lum_source_offset(s))) {
        return lum_pcap_fail_cut(r, "record", 0, error);
    }
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    b->inner = lum_source_from_memory("a chunk", b->chunk.records.at,
                                      b->chunk.records.len);
    return b->inner != NULL
               ? LUM_PCAP_GO_ON
               : lum_pcap_fail(r, error, "not enough memory for a chunk");
}

/* What it has is read all the same. UINT32_MAX: it does not say. */
static int check_plain(const lum_pcap *r, const lum_chunk_head *head,
                       lum_error *error)
{
    return head->unpacked == UINT32_MAX ? LUM_PCAP_GO_ON
                                        : lum_chunk_check_plain(r, head, error);
}

/* Records stand in a chunk as they do beside it. One that is not compressed is
 * read where it is, so that one that is cut gives what it has. */
static int enter_chunk(lum_pcap *r, const struct record *record,
                       lum_error *error)
{
    static const char *const known[] = {"bz2", "lz4"};
    const lum_bytes_at name = find(record->header, "compression");
    lum_chunk_head head = {.packed = record->data_len,
                           .unpacked = number(record->header, "size"),
                           .known = known,
                           .fix = "rosbag decompress"};
    if (name.len == 0 || name.len > LUM_CHUNK_NAME_MAX) {
        head.compression[0] = '?';
    } else {
        lum_chunk_name(head.compression, name.at, name.len);
    }
    lum_source_take(r->source, 8u + record->header.len);
    r->bag->chunk_end = lum_source_offset(r->source) + record->data_len;
    return is(name, "none") ? check_plain(r, &head, error)
                            : unpack_chunk(r, &head, error);
}

/* --- From record to record --- */

static int take_bag(lum_pcap *r, const struct record *record)
{
    const lum_bytes_at at = find(record->header, "index_pos");
    r->bag->index = at.len == 8u ? load_u64(at.at) : 0;
    return LUM_PCAP_GO_ON;
}

static int take_record(lum_pcap *r, struct record *record, lum_error *error)
{
    switch (opcode_of(record->header)) {
    case 0:
        (void)lum_pcap_fail(r, error, "a record without a type");
        return room_of(r) != UINT64_MAX ? LUM_PCAP_DAMAGED : LUM_PCAP_FAILED;
    case OP_BAG:
        return take_bag(r, record);
    case OP_CONNECTION:
        return take_connection(r, record, error);
    case OP_MESSAGE:
        return take_message(r, record, error);
    default:
        return LUM_PCAP_GO_ON;
    }
}

static int pass_over(const lum_pcap *r, const struct record *record,
                     lum_error *error)
{
    return skip(r, 8u + (uint64_t)record->header.len + record->data_len, error);
}

static int read_record(lum_pcap *r, lum_error *error)
{
    struct record record = {{NULL, 0}, 0};
    lum_error why = {""};
    int result = read_header(r, &record, error);
    if (result != LUM_PCAP_GO_ON) {
        return result;
    }
    if (opcode_of(record.header) == OP_CHUNK && room_of(r) == UINT64_MAX) {
        return enter_chunk(r, &record, error);
    }
    result = take_record(r, &record, error);
    if (result == LUM_PCAP_FAILED ||
        pass_over(r, &record, &why) == LUM_PCAP_GO_ON) {
        return result;
    }
    return lum_error_set(error, "%s", why.text);
}

/* --- What a damaged part has described --- */

/* Up to what is no connection any more. */
static void read_connections(lum_pcap *r)
{
    struct record record = {{NULL, 0}, 0};
    lum_error why = {""};
    while (read_header(r, &record, &why) == LUM_PCAP_GO_ON &&
           opcode_of(record.header) == OP_CONNECTION &&
           take_connection(r, &record, &why) == LUM_PCAP_GO_ON &&
           pass_over(r, &record, &why) == LUM_PCAP_GO_ON) {
    }
}

/* The index of a bag begins with all of them. */
static int salvage(lum_pcap *r, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_source *s = r->source;
    const uint64_t back = lum_source_offset(s);
    const uint64_t at = r->at;
    const uint64_t chunk_end = b->chunk_end;
    lum_source *inner = b->inner;
    if (b->has_salvaged || b->index == 0 || !lum_source_can_seek(s)) {
        return LUM_PCAP_GO_ON;
    }
    b->has_salvaged = true;
    b->inner = NULL;
    b->chunk_end = 0;
    if (lum_source_seek(s, b->index, NULL) == 0) {
        read_connections(r);
    }
    b->inner = inner;
    b->chunk_end = chunk_end;
    r->at = at;
    return lum_source_seek(s, back, error) == 0 ? LUM_PCAP_GO_ON
                                                : LUM_PCAP_FAILED;
}

static int next_record(lum_pcap *r, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_error why = {""};
    if (b->inner != NULL && b->inner->left == 0) {
        lum_source_close(b->inner);
        b->inner = NULL;
    }
    int result = read_record(r, &why);
    if (result == LUM_PCAP_DAMAGED) {
        lum_pcap_note_damage(r, &why);
        result = salvage(r, &why);
    }
    return result == LUM_PCAP_FAILED ? lum_error_set(error, "%s", why.text)
                                     : result;
}

/* --- Packets --- */

static int next_packet(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_record datagram;
    while (!lum_bag_packets_next(b->packets, &datagram)) {
        if (b->end == LUM_PCAP_FAILED && error != NULL) {
            *error = b->error;
        }
        if (b->end != LUM_PCAP_GO_ON) {
            return b->end;
        }
        b->end = next_record(r, &b->error);
        if (b->end != LUM_PCAP_GO_ON) {
            lum_bag_packets_end(b->packets);
        }
    }
    lum_datagram_packet_make(&datagram, (uint32_t)datagram.len, b->packet, out);
    return LUM_PCAP_READ;
}

/* --- The start and the end --- */

bool lum_bag_is(lum_source *source)
{
    return lum_source_has(source, MAGIC_BYTES) &&
           memcmp(source->at, MAGIC, MAGIC_BYTES) == 0;
}

void lum_bag_reader_free(lum_bag_reader *reader)
{
    if (reader != NULL) {
        lum_bag_packets_free(reader->packets);
        lum_source_close(reader->inner);
        lum_chunk_release(&reader->chunk);
        free(reader);
    }
}

/* Of a bag with damage, up to a message: what describes it may stand at its
 * end, and all of its data be damaged. */
static bool has_begun(const lum_pcap *r)
{
    return r->bag->has_ours && (r->damaged == 0 || r->bag->has_message);
}

int lum_bag_reader_begin(lum_pcap *reader, uint32_t *link_type,
                         lum_error *error)
{
    const lum_pcap_interface interface = {.link_type = LUM_DATAGRAM_LINK_TYPE};
    lum_bag_reader *b = calloc(1, sizeof *b);
    reader->bag = b;
    reader->next = next_packet;
    if (b == NULL || (b->packets = lum_bag_packets_new()) == NULL) {
        return lum_error_set(error, "not enough memory to read a bag");
    }
    b->end = LUM_PCAP_GO_ON;
    lum_source_take(reader->source, MAGIC_BYTES);
    int result = LUM_PCAP_GO_ON;
    while (result == LUM_PCAP_GO_ON && !has_begun(reader)) {
        result = next_record(reader, error);
    }
    if (result != LUM_PCAP_GO_ON && lum_pcap_is_spoilt(reader)) {
        return lum_pcap_fail_damaged(reader, error);
    }
    if (result == LUM_PCAP_ENDED) {
        return lum_error_set(error, "it has no messages of " TYPE
                                    "; clouds cannot be decoded again");
    }
    if (result == LUM_PCAP_FAILED ||
        lum_pcap_add_interface(reader, &interface, error) != 0) {
        return -1;
    }
    *link_type = LUM_DATAGRAM_LINK_TYPE;
    return reader->has_wanted;
}
