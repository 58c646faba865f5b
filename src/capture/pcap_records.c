/* Packets of a pcap file. */
#include "pcap.h"

enum {
    FILE_HEADER_BYTES = 24,
    RECORD_HEADER_BYTES = 16,
    KUZNETZOV_HEADER_BYTES = 24,
    LINK_TYPE_MASK = 0x03ffffff, /* above are the bytes of a checksum */
    VERSION = 2,
    VERSION_MINOR_MAX = 4,
    VERSION_DG_UX = 543
};

/* Of a record's two lengths. */
enum length_order {
    HELD_FIRST,
    WHOLE_FIRST,
    SMALLER_IS_HELD /* version 2.3: programs differ */
};

static void swap_lengths(lum_pcap_record *out)
{
    const uint32_t len = out->len;
    out->len = out->whole;
    out->whole = len;
}

static bool is_swapped(const lum_pcap *r, const lum_pcap_record *out)
{
    return r->lengths == WHOLE_FIRST ||
           (r->lengths == SMALLER_IS_HELD && out->len > out->whole);
}

/* A file that was not written to its end may have such records. */
static bool is_zeros(const lum_pcap_record *record)
{
    return record->time_ns == 0 && record->len == 0 && record->whole == 0;
}

/* The fields of a record's header; its bytes follow. */
static void read_header(const lum_pcap *r, const uint8_t *p,
                        lum_pcap_record *out)
{
    out->time_ns = (int64_t)file_u32(r, p) * 1000000000 +
                   (int64_t)file_u32(r, p + 4) * r->scale;
    out->len = file_u32(r, p + 8);
    out->whole = file_u32(r, p + 12);
    if (is_swapped(r, out)) {
        swap_lengths(out);
    }
    out->link_type = r->interfaces[0].link_type;
    out->interface = 0;
    out->name = NULL;
}

static int next_record(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (!lum_source_has(s, r->header)) {
        return s->left == 0 && !s->has_failed
                   ? 0
                   : lum_pcap_fail_cut(r, "record", 0, error);
    }
    read_header(r, s->at, out);
    if (out->len > LUM_PCAP_BYTES_MAX) {
        return lum_pcap_fail(r, error,
                             "a record of %lu bytes; at most %u are possible",
                             (unsigned long)out->len, LUM_PCAP_BYTES_MAX);
    }
    if (is_zeros(out)) {
        return lum_pcap_fail(r, error, "zeros instead of a record");
    }
    const size_t all = r->header + out->len;
    if (!lum_source_has(s, all)) {
        return lum_pcap_fail_cut(r, "record", all, error);
    }
    out->bytes = s->at + r->header;
    lum_source_take(s, all);
    return 1;
}

/* Whether it is the magic of a pcap file; sets the properties that it
 * implies. */
static bool read_magic(lum_pcap *r, const uint8_t *p)
{
    static const struct {
        uint32_t magic;
        uint32_t scale;
        uint32_t header;
    } kinds[] = {
        {0xa1b2c3d4, 1000, RECORD_HEADER_BYTES},
        {0xa1b23c4d, 1, RECORD_HEADER_BYTES},
        {0xa1b2cd34, 1000, KUZNETZOV_HEADER_BYTES},
    };
    for (size_t i = 0; i < 2u * (sizeof kinds / sizeof kinds[0]); i++) {
        r->is_big = i % 2u != 0;
        if (file_u32(r, p) == kinds[i / 2u].magic) {
            r->scale = kinds[i / 2u].scale;
            r->header = kinds[i / 2u].header;
            return true;
        }
    }
    return false;
}

static int read_version(lum_pcap *r, const uint8_t *p, lum_error *error)
{
    const unsigned version = file_u16(r, p);
    const unsigned minor = file_u16(r, p + 2);
    if ((version != VERSION || minor > VERSION_MINOR_MAX) &&
        (version != VERSION_DG_UX || minor != 0)) {
        return lum_error_set(
            error, "a pcap file of version %u.%u; 2.0 to 2.4 can be read",
            version, minor);
    }
    r->lengths = HELD_FIRST;
    if (version == VERSION_DG_UX || minor < 3) {
        r->lengths = WHOLE_FIRST;
    } else if (minor == 3) {
        r->lengths = SMALLER_IS_HELD;
    }
    return 0;
}

int lum_pcap_records_begin(lum_pcap *reader, lum_error *error)
{
    lum_pcap *r = reader;
    lum_source *s = r->source;
    const bool is_whole = lum_source_has(s, FILE_HEADER_BYTES);
    if (s->left < 4 || !read_magic(r, s->at)) {
        return s->has_failed
                   ? lum_error_set(error, "%s", s->error.text)
                   : lum_error_set(error, "it does not begin like one");
    }
    if (!is_whole) {
        return lum_pcap_fail_cut(r, "file header", FILE_HEADER_BYTES, error);
    }
    /* the snap length is not read: programs state one below their records */
    const lum_pcap_interface interface = {.link_type = file_u32(r, s->at + 20) &
                                                       LINK_TYPE_MASK};
    if (read_version(r, s->at + 4, error) != 0 ||
        lum_pcap_add_interface(r, &interface, error) != 0) {
        return -1;
    }
    lum_source_take(s, FILE_HEADER_BYTES);
    r->next = next_record;
    return 0;
}
