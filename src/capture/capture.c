#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE /* the types that pcap.h needs */

#include "capture_internal.h"
#include "fragments.h"

#include <errno.h>
#include <fcntl.h>
#include <pcap/pcap.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Fits the second-level caches, so that libpcap's copy out of it is cheap. */
#define BUFFER_BYTES (256u * 1024u)

/* The kernel copies to a page's start several times as fast as to 16 bytes
 * behind it, where malloc() begins. */
#define BUFFER_ALIGN 4096u

#define FILE_HEADER_BYTES   24u
#define RECORD_HEADER_BYTES 16u

struct lum_capture {
    pcap_t *pcap;
    FILE *file;
    char *buffer;   /* of file, which pcap closes */
    int fd;         /* of file; -1 if it has none */
    uint64_t total; /* bytes of a regular file, else 0 */
    char *name;
    lum_link_reader *link;
    lum_fragments *fragments;
    uint64_t records;
    uint64_t bytes;
    bool ended;
};

static uint64_t regular_bytes(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 && S_ISREG(st.st_mode) ? (uint64_t)st.st_size
                                                      : 0;
}

/* Names what is no capture but often taken for one. */
static const char *hint(int fd)
{
    static const struct {
        uint8_t magic[4];
        uint8_t len;
        const char *text;
    } known[] = {
        {{0x1f, 0x8b, 0, 0}, 2, "; it is compressed: use gzip -dc"},
        {{0x28, 0xb5, 0x2f, 0xfd}, 4, "; it is compressed: use zstd -dc"},
        {{0xfd, '7', 'z', 'X'}, 4, "; it is compressed: use xz -dc"},
        {{'B', 'Z', 'h', 0}, 3, "; it is compressed: use bzip2 -dc"},
        {{'P', 'K', 3, 4}, 4, "; it is a zip archive: use unzip"},
    };
    uint8_t start[4];
    if (pread(fd, start, sizeof start, 0) != sizeof start) {
        return "";
    }
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (memcmp(start, known[i].magic, known[i].len) == 0) {
            return known[i].text;
        }
    }
    return "";
}

/* Whether there is a first byte; a directory gives its error here. */
static int check_start(FILE *file, const char *name, lum_error *error)
{
    const int first = getc(file);
    if (first != EOF) {
        (void)ungetc(first, file);
        return 0;
    }
    if (!ferror(file)) {
        return lum_error_set(
            error, "%s: is empty; a pcap or pcapng file is expected", name);
    }
    return lum_error_set(
        error, "%s: cannot be read: %s; a pcap or pcapng file is expected",
        name, strerror(errno));
}

static int open_pcap(lum_capture *c, lum_error *error)
{
    char reason[PCAP_ERRBUF_SIZE] = "";
    if (check_start(c->file, c->name, error) != 0) {
        return -1;
    }
    c->pcap = pcap_fopen_offline_with_tstamp_precision(
        c->file, PCAP_TSTAMP_PRECISION_NANO, reason);
    if (c->pcap == NULL) {
        return lum_error_set(
            error,
            "%s: not a capture (%s); a pcap or pcapng file is expected%s",
            c->name, reason, hint(c->fd));
    }
    const int link_type = pcap_datalink(c->pcap);
    c->link = lum_link_find(link_type);
    if (c->link == NULL) {
        const char *type = pcap_datalink_val_to_name(link_type);
        return lum_error_set(
            error, "%s: link type %d (%s) is not supported; supported are %s",
            c->name, link_type, type != NULL ? type : "unknown",
            lum_link_supported());
    }
    return 0;
}

static int set_buffer(lum_capture *c)
{
    void *buffer = NULL;
    if (posix_memalign(&buffer, BUFFER_ALIGN, BUFFER_BYTES) != 0) {
        return -1;
    }
    c->buffer = buffer;
    return setvbuf(c->file, c->buffer, _IOFBF, BUFFER_BYTES) == 0 ? 0 : -1;
}

/* All that needs memory. */
static int prepare(lum_capture *c, const char *name)
{
    c->name = strdup(name);
    c->fragments = lum_fragments_new();
    if (c->name == NULL || c->fragments == NULL) {
        return -1;
    }
    return set_buffer(c);
}

int lum_capture_open_stream(FILE *file, const char *name, lum_capture **out,
                            lum_error *error)
{
    lum_capture *c = calloc(1, sizeof *c);
    if (c == NULL) {
        (void)fclose(file);
        return lum_error_set(error, "%s: not enough memory to read it", name);
    }
    c->file = file;
    c->fd = fileno(file);
    c->total = regular_bytes(c->fd);
    c->bytes = FILE_HEADER_BYTES;
    int result = prepare(c, name);
    if (result != 0) {
        (void)lum_error_set(error, "%s: not enough memory to read it", name);
    } else {
        result = open_pcap(c, error);
    }
    if (result != 0) {
        lum_capture_close(c);
        return -1;
    }
    *out = c;
    return 0;
}

/* Standard input is read through a descriptor of its own, so that closing it
 * harms nobody. */
static int open_descriptor(const char *path)
{
    return strcmp(path, "-") == 0 ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                  : open(path, O_RDONLY | O_CLOEXEC);
}

int lum_capture_open(const char *path, lum_capture **out, lum_error *error)
{
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    const int fd = open_descriptor(path);
    FILE *file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (file == NULL) {
        (void)lum_error_set(
            error,
            "%s: cannot be opened: %s; a pcap or pcapng file is expected", name,
            strerror(errno));
        if (fd >= 0) {
            (void)close(fd);
        }
        return -1;
    }
    return lum_capture_open_stream(file, name, out, error);
}

/* libpcap may take a file's unsigned seconds for signed ones. A time that no
 * clock shows is held at the limit, so that no two differ by an overflow. */
static int64_t time_of(const struct timeval *t)
{
    const int64_t limit_s = 4500000000;
    const int64_t limit_ns = 5000000000000;
    int64_t s = (int64_t)t->tv_sec;
    int64_t ns = (int64_t)t->tv_usec; /* nanoseconds, as asked for */
    s += s < 0 && s >= INT32_MIN ? INT64_C(1) << 32 : 0;
    s = s > limit_s ? limit_s : s;
    s = s < -limit_s ? -limit_s : s;
    ns = ns < 0 || ns > limit_ns ? 0 : ns;
    return s * 1000000000 + ns;
}

/* What a file holds that was not written to its end. */
static bool is_zeros(const struct pcap_pkthdr *h)
{
    return h->caplen == 0 && h->len == 0 && h->ts.tv_sec == 0 &&
           h->ts.tv_usec == 0;
}

static int end(lum_capture *c, const char *reason, lum_record *out,
               lum_error *error)
{
    c->ended = true;
    out->dropped_fragments = lum_fragments_drop_all(c->fragments);
    if (reason == NULL) {
        return 0;
    }
    return lum_error_set(error, "%s: cannot be read on after record %llu: %s",
                         c->name, (unsigned long long)c->records, reason);
}

static void read_record(lum_capture *c, lum_span frame, lum_record *out)
{
    lum_span packet;
    lum_fragment fragment;
    out->kind = LUM_RECORD_OTHER;
    if (c->link(frame, &packet)) {
        lum_ipv4_read(packet, out, &fragment);
        if (out->kind == LUM_RECORD_FRAGMENT) {
            lum_fragments_add(c->fragments, &fragment, out);
        }
    }
}

int lum_capture_next(lum_capture *capture, lum_record *out, lum_error *error)
{
    struct pcap_pkthdr *h = NULL;
    const uint8_t *bytes = NULL;
    memset(out, 0, sizeof *out);
    out->kind = LUM_RECORD_OTHER;
    if (capture->ended) {
        return 0;
    }
    const int got = pcap_next_ex(capture->pcap, &h, &bytes);
    if (got != 1) {
        return end(capture,
                   got == PCAP_ERROR_BREAK ? NULL : pcap_geterr(capture->pcap),
                   out, error);
    }
    if (is_zeros(h)) {
        return end(capture, "zeros stand where a record should", out, error);
    }
    capture->records++;
    capture->bytes += RECORD_HEADER_BYTES + h->caplen;
    out->time_ns = time_of(&h->ts);
    out->dropped_fragments =
        lum_fragments_expire(capture->fragments, out->time_ns);
    read_record(capture, (lum_span){bytes, h->caplen}, out);
    return 1;
}

void lum_capture_progress(const lum_capture *capture, uint64_t *done,
                          uint64_t *total)
{
    *done = capture->bytes;
    *total = capture->total;
}

void lum_capture_close(lum_capture *capture)
{
    if (capture == NULL) {
        return;
    }
    if (capture->pcap != NULL) {
        pcap_close(capture->pcap);
    } else {
        (void)fclose(capture->file);
    }
    lum_fragments_free(capture->fragments);
    free(capture->buffer);
    free(capture->name);
    free(capture);
}
