#include "fragments.h"

#include "byte_order.h"

#include <stdlib.h>
#include <string.h>

/* --- Headers --- */

enum {
    PROTOCOL_UDP = 17,
    MORE_FRAGMENTS = 0x2000,
    OFFSET_MASK = 0x1fff
};

/* The fields of a header that is held whole but for its options. */
typedef struct header {
    size_t len;
    size_t total;
    unsigned fragment; /* flags and offset */
    uint16_t id;
} header;

static bool read_header(lum_span packet, header *out)
{
    const uint8_t *p = packet.at;
    if (packet.len < IPV4_BYTES || p[0] >> 4 != 4 || p[9] != PROTOCOL_UDP) {
        return false;
    }
    out->len = (size_t)(p[0] & 0x0fu) * 4u;
    out->total = load_big_u16(p + 2);
    out->id = load_big_u16(p + 4);
    out->fragment = load_big_u16(p + 6);
    return out->len >= IPV4_BYTES && out->total >= out->len;
}

static lum_span payload_of(lum_span packet, const header *ip)
{
    const size_t held = packet.len < ip->total ? packet.len : ip->total;
    if (held < ip->len) {
        return (lum_span){packet.at, 0};
    }
    return (lum_span){packet.at + ip->len, held - ip->len};
}

/* Of a datagram whose fragments are cut, the first one stands for it. */
static void read_fragment(lum_span data, const header *ip, lum_record *out,
                          lum_fragment *fragment)
{
    const size_t whole = ip->total - ip->len;
    const bool more = (ip->fragment & MORE_FRAGMENTS) != 0;
    const uint32_t offset = (ip->fragment & OFFSET_MASK) * 8u;
    out->kind = LUM_RECORD_OTHER;
    if (whole == 0 || (more && whole % 8u != 0) ||
        ip->len + offset + whole > LUM_IPV4_BYTES_MAX) {
        return;
    }
    if (data.len < whole) {
        if (offset == 0) {
            lum_udp_read(data, LUM_IPV4_BYTES_MAX, out);
        }
        return;
    }
    *fragment = (lum_fragment){data, offset, ip->id, more};
    out->kind = LUM_RECORD_FRAGMENT;
}

void lum_udp_read(lum_span udp, size_t whole, lum_record *out)
{
    const bool has_ports = udp.len >= 4;
    const bool has_length = udp.len >= 6;
    out->source_port = has_ports ? load_big_u16(udp.at) : 0;
    out->destination_port = has_ports ? load_big_u16(udp.at + 2) : 0;
    const size_t len = has_length ? load_big_u16(udp.at + 4) : UDP_BYTES;
    if (len < UDP_BYTES || len > whole) {
        out->kind = LUM_RECORD_OTHER;
    } else if (udp.len < whole) {
        out->kind = LUM_RECORD_CUT_SHORT;
    } else {
        out->payload = udp.at + UDP_BYTES;
        out->len = len - UDP_BYTES;
        out->kind = LUM_RECORD_DATAGRAM;
    }
}

void lum_ipv4_read(lum_span packet, lum_record *out, lum_fragment *fragment)
{
    header ip;
    if (!read_header(packet, &ip)) {
        out->kind = LUM_RECORD_OTHER;
        return;
    }
    out->source = load_big_u32(packet.at + 12);
    out->destination = load_big_u32(packet.at + 16);
    const lum_span data = payload_of(packet, &ip);
    if ((ip.fragment & (MORE_FRAGMENTS | OFFSET_MASK)) != 0) {
        read_fragment(data, &ip, out, fragment);
    } else {
        lum_udp_read(data, ip.total - ip.len, out);
    }
}

/* --- Reassembly --- */

enum {
    UNIT = 8, /* offsets count units of so many bytes */
    UNITS = 65536 / UNIT,
    DATAGRAMS = LUM_FRAGMENTS_DATAGRAMS,
    NOWHERE = DATAGRAMS
};

typedef struct datagram {
    int64_t first_ns;
    uint32_t source;
    uint32_t destination;
    uint32_t fragments;
    uint32_t held;  /* bytes */
    uint32_t reach; /* end of the fragment that reaches farthest */
    uint32_t total; /* 0: the last fragment has not come */
    uint16_t id;
    uint8_t has[UNITS / 8]; /* a bit for each unit */
    uint8_t bytes[UNITS * UNIT];
} datagram;

struct lum_fragments {
    size_t waiting;
    size_t complete;                /* handed out, and still known */
    uint8_t order[DATAGRAMS];       /* the waiting ones as they came, then the
                                       complete ones likewise, then the free */
    datagram *datagrams[DATAGRAMS]; /* made at their first use, then kept */
};

lum_fragments *lum_fragments_new(void)
{
    lum_fragments *f = calloc(1, sizeof *f);
    for (size_t i = 0; f != NULL && i < DATAGRAMS; i++) {
        f->order[i] = (uint8_t)i;
    }
    return f;
}

void lum_fragments_free(lum_fragments *fragments)
{
    for (size_t i = 0; fragments != NULL && i < DATAGRAMS; i++) {
        free(fragments->datagrams[i]);
    }
    free(fragments);
}

static datagram *at_place(lum_fragments *f, size_t place)
{
    return f->datagrams[f->order[place]];
}

/* Up to a place behind it. */
static void move_up(lum_fragments *f, size_t place, size_t to)
{
    const uint8_t moved = f->order[place];
    memmove(&f->order[place], &f->order[place + 1u], to - place);
    f->order[to] = moved;
}

static uint32_t release(lum_fragments *f, size_t place)
{
    const uint32_t fragments = at_place(f, place)->fragments;
    f->waiting--;
    move_up(f, place, f->waiting + f->complete);
    return fragments;
}

/* Its bytes stay, to know what repeats them. */
static void finish(lum_fragments *f, size_t place)
{
    move_up(f, place, f->waiting + f->complete - 1u);
    f->waiting--;
    f->complete++;
}

static bool is_of(const datagram *d, const lum_record *record, uint16_t id)
{
    return d->id == id && d->source == record->source &&
           d->destination == record->destination;
}

static size_t find(lum_fragments *f, const lum_record *record, uint16_t id)
{
    size_t place = 0;
    while (place < f->waiting && !is_of(at_place(f, place), record, id)) {
        place++;
    }
    return place;
}

/* The place behind the waiting ones becomes free, and has memory. */
static datagram *vacant(lum_fragments *f)
{
    const size_t used = f->waiting + f->complete;
    if (used == DATAGRAMS) {
        f->complete--; /* the oldest of them */
    } else {
        const uint8_t free_one = f->order[used];
        memmove(&f->order[f->waiting + 1u], &f->order[f->waiting], f->complete);
        f->order[f->waiting] = free_one;
    }
    datagram **d = &f->datagrams[f->order[f->waiting]];
    if (*d == NULL) {
        *d = malloc(sizeof **d);
        f->complete = *d != NULL ? f->complete : 0;
    }
    return *d;
}

static size_t begin(lum_fragments *f, lum_record *record, uint16_t id)
{
    if (f->waiting == DATAGRAMS) {
        record->dropped_fragments += release(f, 0);
    }
    datagram *d = vacant(f);
    if (d == NULL) {
        return NOWHERE;
    }
    memset(d, 0, offsetof(datagram, bytes));
    d->first_ns = record->time_ns;
    d->source = record->source;
    d->destination = record->destination;
    d->id = id;
    return f->waiting++;
}

static bool has_unit(const datagram *d, uint32_t unit)
{
    return (d->has[unit / 8u] >> (unit % 8u) & 1u) != 0;
}

/* Whether all of a fragment is there already, and the same. */
static bool repeats(const datagram *d, const lum_fragment *fragment)
{
    const uint32_t end = fragment->offset + (uint32_t)fragment->data.len;
    const bool fits =
        fragment->more ? d->total == 0 || end < d->total : end == d->total;
    uint32_t unit = fragment->offset / UNIT;
    while (fits && unit * UNIT < end && has_unit(d, unit)) {
        unit++;
    }
    return fits && unit * UNIT >= end &&
           memcmp(d->bytes + fragment->offset, fragment->data.at,
                  fragment->data.len) == 0;
}

/* Whether it was part of a datagram that is complete. */
static bool is_known(lum_fragments *f, const lum_fragment *fragment,
                     const lum_record *record)
{
    for (size_t i = 0; i < f->complete; i++) {
        const datagram *d = at_place(f, f->waiting + i);
        if (is_of(d, record, fragment->id) &&
            record->time_ns - d->first_ns <= LUM_FRAGMENTS_WAIT_NS &&
            repeats(d, fragment)) {
            return true;
        }
    }
    return false;
}

static bool mark_units(datagram *d, uint32_t begin_unit, uint32_t end_unit)
{
    bool fresh = true;
    for (uint32_t u = begin_unit; u < end_unit; u++) {
        const uint8_t bit = (uint8_t)(1u << (u % 8u));
        fresh = fresh && (d->has[u / 8u] & bit) == 0;
        d->has[u / 8u] |= bit;
    }
    return fresh;
}

/* Whether the fragment fits to those that wait. */
static bool insert(datagram *d, const lum_fragment *fragment)
{
    const uint32_t len = (uint32_t)fragment->data.len;
    const uint32_t end = fragment->offset + len;
    if (!mark_units(d, fragment->offset / UNIT, (end + UNIT - 1u) / UNIT)) {
        return false;
    }
    d->reach = end > d->reach ? end : d->reach;
    if (!fragment->more) {
        if (d->total != 0) {
            return false;
        }
        d->total = end;
    }
    if (d->total != 0 && d->reach > d->total) {
        return false;
    }
    memcpy(d->bytes + fragment->offset, fragment->data.at, len);
    d->held += len;
    d->fragments++;
    return true;
}

static void add(lum_fragments *f, size_t place, const lum_fragment *fragment,
                lum_record *record)
{
    datagram *d = at_place(f, place);
    if (!insert(d, fragment)) {
        record->dropped_fragments += release(f, place);
        record->kind = LUM_RECORD_OTHER;
    } else if (d->held == d->total) {
        finish(f, place);
        lum_udp_read((lum_span){d->bytes, d->total}, d->total, record);
    } else {
        record->kind = LUM_RECORD_FRAGMENT;
    }
}

void lum_fragments_add(lum_fragments *fragments, const lum_fragment *fragment,
                       lum_record *record)
{
    lum_fragments *f = fragments;
    size_t place = find(f, record, fragment->id);
    const bool is_new = place == f->waiting;
    if (is_new ? is_known(f, fragment, record)
               : repeats(at_place(f, place), fragment)) {
        record->kind = LUM_RECORD_FRAGMENT;
        return;
    }
    place = is_new ? begin(f, record, fragment->id) : place;
    if (place == NOWHERE) {
        record->kind = LUM_RECORD_OTHER;
        return;
    }
    add(f, place, fragment, record);
}

/* --- What waits, kept --- */

static void pack_datagram(lum_pack *pack, datagram *d)
{
    lum_pack_i64(pack, &d->first_ns);
    lum_pack_u32(pack, &d->source);
    lum_pack_u32(pack, &d->destination);
    lum_pack_u16(pack, &d->id);
    lum_pack_u32(pack, &d->fragments);
    lum_pack_u32(pack, &d->held);
    lum_pack_u32(pack, &d->reach);
    lum_pack_u32(pack, &d->total);
    lum_pack_bytes(pack, d->has, sizeof d->has);
    (void)lum_pack_check(pack, d->held <= sizeof d->bytes &&
                                   d->reach <= sizeof d->bytes &&
                                   d->total <= sizeof d->bytes);
    for (uint32_t unit = 0; unit < UNITS && !pack->has_failed; unit++) {
        if (has_unit(d, unit)) {
            lum_pack_bytes(pack, d->bytes + (size_t)unit * UNIT, UNIT);
        }
    }
}

bool lum_fragments_pack(lum_fragments *fragments, lum_pack *pack)
{
    lum_fragments *f = fragments;
    uint32_t count = (uint32_t)f->waiting;
    lum_pack_u32(pack, &count);
    if (lum_pack_is_reading(pack)) {
        (void)lum_fragments_drop_all(f);
        f->complete = 0;
        (void)lum_pack_check(pack, count <= DATAGRAMS);
    }
    for (uint32_t i = 0; i < count && !pack->has_failed; i++) {
        datagram *d = lum_pack_is_reading(pack) ? vacant(f) : at_place(f, i);
        if (d == NULL) {
            pack->has_failed = true;
        } else if (lum_pack_is_reading(pack)) {
            memset(d, 0, sizeof *d);
            f->waiting++;
        }
        if (d != NULL) {
            pack_datagram(pack, d);
        }
    }
    if (pack->has_failed && lum_pack_is_reading(pack)) {
        (void)lum_fragments_drop_all(f);
    }
    return !pack->has_failed;
}

uint32_t lum_fragments_expire(lum_fragments *fragments, int64_t now_ns)
{
    uint32_t dropped = 0;
    for (size_t place = fragments->waiting; place-- > 0;) {
        if (now_ns - at_place(fragments, place)->first_ns >
            LUM_FRAGMENTS_WAIT_NS) {
            dropped += release(fragments, place);
        }
    }
    return dropped;
}

uint32_t lum_fragments_drop_all(lum_fragments *fragments)
{
    uint32_t dropped = 0;
    while (fragments->waiting > 0) {
        dropped += release(fragments, fragments->waiting - 1u);
    }
    return dropped;
}
