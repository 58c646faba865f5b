/* MCAP files with the datagrams of a sensor, in messages of
 * lumsdk_msgs/msg/Datagram, each as an IPv4 packet. */
#include "comments.h"
#include "datagram_packet.h"
#include "mcap_records.h"
#include "pcap.h"

#include <stdlib.h>
#include <string.h>

#define SCHEMA_NAME "lumsdk_msgs/msg/Datagram"

#define NAME_BYTES 80u

struct lum_mcap_reader {
    lum_mcap_records *records;
    bool has_ours;  /* a channel with datagrams came */
    bool has_first; /* a packet waits, since it began */
    lum_pcap_record first;
    char other[NAME_BYTES];             /* the first other schema; "": none */
    uint8_t schemas[LUM_MCAP_IDS / 8];  /* a bit for each one of datagrams */
    uint8_t channels[LUM_MCAP_IDS / 8]; /* likewise */
    uint8_t known[LUM_MCAP_IDS / 8];    /* channels of any kind */
    uint8_t packet[LUM_DATAGRAM_PACKET_MAX];
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

static void know_schema(lum_mcap_reader *m, const lum_mcap_record *schema)
{
    const bool is_ours = lum_mcap_is_text(schema->name, SCHEMA_NAME) &&
                         lum_mcap_is_text(schema->encoding, "ros2msg");
    set_bit(m->schemas, schema->id, is_ours);
    if (!is_ours && m->other[0] == '\0') {
        const size_t len = schema->name.len;
        lum_chunk_name(m->other, schema->name.at,
                       len < NAME_BYTES ? len : NAME_BYTES - 1u);
    }
}

static void know_channel(lum_mcap_reader *m, const lum_mcap_record *channel)
{
    const bool is_ours = has_bit(m->schemas, channel->schema) &&
                         lum_mcap_is_text(channel->encoding, "cdr");
    set_bit(m->channels, channel->id, is_ours);
    set_bit(m->known, channel->id, true);
    m->has_ours = m->has_ours || is_ours;
}

/* --- Messages --- */

static lum_mcap_want wants(const void *context, unsigned channel)
{
    const lum_mcap_reader *m = context;
    if (!has_bit(m->known, channel)) {
        return LUM_MCAP_UNKNOWN;
    }
    return has_bit(m->channels, channel) ? LUM_MCAP_HAND_OUT
                                         : LUM_MCAP_PASS_OVER;
}

static int read_message(lum_pcap *r, lum_bytes_at message, lum_pcap_record *out)
{
    lum_record datagram;
    uint32_t whole = 0;
    if (!lum_mcap_datagram_read(message.at, message.len, &datagram, &whole) ||
        whole > LUM_DATAGRAM_BYTES_MAX) {
        lum_error why = {""};
        (void)lum_pcap_fail(
            r, &why, "a message of " SCHEMA_NAME " does not hold a datagram");
        lum_pcap_note_damage(r, &why);
        return LUM_PCAP_GO_ON;
    }
    lum_datagram_packet_make(&datagram, whole, r->mcap->packet, out);
    return LUM_PCAP_READ;
}

static void take_comment(void *context, const uint8_t *text, size_t len)
{
    const lum_pcap *r = context;
    if (r->take_option != NULL) {
        r->take_option(r->option_context, LUM_PCAP_SECTION, LUM_PCAP_COMMENT,
                       text, len);
    }
}

static int next_step(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_mcap_record record;
    const int result = lum_mcap_records_next(r->mcap->records, &record, error);
    if (result != 1) {
        return result == 0 ? LUM_PCAP_ENDED : LUM_PCAP_FAILED;
    }
    switch (record.kind) {
    case LUM_MCAP_IS_SCHEMA:
        know_schema(r->mcap, &record);
        break;
    case LUM_MCAP_IS_CHANNEL:
        know_channel(r->mcap, &record);
        break;
    case LUM_MCAP_IS_MESSAGE:
        return read_message(r, record.rest, out);
    case LUM_MCAP_IS_METADATA:
        lum_mcap_comments_read(record.rest.at, record.rest.len, take_comment,
                               r);
        break;
    }
    return LUM_PCAP_GO_ON;
}

static int next_packet(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    int result = LUM_PCAP_GO_ON;
    if (r->mcap->has_first) {
        r->mcap->has_first = false;
        *out = r->mcap->first;
        return LUM_PCAP_READ;
    }
    while (result == LUM_PCAP_GO_ON) {
        result = next_step(r, out, error);
    }
    return result;
}

/* --- The start and the end --- */

void lum_mcap_reader_free(lum_mcap_reader *reader)
{
    if (reader != NULL) {
        lum_mcap_records_free(reader->records);
        free(reader);
    }
}

static int refuse_without_packets(const lum_pcap *r, lum_error *error)
{
    const char *other = r->mcap->other;
    return lum_error_set(
        error,
        "it has no packets of a sensor, %s%s; clouds cannot be decoded "
        "again%s%s",
        other[0] != '\0' ? "only messages such as " : "and no messages", other,
        r->damaged != 0 ? "; " : "", r->damage.text);
}

/* Of a file with damage, up to a packet: what describes it may stand at its
 * end, and all of its data be damaged. */
static bool has_begun(const lum_pcap *r)
{
    return r->mcap->has_ours && (r->damaged == 0 || r->mcap->has_first);
}

int lum_mcap_reader_begin(lum_pcap *reader, uint32_t *link_type,
                          lum_error *error)
{
    const lum_pcap_interface interface = {.link_type = LUM_DATAGRAM_LINK_TYPE};
    lum_mcap_reader *m = calloc(1, sizeof *m);
    const lum_mcap_wanted wanted = {wants, m, LUM_MCAP_RECORD_BYTES_MAX};
    reader->mcap = m;
    reader->next = next_packet;
    if (m == NULL ||
        (m->records = lum_mcap_records_new(reader, &wanted)) == NULL) {
        return lum_error_set(error, "not enough memory to read an MCAP file");
    }
    int result = LUM_PCAP_GO_ON;
    while (result == LUM_PCAP_GO_ON && !has_begun(reader)) {
        result = next_step(reader, &m->first, error);
        m->has_first = result == LUM_PCAP_READ;
    }
    if (result != LUM_PCAP_GO_ON && result != LUM_PCAP_READ &&
        lum_pcap_is_spoilt(reader) && (m->has_ours || m->other[0] == '\0')) {
        return lum_pcap_fail_damaged(reader, error);
    }
    if (result == LUM_PCAP_ENDED) {
        return refuse_without_packets(reader, error);
    }
    if (result == LUM_PCAP_FAILED ||
        lum_pcap_add_interface(reader, &interface, error) != 0) {
        return -1;
    }
    *link_type = LUM_DATAGRAM_LINK_TYPE;
    return reader->has_wanted;
}
