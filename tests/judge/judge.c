#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE /* the types that pcap.h needs */

#include "judge.h"

#include "capture/byte_order.h"
#include "capture/pcap.h"

#include <pcap/pcap.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum {
    SECTION = 0x0a0d0d0a,
    INTERFACE = 1
};

#define LIMIT_NS (LUM_PCAP_SECONDS_MAX * 1000000000)

struct both {
    pcap_t *theirs;
    lum_pcap *ours;
    bool is_pcapng;
    uint64_t records;
};

static bool is_any_of(uint32_t value, const uint32_t *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (values[i] == value) {
            return true;
        }
    }
    return false;
}

static bool has_other_limit(uint32_t link_type)
{
    static const uint32_t types[] = {231, 249, 279};
    return is_any_of(link_type, types, sizeof types / sizeof types[0]);
}

/* Whose headers libpcap turns, or whose lengths it mends. */
static bool is_mended(uint32_t link_type)
{
    static const uint32_t types[] = {113, 117, 189, 220, 239};
    return is_any_of(link_type, types, sizeof types / sizeof types[0]);
}

/* libpcap names some link types by the host's numbers. */
static bool is_same_link(uint32_t link_type, int theirs)
{
    static const struct {
        uint32_t link_type;
        int host;
    } renamed[] = {
        {100, DLT_ATM_RFC1483}, {101, DLT_RAW},      {102, DLT_SLIP_BSDOS},
        {103, DLT_PPP_BSDOS},   {106, DLT_ATM_CLIP}, {246, DLT_PFSYNC},
    };
    for (size_t i = 0; i < sizeof renamed / sizeof renamed[0]; i++) {
        if (renamed[i].link_type == link_type) {
            return renamed[i].host == theirs || (int)link_type == theirs;
        }
    }
    return (int)link_type == theirs;
}

/* Where libpcap reads a file's unsigned numbers as signed ones. */
static bool is_same_pcap_time(int64_t ns, const struct timeval *t)
{
    const int64_t s = (uint32_t)t->tv_sec;
    const int64_t wrap = INT64_C(1) << 32;
    const int64_t fraction = t->tv_usec;
    return ns == s * 1000000000 + fraction ||
           (fraction < 0 && (ns == s * 1000000000 + fraction + wrap ||
                             ns == s * 1000000000 + fraction + wrap * 1000));
}

static bool is_same_pcapng_time(int64_t ns, const struct timeval *t,
                                const lum_pcap_interface *interface)
{
    const int64_t s = t->tv_sec;
    if (ns >= LIMIT_NS || ns <= -LIMIT_NS) {
        return s >= LUM_PCAP_SECONDS_MAX || s <= -LUM_PCAP_SECONDS_MAX ||
               interface->offset_s != 0 || interface->ticks == 1;
    }
    if (s > LUM_PCAP_SECONDS_MAX || s < -LUM_PCAP_SECONDS_MAX) {
        return false;
    }
    const bool overflows = interface->ticks > UINT64_MAX / 1000000000 &&
                           interface->ticks % 1000000000 != 0;
    return overflows ? ns / 1000000000 - (ns % 1000000000 < 0) == s
                     : ns == s * 1000000000 + t->tv_usec;
}

static bool is_same_time(const struct both *b, const lum_pcap_record *r,
                         const struct timeval *t)
{
    if (sizeof t->tv_sec < sizeof(int64_t)) {
        return true; /* it cuts times to the host's */
    }
    return b->is_pcapng ? is_same_pcapng_time(
                              r->time_ns, t, &b->ours->interfaces[r->interface])
                        : is_same_pcap_time(r->time_ns, t);
}

/* libpcap holds a record to the file's snap length. */
static bool is_same_len(const struct both *b, const lum_pcap_record *r,
                        uint32_t theirs)
{
    return r->len == theirs ||
           (r->len > theirs && theirs == (uint32_t)pcap_snapshot(b->theirs));
}

static const char *difference(const struct both *b, const lum_pcap_record *r,
                              const struct pcap_pkthdr *h, const uint8_t *bytes)
{
    const bool is_turned =
        is_mended(r->link_type) && pcap_is_swapped(b->theirs);
    if (!is_same_link(r->link_type, pcap_datalink(b->theirs))) {
        return "the link type";
    }
    if (!is_same_time(b, r, &h->ts)) {
        return "the time";
    }
    if (!is_same_len(b, r, h->caplen)) {
        return "the bytes held";
    }
    if (r->whole != h->len && !is_mended(r->link_type)) {
        return "the bytes there were";
    }
    return is_turned || h->caplen == 0 ||
                   memcmp(r->bytes, bytes, h->caplen) == 0
               ? NULL
               : "the bytes";
}

/* Where ours may end and libpcap not. */
static bool may_end(const struct both *b, const struct pcap_pkthdr *h)
{
    const bool is_zeros = !b->is_pcapng && h->caplen == 0 && h->len == 0 &&
                          h->ts.tv_sec == 0 && h->ts.tv_usec == 0;
    return is_zeros || (h->caplen > LUM_PCAP_BYTES_MAX &&
                        has_other_limit((uint32_t)pcap_datalink(b->theirs)));
}

static int tell(const struct both *b, const char *what, const char *why,
                lum_error *error)
{
    return lum_error_set(error, "behind record %llu: %s%s%s",
                         (unsigned long long)b->records, what,
                         why != NULL ? ": " : "", why != NULL ? why : "");
}

/* Returns 1 with a record of both; 0 where the comparison ends; -1 where they
 * differ. */
static int step(struct both *b, judge_result *out, lum_error *error)
{
    struct pcap_pkthdr *h = NULL;
    const uint8_t *bytes = NULL;
    lum_pcap_record r;
    lum_error why = {""};
    const int theirs = pcap_next_ex(b->theirs, &h, &bytes);
    if (theirs == PCAP_ERROR) {
        return 0;
    }
    const int ours = lum_pcap_next(b->ours, &r, &why);
    if (theirs == PCAP_ERROR_BREAK) {
        out->ended = 1;
        return ours == 0 ? 0
                         : tell(b, "libpcap is at the end, and ours not",
                                why.text, error);
    }
    if (ours != 1) {
        return may_end(b, h)
                   ? 0
                   : tell(b, "libpcap reads on, and ours not", why.text, error);
    }
    const char *differs = difference(b, &r, h, bytes);
    if (differs != NULL) {
        return tell(b, "the readers differ in", differs, error);
    }
    b->records++;
    return 1;
}

static uint32_t load(bool is_big, const uint8_t *p)
{
    return is_big ? load_big_u32(p) : load_u32(p);
}

/* Whether libpcap ignores some of the blocks before the first interface. */
static bool is_odd_start(const struct both *b, const uint8_t *bytes, size_t len)
{
    const bool is_big = bytes[8] == 0x1a;
    size_t size = load(is_big, bytes + 4);
    if (!b->is_pcapng) {
        return false;
    }
    if (size % 4u != 0 || size > len ||
        memcmp(bytes + 4, bytes + size - 4u, 4) != 0) {
        return true;
    }
    for (size_t at = size; len - at >= 12; at += size) {
        const uint32_t type = load(is_big, bytes + at);
        size = load(is_big, bytes + at + 4);
        if (type == INTERFACE || size > len - at) {
            return false;
        }
        if (type == SECTION) {
            return true;
        }
    }
    return false;
}

static int compare(struct both *b, const uint8_t *bytes, size_t len,
                   judge_result *out, lum_error *error)
{
    uint32_t link_type = 0;
    lum_error why = {""};
    if (is_odd_start(b, bytes, len)) {
        return 0;
    }
    if (lum_pcap_begin(b->ours, NULL, &link_type, &why) != 1) {
        return tell(b, "libpcap reads it, and ours not", why.text, error);
    }
    int result = 0;
    while ((result = step(b, out, error)) == 1) {
    }
    out->records = b->records;
    return result;
}

static pcap_t *open_theirs(const uint8_t *bytes, size_t len)
{
    char why[PCAP_ERRBUF_SIZE];
    FILE *file = fmemopen((void *)(uintptr_t)bytes, len, "rb");
    if (file == NULL) {
        return NULL;
    }
    pcap_t *theirs = pcap_fopen_offline_with_tstamp_precision(
        file, PCAP_TSTAMP_PRECISION_NANO, why);
    if (theirs == NULL) {
        (void)fclose(file);
    }
    return theirs;
}

int judge_compare(const uint8_t *bytes, size_t len, judge_result *out,
                  lum_error *error)
{
    struct both b = {0};
    int result = 0;
    memset(out, 0, sizeof *out);
    if (len < 24) {
        return 0;
    }
    b.theirs = open_theirs(bytes, len);
    if (b.theirs == NULL) {
        return 0;
    }
    out->opened = 1;
    lum_source *source = lum_source_from_memory("capture", bytes, len);
    if (source != NULL) {
        b.ours = lum_pcap_new(source);
        b.is_pcapng = bytes[0] == 0x0a;
        result = b.ours != NULL ? compare(&b, bytes, len, out, error)
                                : lum_error_set(error, "no memory");
    }
    lum_pcap_free(b.ours);
    lum_source_close(source);
    pcap_close(b.theirs);
    return result;
}
