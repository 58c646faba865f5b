#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE /* the types that pcap.h needs */

#include "be.h"
#include "lum/io/capture.h"

#include <errno.h>
#include <fcntl.h>
#include <pcap/pcap.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    ETHERNET_BYTES = 14,
    IPV4_BYTES = 20,
    UDP_BYTES = 8,
    HEADER_BYTES = ETHERNET_BYTES + IPV4_BYTES + UDP_BYTES,
    PAYLOAD_BYTES_MAX = 65535 - IPV4_BYTES - UDP_BYTES,
    SNAP_BYTES = 262144, /* what tcpdump writes */
    PROTOCOL_UDP = 17,
    FILE_HEADER_BYTES = 24,
    RECORD_HEADER_BYTES = 16,
    BUFFER_BYTES = 1024 * 1024
};

struct lum_capture_writer {
    pcap_t *pcap;
    pcap_dumper_t *dumper; /* closes file */
    FILE *file;
    int second_fd; /* of the same file */
    char *name;
    char *buffer; /* of file */
    uint64_t bytes;
    uint8_t frame[HEADER_BYTES + PAYLOAD_BYTES_MAX];
};

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
    store_be16(p, 0x0200);
    store_be32(p + 2, address);
}

static void put_ethernet(uint8_t *p, const lum_datagram *d)
{
    put_mac(p, d->destination);
    put_mac(p + 6, d->source);
    store_be16(p + 12, 0x0800);
}

static void put_ipv4(uint8_t *p, const lum_datagram *d)
{
    memset(p, 0, IPV4_BYTES);
    p[0] = 0x45;
    store_be16(p + 2, (uint32_t)(IPV4_BYTES + UDP_BYTES + d->len));
    store_be16(p + 6, 0x4000); /* not to be fragmented */
    p[8] = 64;
    p[9] = PROTOCOL_UDP;
    store_be32(p + 12, d->source);
    store_be32(p + 16, d->destination);
    store_be16(p + 10, checksum(sum_words(p, IPV4_BYTES)));
}

/* Behind the IPv4 header, whose addresses are in the sum. */
static void put_udp(uint8_t *p, const lum_datagram *d)
{
    const uint32_t len = (uint32_t)(UDP_BYTES + d->len);
    store_be16(p, d->source_port);
    store_be16(p + 2, d->destination_port);
    store_be16(p + 4, len);
    store_be16(p + 6, 0);
    if (d->len != 0) {
        memcpy(p + UDP_BYTES, d->payload, d->len);
    }
    const uint32_t sum = sum_words(p - 8, 8) + PROTOCOL_UDP + len;
    const uint16_t sent =
        checksum((sum & 0xffffu) + (sum >> 16) + sum_words(p, len));
    store_be16(p + 6, sent == 0 ? 0xffffu : sent);
}

static int failed(const lum_capture_writer *w, lum_error *error)
{
    const int reason = errno;
    (void)lum_error_set(
        error, "%s: cannot be written: %s%s", w->name, strerror(reason),
        reason == ENOSPC ? "; free some space or write elsewhere" : "");
    errno = reason;
    return -1;
}

static void release(lum_capture_writer *w)
{
    if (w->dumper != NULL) {
        pcap_dump_close(w->dumper);
    } else if (w->file != NULL) {
        (void)fclose(w->file);
    }
    if (w->pcap != NULL) {
        pcap_close(w->pcap);
    }
    if (w->second_fd >= 0) {
        (void)close(w->second_fd);
    }
    free(w->buffer);
    free(w->name);
    free(w);
}

/* Truncating a file costs several times what unlinking it does; a device, a
 * pipe or a link is written to as it is. */
static int open_fd(const char *path)
{
    struct stat st;
    if (strcmp(path, "-") == 0) {
        return fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    }
    if (lstat(path, &st) == 0 && S_ISREG(st.st_mode) &&
        access(path, W_OK) == 0) {
        (void)unlink(path);
    }
    return open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

static int open_file(lum_capture_writer *w, const char *path)
{
    w->second_fd = open_fd(path);
    if (w->second_fd < 0) {
        return -1;
    }
    const int fd = fcntl(w->second_fd, F_DUPFD_CLOEXEC, 0);
    if (fd < 0) {
        return -1;
    }
    w->file = fdopen(fd, "wb");
    if (w->file == NULL) {
        (void)close(fd);
        return -1;
    }
    return setvbuf(w->file, w->buffer, _IOFBF, BUFFER_BYTES) == 0 ? 0 : -1;
}

static int begin(lum_capture_writer *w, const char *path, lum_error *error)
{
    if (open_file(w, path) != 0) {
        return failed(w, error);
    }
    w->pcap = pcap_open_dead_with_tstamp_precision(DLT_EN10MB, SNAP_BYTES,
                                                   PCAP_TSTAMP_PRECISION_NANO);
    if (w->pcap == NULL) {
        return lum_error_set(error, "%s: not enough memory to write it",
                             w->name);
    }
    w->dumper = pcap_dump_fopen(w->pcap, w->file);
    if (w->dumper == NULL) {
        w->file = NULL; /* libpcap has closed it */
        return lum_error_set(error, "%s: cannot be written: %s", w->name,
                             pcap_geterr(w->pcap));
    }
    w->bytes = FILE_HEADER_BYTES;
    return 0;
}

int lum_capture_writer_open(const char *path, lum_capture_writer **out,
                            lum_error *error)
{
    const char *name = strcmp(path, "-") == 0 ? "standard output" : path;
    lum_capture_writer *w = calloc(1, sizeof *w);
    if (w == NULL) {
        return lum_error_set(error, "%s: not enough memory to write it", name);
    }
    w->second_fd = -1;
    w->name = strdup(name);
    w->buffer = malloc(BUFFER_BYTES);
    int result = -1;
    if (w->name == NULL || w->buffer == NULL) {
        (void)lum_error_set(error, "%s: not enough memory to write it", name);
    } else {
        result = begin(w, path, error);
    }
    if (result != 0) {
        release(w);
        return -1;
    }
    *out = w;
    return 0;
}

static int check_datagram(const lum_capture_writer *w, const lum_datagram *d,
                          lum_error *error)
{
    if (d->len > PAYLOAD_BYTES_MAX) {
        return lum_error_set(
            error, "%s: a datagram of %zu bytes; at most %d can be written",
            w->name, d->len, (int)PAYLOAD_BYTES_MAX);
    }
    if (d->time_ns < 0 || d->time_ns / 1000000000 > UINT32_MAX) {
        return lum_error_set(error,
                             "%s: a capture time of %lld s since 1970; from 0 "
                             "to 4294967295 can be written",
                             w->name, (long long)(d->time_ns / 1000000000));
    }
    return 0;
}

int lum_capture_writer_add(lum_capture_writer *writer,
                           const lum_datagram *datagram, lum_error *error)
{
    struct pcap_pkthdr h;
    if (check_datagram(writer, datagram, error) != 0) {
        return -1;
    }
    put_ethernet(writer->frame, datagram);
    put_ipv4(writer->frame + ETHERNET_BYTES, datagram);
    put_udp(writer->frame + ETHERNET_BYTES + IPV4_BYTES, datagram);
    memset(&h, 0, sizeof h);
    h.ts.tv_sec = (time_t)(datagram->time_ns / 1000000000);
    h.ts.tv_usec = (suseconds_t)(datagram->time_ns % 1000000000);
    h.caplen = (bpf_u_int32)(HEADER_BYTES + datagram->len);
    h.len = h.caplen;
    pcap_dump((u_char *)writer->dumper, &h, writer->frame);
    writer->bytes += RECORD_HEADER_BYTES + h.caplen;
    return ferror(writer->file) ? failed(writer, error) : 0;
}

uint64_t lum_capture_writer_bytes(const lum_capture_writer *writer)
{
    return writer->bytes;
}

/* Whether nobody will read what is written; a pipe tells that without a write.
 */
static bool has_no_reader(const lum_capture_writer *writer)
{
    struct pollfd look = {.fd = writer->second_fd};
    return poll(&look, 1, 0) > 0 && (look.revents & POLLERR) != 0;
}

int lum_capture_writer_flush(lum_capture_writer *writer, lum_error *error)
{
    if (has_no_reader(writer)) {
        errno = EPIPE;
        return failed(writer, error);
    }
    return pcap_dump_flush(writer->dumper) == 0 ? 0 : failed(writer, error);
}

/* Closing the second descriptor tells what a file system reports only then;
 * pcap_dump_close() would not. */
int lum_capture_writer_close(lum_capture_writer *writer, lum_error *error)
{
    if (writer == NULL) {
        return 0;
    }
    int result = 0;
    if (ferror(writer->file) || pcap_dump_flush(writer->dumper) != 0) {
        result = failed(writer, error);
    } else if (close(writer->second_fd) != 0) {
        result = failed(writer, error);
        writer->second_fd = -1;
    } else {
        writer->second_fd = -1;
    }
    const int reason = errno;
    release(writer);
    errno = reason;
    return result;
}
