/* Bags of ROS 1, format 2.0 (https://wiki.ros.org/Bags/Format/2.0): the packets
 * in messages of lumsdk_ros/Packets, each as an IPv4 packet. The index is not
 * used, so a bag may come through a pipe. */
#include "bag_packets.h"
#include "datagram_packet.h"
#include "pcap_internal.h"

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
    OP_CHUNK = 5,
    OP_CONNECTION = 7
};

enum step {
    FAILED = -1,
    ENDED,
    PACKET,
    GO_ON
};

struct lum_bag_reader {
    lum_bag_packets *packets;
    bool has_ours;   /* a connection with packets was described */
    int end;         /* GO_ON until the bag ENDED or FAILED */
    lum_error error; /* of the failure */
    uint8_t ours[CONNECTIONS / 8u]; /* a bit for each such connection */
    uint8_t packet[LUM_DATAGRAM_PACKET_MAX];
};

/* Bytes of the source's window. */
struct bytes {
    const uint8_t *at;
    size_t len;
};

/* A record, whose header is at hand. */
struct record {
    struct bytes header;
    uint32_t data_len;
};

/* --- Headers --- */

/* The value of a field; its bytes are NULL where there is none. */
static struct bytes find(struct bytes fields, const char *name)
{
    const size_t name_len = strlen(name);
    while (fields.len >= 4u) {
        const uint32_t n = load_le32(fields.at);
        const uint8_t *field = fields.at + 4;
        if (n > fields.len - 4u) {
            break;
        }
        if (n > name_len && memcmp(field, name, name_len) == 0 &&
            field[name_len] == '=') {
            return (struct bytes){field + name_len + 1u, n - name_len - 1u};
        }
        fields.at += 4u + n;
        fields.len -= 4u + n;
    }
    return (struct bytes){NULL, 0};
}

static bool is(struct bytes value, const char *wanted)
{
    return value.at != NULL && value.len == strlen(wanted) &&
           memcmp(value.at, wanted, value.len) == 0;
}

/* One of four bytes; UINT32_MAX: there is none. */
static uint32_t number(struct bytes header, const char *name)
{
    const struct bytes value = find(header, name);
    return value.at != NULL && value.len == 4u ? load_le32(value.at)
                                               : UINT32_MAX;
}

static unsigned opcode_of(struct bytes header)
{
    const struct bytes op = find(header, "op");
    return op.at != NULL && op.len == 1u ? op.at[0] : 0;
}

/* --- Records --- */

static int cut(const lum_pcap *r, uint64_t all, lum_error *error)
{
    const lum_source *s = r->source;
    return lum_pcap_fail_cut(r, "record", s->end - r->at, all, error);
}

static int skip(lum_pcap *r, uint64_t bytes, lum_error *error)
{
    return lum_source_skip(r->source, bytes) ? GO_ON : cut(r, 0, error);
}

/* The header of the next record is at hand then, with the length behind it. */
static int read_header(lum_pcap *r, struct record *out, lum_error *error)
{
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (!lum_source_has(s, 4)) {
        return s->left != 0 || s->has_failed ? cut(r, 0, error) : ENDED;
    }
    const uint32_t len = load_le32(s->at);
    if (len > HEADER_BYTES_MAX) {
        return lum_pcap_fail(r, error,
                             "the header of a record has %lu bytes; at most "
                             "%lu are possible",
                             (unsigned long)len,
                             (unsigned long)HEADER_BYTES_MAX);
    }
    const size_t all = 8u + (size_t)len;
    if (!lum_source_has(s, all)) {
        return cut(r, all, error);
    }
    out->header = (struct bytes){s->at + 4, len};
    out->data_len = load_le32(s->at + 4u + len);
    return GO_ON;
}

/* A record that is looked at as a whole; its header moves with it. */
static int has_data(lum_pcap *r, struct record *record, uint32_t most,
                    const char *what, struct bytes *data, lum_error *error)
{
    const size_t head = 8u + record->header.len;
    if (record->data_len > most) {
        return lum_pcap_fail(
            r, error, "%s has %lu bytes; at most %lu are possible", what,
            (unsigned long)record->data_len, (unsigned long)most);
    }
    if (!lum_source_has(r->source, head + record->data_len)) {
        return cut(r, head + record->data_len, error);
    }
    record->header.at = r->source->at + 4;
    *data = (struct bytes){r->source->at + head, record->data_len};
    return GO_ON;
}

static int take_connection(lum_pcap *r, struct record *record, lum_error *error)
{
    struct bytes data = {NULL, 0};
    const int result =
        has_data(r, record, CONNECTION_MAX, "a connection", &data, error);
    if (result != GO_ON) {
        return result;
    }
    const uint32_t id = number(record->header, "conn");
    if (is(find(data, "type"), TYPE) && id < CONNECTIONS) {
        r->bag->ours[id / 8u] |= (uint8_t)(1u << id % 8u);
        r->bag->has_ours = true;
    }
    return GO_ON;
}

static int take_message(lum_pcap *r, struct record *record, lum_error *error)
{
    struct bytes data = {NULL, 0};
    const uint32_t id = number(record->header, "conn");
    if (id >= CONNECTIONS || (r->bag->ours[id / 8u] >> id % 8u & 1u) == 0) {
        return GO_ON;
    }
    const int result = has_data(r, record, LUM_BAG_MESSAGE_MAX,
                                "a message of " TYPE, &data, error);
    if (result != GO_ON) {
        return result;
    }
    const int added = lum_bag_packets_add(r->bag->packets, data.at, data.len);
    if (added < 0) {
        return lum_pcap_fail(r, error, "not enough memory for a message");
    }
    return added > 0
               ? GO_ON
               : lum_pcap_fail(r, error,
                               "a message of " TYPE " contradicts itself");
}

/* Records stand in a chunk as they do beside it, if it is not compressed. */
static int enter_chunk(lum_pcap *r, const struct record *record,
                       lum_error *error)
{
    const struct bytes compression = find(record->header, "compression");
    if (!is(compression, "none")) {
        return lum_pcap_fail(r, error,
                             "its chunks are compressed by %s, which is not "
                             "read; rosbag decompress makes a bag that is",
                             is(compression, "bz2")   ? "bz2"
                             : is(compression, "lz4") ? "lz4"
                                                      : "something else");
    }
    return skip(r, 8u + record->header.len, error);
}

static int next_record(lum_pcap *r, lum_error *error)
{
    struct record record = {{NULL, 0}, 0};
    int result = read_header(r, &record, error);
    if (result != GO_ON) {
        return result;
    }
    const unsigned op = opcode_of(record.header);
    if (op == OP_CHUNK) {
        return enter_chunk(r, &record, error);
    }
    if (op == 0) {
        return lum_pcap_fail(r, error, "a record without a type");
    }
    if (op == OP_CONNECTION) {
        result = take_connection(r, &record, error);
    } else if (op == OP_MESSAGE) {
        result = take_message(r, &record, error);
    }
    return result == GO_ON
               ? skip(r, 8u + (uint64_t)record.header.len + record.data_len,
                      error)
               : result;
}

/* --- Packets --- */

static int next_packet(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_bag_reader *b = r->bag;
    lum_record datagram;
    while (!lum_bag_packets_next(b->packets, &datagram)) {
        if (b->end == FAILED && error != NULL) {
            *error = b->error;
        }
        if (b->end != GO_ON) {
            return b->end;
        }
        b->end = next_record(r, &b->error);
        if (b->end != GO_ON) {
            lum_bag_packets_end(b->packets);
        }
    }
    lum_datagram_packet_make(&datagram, (uint32_t)datagram.len, b->packet, out);
    return PACKET;
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
        free(reader);
    }
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
    b->end = GO_ON;
    lum_source_take(reader->source, MAGIC_BYTES);
    int result = GO_ON;
    while (result == GO_ON && !b->has_ours) {
        result = next_record(reader, error);
    }
    if (result == ENDED) {
        return lum_error_set(error, "it has no messages of " TYPE
                                    "; clouds cannot be decoded again");
    }
    if (result == FAILED ||
        lum_pcap_add_interface(reader, &interface, error) != 0) {
        return -1;
    }
    *link_type = LUM_DATAGRAM_LINK_TYPE;
    return reader->has_wanted;
}
