/* Datagrams to a capture file, pcap or pcapng, each as a frame of Ethernet. */
#include "base/outfile_io.h"
#include "base/sized.h"
#include "byte_order.h"
#include "capture_internal.h"
#include "link.h"
#include "lum/capture/capture.h"
#include "pcapng_sections.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    HEADER_BYTES = ETHERNET_BYTES + IPV4_BYTES + UDP_BYTES,
    PAYLOAD_BYTES_MAX = 65535 - IPV4_BYTES - UDP_BYTES,
    SNAP_BYTES = 262144, /* what tcpdump writes */
    PROTOCOL_UDP = 17,
    VERSION = 2,
    VERSION_MINOR = 4,
    FILE_HEADER_BYTES = 24,
    RECORD_HEADER_BYTES = 16,
    /* more than all that comes before the first datagram */
    BUFFER_BYTES =
        (LUM_CAPTURE_COMMENTS_MAX + 2u) * (LUM_CAPTURE_COMMENT_BYTES_MAX + 1u),
    BLOCK_HEAD_BYTES = 28, /* of a packet's block, before the packet */
    BLOCK_TAIL_BYTES = 7,  /* most behind it */
    BYTE_ORDER_MARK = 0x1a2b3c4d,
    VERSION_PCAPNG = 1,
    OPTION_APPLICATION = 4,
    OPTION_NAME = 2,
    OPTION_RESOLUTION = 9,
    NANOSECONDS = 9 /* 10^-9 */
};

#define MAGIC_NANOSECONDS 0xa1b23c4du

struct lum_capture_writer {
    FILE *file; /* of a second descriptor of out */
    lum_outfile out;
    bool is_open;  /* out is */
    bool is_shown; /* or need not be */
    bool is_pcapng;
    size_t interface_count; /* at least 1 */
    char *buffer;           /* of file */
    uint64_t bytes;
    uint8_t record[BLOCK_HEAD_BYTES + HEADER_BYTES + PAYLOAD_BYTES_MAX +
                   BLOCK_TAIL_BYTES];
};

/* --- Frames --- */

/* The sum of 16-bit words, not yet folded; an odd byte counts as the first of a
 * word. At most 65,536 bytes, so it cannot overflow. */
static uint32_t sum_words(const uint8_t *p, size_t len)
{
    uint32_t high = 0;
    uint32_t low = 0;
    size_t i = 0;
    for (; i + 1u < len; i += 2u) {
        high += p[i];
        low += p[i + 1u];
    }
    high += i < len ? p[i] : 0u;
    return (high << 8) + low;
}

static uint16_t checksum(uint32_t sum)
{
    sum = (sum & 0xffffu) + (sum >> 16);
    sum = (sum & 0xffffu) + (sum >> 16);
    return (uint16_t)(~sum & 0xffffu);
}

/* Locally administered, made from the IPv4 address. */
static void put_mac(uint8_t *p, uint32_t address)
{
    store_big_u16(p, 0x0200);
    store_big_u32(p + 2, address);
}

static void put_ethernet(uint8_t *p, const lum_datagram *d)
{
    put_mac(p, d->destination);
    put_mac(p + 6, d->source);
    store_big_u16(p + 12, 0x0800);
}

static void put_ipv4(uint8_t *p, const lum_datagram *d)
{
    memset(p, 0, IPV4_BYTES);
    p[0] = 0x45;
    store_big_u16(p + 2, (uint32_t)(IPV4_BYTES + UDP_BYTES + d->len));
    store_big_u16(p + 6, 0x4000); /* not to be fragmented */
    p[8] = 64;
    p[9] = PROTOCOL_UDP;
    store_big_u32(p + 12, d->source);
    store_big_u32(p + 16, d->destination);
    store_big_u16(p + 10, checksum(sum_words(p, IPV4_BYTES)));
}

/* After the IPv4 header, whose addresses are in the sum. */
static void put_udp(uint8_t *p, const lum_datagram *d)
{
    const uint32_t len = (uint32_t)(UDP_BYTES + d->len);
    store_big_u16(p, d->source_port);
    store_big_u16(p + 2, d->destination_port);
    store_big_u16(p + 4, len);
    store_big_u16(p + 6, 0);
    if (d->len != 0) {
        memcpy(p + UDP_BYTES, d->payload, d->len);
    }
    const uint32_t sum = sum_words(p - 8, 8) + PROTOCOL_UDP + len;
    const uint16_t sent =
        checksum((sum & 0xffffu) + (sum >> 16) + sum_words(p, len));
    store_big_u16(p + 6, sent == 0 ? 0xffffu : sent);
}

/* --- Blocks of a pcapng file: little-endian, one section --- */

static uint8_t *put_option(uint8_t *p, unsigned code, const void *value,
                           size_t len)
{
    const size_t padded = lum_pcapng_padded(len);
    store_u16(p, code);
    store_u16(p + 2, (uint32_t)len);
    memset(p + 4, 0, padded);
    memcpy(p + 4, value, len);
    return p + 4 + padded;
}

static uint8_t *put_text(uint8_t *p, unsigned code, const char *text)
{
    return put_option(p, code, text, strlen(text));
}

/* The end of its options, and its length at both ends. */
static uint8_t *end_block(uint8_t *block, uint8_t *p)
{
    const uint32_t len = (uint32_t)(p - block) + 4u + LUM_PCAPNG_TRAILER_BYTES;
    memset(p, 0, 4);
    store_u32(p + 4, len);
    store_u32(block + 4, len);
    return block + len;
}

static uint8_t *put_section(uint8_t *block, const lum_capture_writer_options *o)
{
    uint8_t *p = block + 24;
    store_u32(block, LUM_PCAPNG_SECTION);
    store_u32(block + 8, BYTE_ORDER_MARK);
    store_u16(block + 12, VERSION_PCAPNG);
    store_u16(block + 14, 0);
    memset(block + 16, 0xff, 8); /* its length is not known */
    if (o->application != NULL) {
        p = put_text(p, OPTION_APPLICATION, o->application);
    }
    for (size_t i = 0; i < o->comment_count; i++) {
        p = put_text(p, LUM_PCAP_COMMENT, o->comments[i]);
    }
    return end_block(block, p);
}

static uint8_t *put_interface(uint8_t *block, const char *name)
{
    const uint8_t resolution = NANOSECONDS;
    uint8_t *p = block + 16;
    store_u32(block, LUM_PCAPNG_INTERFACE);
    store_u16(block + 8, LINKTYPE_ETHERNET);
    store_u16(block + 10, 0);
    store_u32(block + 12, SNAP_BYTES);
    if (*name != '\0') {
        p = put_text(p, OPTION_NAME, name);
    }
    return end_block(block, put_option(p, OPTION_RESOLUTION, &resolution, 1));
}

/* The block about a packet that is in its place already. Returns its bytes. */
static size_t put_around(uint8_t *block, uint32_t interface, int64_t time_ns,
                         uint32_t len)
{
    const uint64_t time = (uint64_t)time_ns;
    const size_t tail = BLOCK_HEAD_BYTES + lum_pcapng_padded(len);
    const size_t all = tail + LUM_PCAPNG_TRAILER_BYTES;
    store_u32(block, LUM_PCAPNG_ENHANCED_PACKET);
    store_u32(block + 4, (uint32_t)all);
    store_u32(block + 8, interface);
    store_u32(block + 12, (uint32_t)(time >> 32));
    store_u32(block + 16, (uint32_t)(time & UINT32_MAX));
    store_u32(block + 20, len);
    store_u32(block + 24, len);
    memset(block + BLOCK_HEAD_BYTES + len, 0, lum_pcapng_padded(len) - len);
    store_u32(block + tail, (uint32_t)all);
    return all;
}

/* --- Opening --- */

static int failed(const lum_capture_writer *w, lum_error *error)
{
    return lum_outfile_fail(&w->out, errno, "cannot be written", error);
}

static void release(lum_capture_writer *w)
{
    if (w->file != NULL && w->out.is_older) {
        lum_outfile_turn_away(w->file);
    }
    if (w->file != NULL) {
        (void)fclose(w->file);
    }
    if (w->is_open) {
        lum_outfile_discard(&w->out);
    }
    free(w->buffer);
    free(w);
}

static int open_stream(lum_capture_writer *w)
{
    w->file = lum_outfile_stream(&w->out);
    return w->file != NULL &&
                   setvbuf(w->file, w->buffer, _IOFBF, BUFFER_BYTES) == 0
               ? 0
               : -1;
}

static int write_start(lum_capture_writer *w, const void *bytes, size_t len,
                       lum_error *error)
{
    w->bytes = len;
    return fwrite(bytes, len, 1, w->file) == 1 ? 0 : failed(w, error);
}

/* Little-endian, as most hosts would write it. */
static int begin_pcap(lum_capture_writer *w, lum_error *error)
{
    uint8_t header[FILE_HEADER_BYTES] = {0};
    store_u32(header, MAGIC_NANOSECONDS);
    store_u16(header + 4, VERSION);
    store_u16(header + 6, VERSION_MINOR);
    store_u32(header + 16, SNAP_BYTES);
    store_u32(header + 20, LINKTYPE_ETHERNET);
    return write_start(w, header, sizeof header, error);
}

static int begin_pcapng(lum_capture_writer *w,
                        const lum_capture_writer_options *o, lum_error *error)
{
    uint8_t *bytes = malloc(BUFFER_BYTES);
    if (bytes == NULL) {
        return lum_error_set(error, "%s: not enough memory to write it",
                             w->out.name);
    }
    uint8_t *p = put_section(bytes, o);
    for (size_t i = 0; i < w->interface_count; i++) {
        p = put_interface(p, o->interface_count > 0 ? o->interfaces[i] : "");
    }
    const int result = write_start(w, bytes, (size_t)(p - bytes), error);
    const int code = errno;
    free(bytes);
    errno = code;
    return result;
}

static int begin(lum_capture_writer *w, const lum_capture_writer_options *o,
                 lum_error *error)
{
    if (open_stream(w) != 0) {
        return failed(w, error);
    }
    return w->is_pcapng ? begin_pcapng(w, o, error) : begin_pcap(w, error);
}

/* Whether texts fit their options. */
static bool has_good_texts(const lum_capture_writer_options *o)
{
    bool is_good = o->comment_count <= LUM_CAPTURE_COMMENTS_MAX &&
                   o->interface_count <= LUM_CAPTURE_INTERFACES_MAX &&
                   (o->application == NULL ||
                    strlen(o->application) <= LUM_CAPTURE_COMMENT_BYTES_MAX);
    for (size_t i = 0; is_good && i < o->comment_count; i++) {
        is_good = strlen(o->comments[i]) <= LUM_CAPTURE_COMMENT_BYTES_MAX;
    }
    for (size_t i = 0; is_good && i < o->interface_count; i++) {
        is_good = strlen(o->interfaces[i]) < LUM_INTERFACE_BYTES;
    }
    return is_good;
}

static int check_options(const char *path, const lum_capture_writer_options *o,
                         lum_error *error)
{
    const bool has_text = o->application != NULL || o->comment_count > 0;
    const bool is_pcap = o->format == LUM_CAPTURE_PCAP;
    if (o->format != LUM_CAPTURE_PCAP && o->format != LUM_CAPTURE_PCAPNG) {
        (void)lum_error_set(error, "%s: %u is not a format of captures", path,
                            (unsigned)o->format);
    } else if (is_pcap && has_text) {
        (void)lum_error_set(error, "%s: a pcap file has no comments", path);
    } else if (is_pcap && o->interface_count > 0) {
        (void)lum_error_set(error,
                            "%s: a pcap file has no names of interfaces; a "
                            "pcapng file has",
                            path);
    } else if (!is_pcap && !has_good_texts(o)) {
        (void)lum_error_set(
            error,
            "%s: a pcapng file has at most %u comments; each, "
            "and the application, at most %u bytes; and at "
            "most %u interfaces with names of at most %u bytes",
            path, LUM_CAPTURE_COMMENTS_MAX, LUM_CAPTURE_COMMENT_BYTES_MAX,
            LUM_CAPTURE_INTERFACES_MAX, LUM_INTERFACE_BYTES - 1u);
    } else {
        return 0;
    }
    errno = EINVAL;
    return -1;
}

static int open_writer(const char *path, const lum_capture_writer_options *o,
                       lum_capture_writer **out, lum_error *error)
{
    const lum_outfile_kind kind =
        o->is_whole ? LUM_OUTFILE_WHOLE : LUM_OUTFILE_GROWS;
    lum_capture_writer *w = calloc(1, sizeof *w);
    char *buffer = malloc(BUFFER_BYTES);
    if (w == NULL || buffer == NULL) {
        free(w);
        free(buffer);
        return lum_error_set(error, "%s: not enough memory to write it", path);
    }
    w->buffer = buffer;
    w->is_shown = o->is_whole;
    w->is_pcapng = o->format == LUM_CAPTURE_PCAPNG;
    w->interface_count = o->interface_count > 0 ? o->interface_count : 1u;
    w->is_open = lum_outfile_open(path, kind, &w->out, error) == 0;
    if (!w->is_open || begin(w, o, error) != 0) {
        const int code = errno;
        release(w);
        errno = code;
        return -1;
    }
    *out = w;
    return 0;
}

int lum_capture_writer_open_as(const char *path,
                               const lum_capture_writer_options *options,
                               lum_capture_writer **out, lum_error *error)
{
    lum_capture_writer_options o;
    return lum_sized_take(&o, sizeof o, options, "the capture writer's options",
                          "lum_capture_writer_options", error) == 0 &&
                   check_options(path, &o, error) == 0
               ? open_writer(path, &o, out, error)
               : -1;
}

int lum_capture_writer_open(const char *path, lum_capture_writer **out,
                            lum_error *error)
{
    const lum_capture_writer_options o = {.struct_size = sizeof o};
    return open_writer(path, &o, out, error);
}

int lum_capture_writer_open_whole(const char *path, lum_capture_writer **out,
                                  lum_error *error)
{
    const lum_capture_writer_options o = {.struct_size = sizeof o,
                                          .is_whole = true};
    return open_writer(path, &o, out, error);
}

/* --- Writing --- */

static int check_datagram(const lum_capture_writer *w, const lum_datagram *d,
                          lum_error *error)
{
    if (d->len > PAYLOAD_BYTES_MAX) {
        return lum_error_set(
            error, "%s: a datagram of %zu bytes; at most %d can be written",
            w->out.name, d->len, (int)PAYLOAD_BYTES_MAX);
    }
    if (d->time_ns < 0 || d->time_ns / 1000000000 > UINT32_MAX) {
        return lum_error_set(error,
                             "%s: a capture time of %lld s since 1970; from 0 "
                             "to 4294967295 can be written",
                             w->out.name, (long long)(d->time_ns / 1000000000));
    }
    return 0;
}

static int show(lum_capture_writer *w, lum_error *error)
{
    w->is_shown = true;
    return lum_outfile_show(&w->out, error);
}

static void put_packet(uint8_t *p, const lum_datagram *d)
{
    put_ethernet(p, d);
    put_ipv4(p + ETHERNET_BYTES, d);
    put_udp(p + ETHERNET_BYTES + IPV4_BYTES, d);
}

/* Returns the record's bytes. */
static size_t put_record(uint8_t *p, const lum_datagram *d)
{
    const uint32_t len = (uint32_t)(HEADER_BYTES + d->len);
    store_u32(p, (uint32_t)(d->time_ns / 1000000000));
    store_u32(p + 4, (uint32_t)(d->time_ns % 1000000000));
    store_u32(p + 8, len);
    store_u32(p + 12, len);
    put_packet(p + RECORD_HEADER_BYTES, d);
    return RECORD_HEADER_BYTES + len;
}

static size_t put_block(uint8_t *p, size_t interface, const lum_datagram *d)
{
    put_packet(p + BLOCK_HEAD_BYTES, d);
    return put_around(p, (uint32_t)interface, d->time_ns,
                      (uint32_t)(HEADER_BYTES + d->len));
}

int lum_capture_writer_add(lum_capture_writer *writer,
                           const lum_datagram *datagram, lum_error *error)
{
    return lum_capture_writer_add_from(writer, 0, datagram, error);
}

int lum_capture_writer_add_from(lum_capture_writer *writer, size_t interface,
                                const lum_datagram *datagram, lum_error *error)
{
    if (interface >= writer->interface_count) {
        return lum_error_set(
            error, "%s: interface %zu of %zu; use 0 to %zu", writer->out.name,
            interface, writer->interface_count, writer->interface_count - 1u);
    }
    if (check_datagram(writer, datagram, error) != 0 ||
        (!writer->is_shown && show(writer, error) != 0)) {
        return -1;
    }
    const size_t len = writer->is_pcapng
                           ? put_block(writer->record, interface, datagram)
                           : put_record(writer->record, datagram);
    const bool is_good = fwrite(writer->record, len, 1, writer->file) == 1;
    writer->bytes += len;
    lum_outfile_wrote(&writer->out, len);
    return is_good ? 0 : failed(writer, error);
}

uint64_t lum_capture_writer_bytes(const lum_capture_writer *writer)
{
    return writer->bytes;
}

int lum_capture_writer_copy(const lum_capture_writer *writer)
{
    return lum_outfile_copy(&writer->out);
}

const char *lum_capture_writer_name(const lum_capture_writer *writer)
{
    return writer->out.name;
}

/* An older file stays as it is until it is emptied. */
static int flush(const lum_capture_writer *w)
{
    return w->out.is_older ? 0 : fflush(w->file);
}

int lum_capture_writer_flush(lum_capture_writer *writer, lum_error *error)
{
    if (lum_outfile_is_unread(&writer->out)) {
        errno = EPIPE;
        return failed(writer, error);
    }
    return flush(writer) == 0 ? 0 : failed(writer, error);
}

int lum_capture_writer_check(const lum_capture_writer *writer, lum_error *error)
{
    return lum_outfile_check(&writer->out, error);
}

/* --- The end --- */

/* A recording that nothing was recorded to takes no other file's place. */
static bool is_empty_recording(const lum_capture_writer *w)
{
    return !w->is_shown && (w->out.part != NULL || w->out.is_older);
}

/* fclose() would do it too late to report an error. */
int lum_capture_writer_close(lum_capture_writer *writer, lum_error *error)
{
    if (writer == NULL) {
        return 0;
    }
    int result = 0;
    if (ferror(writer->file) || flush(writer) != 0) {
        result = failed(writer, error);
    } else if (!is_empty_recording(writer)) {
        result = lum_outfile_finish(&writer->out, error);
    }
    const int reason = errno;
    release(writer);
    errno = reason;
    return result;
}

/* fclose() would write the buffered bytes, and may wait for a reader. */
void lum_capture_writer_abort(lum_capture_writer *writer)
{
    if (writer == NULL) {
        return;
    }
    if (writer->out.path == NULL || writer->out.part != NULL) {
        lum_outfile_turn_away(writer->file);
    }
    release(writer);
}
