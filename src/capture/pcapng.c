/* Bytes of a pcapng file to packets: its blocks one after the other, and what
 * happens where one cannot be read. */
#include "pcapng_sections.h"

enum {
    HEADER_BYTES = 8,
    BLOCK_BYTES_MIN = HEADER_BYTES + LUM_PCAPNG_TRAILER_BYTES,
    SIMPLE_PACKET_BYTES_MIN = 16,
    PACKET_BYTES_MIN = 32,
    BYTE_ORDER = 0x1a2b3c4d
};

/* --- Blocks --- */

bool lum_pcapng_is(lum_source *source)
{
    return lum_source_has(source, 4) &&
           load_big_u32(source->at) == LUM_PCAPNG_SECTION;
}

/* The byte order of a section comes after its length. */
static int read_order(lum_pcap *r, lum_error *error)
{
    lum_source *s = r->source;
    if (!lum_source_has(s, HEADER_BYTES + 4)) {
        return lum_pcap_fail_cut(r, "section header", 0, error);
    }
    r->is_big = load_big_u32(s->at + HEADER_BYTES) == BYTE_ORDER;
    if (file_u32(r, s->at + HEADER_BYTES) != BYTE_ORDER) {
        return lum_pcap_fail(r, error, "a section without a valid byte order");
    }
    return 0;
}

static bool is_read(uint32_t type)
{
    return (type >= LUM_PCAPNG_INTERFACE && type <= LUM_PCAPNG_SIMPLE_PACKET) ||
           type == LUM_PCAPNG_ENHANCED_PACKET || type == LUM_PCAPNG_SECTION;
}

static bool is_packet(uint32_t type)
{
    return is_read(type) && type != LUM_PCAPNG_SECTION &&
           type != LUM_PCAPNG_INTERFACE;
}

/* Returns 1 with a block's type and length; 0 at the end. */
static int read_block_header(lum_pcap *r, lum_pcapng_block *b, lum_error *error)
{
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (!lum_source_has(s, HEADER_BYTES)) {
        if (s->left == 0 && !s->has_failed) {
            return 0;
        }
        (void)lum_pcap_fail_cut(r, "block", 0, error);
        return -1;
    }
    if (load_big_u32(s->at) == LUM_PCAPNG_SECTION &&
        read_order(r, error) != 0) {
        return -1;
    }
    b->type = file_u32(r, s->at);
    b->len = file_u32(r, s->at + 4);
    return b->len >= BLOCK_BYTES_MIN && b->len % 4u == 0
               ? 1
               : lum_pcap_fail(r, error,
                               "a block of %lu bytes; its length is a multiple "
                               "of 4, %d or more",
                               (unsigned long)b->len, (int)BLOCK_BYTES_MIN);
}

/* Both ends of a block say its length. */
static int check_trailer(const lum_pcap *r, uint32_t len,
                         const uint8_t *trailer, lum_error *error)
{
    const uint32_t again = file_u32(r, trailer);
    return again == len
               ? 0
               : lum_pcap_fail(r, error,
                               "a block of %lu bytes at its start has "
                               "%lu at its end",
                               (unsigned long)len, (unsigned long)again);
}

/* Of a type that is not known, of any length. */
static int skip_block(lum_pcap *r, const lum_pcapng_block *b, lum_error *error)
{
    lum_source *s = r->source;
    if (!lum_source_skip(s, b->len - LUM_PCAPNG_TRAILER_BYTES) ||
        !lum_source_has(s, LUM_PCAPNG_TRAILER_BYTES)) {
        return lum_pcap_fail_cut(r, "block", b->len, error);
    }
    if (check_trailer(r, b->len, s->at, error) != 0) {
        return -1;
    }
    lum_source_take(s, LUM_PCAPNG_TRAILER_BYTES);
    return 0;
}

/* Of a type that is read. */
static int skip_long_block(lum_pcap *r, const lum_pcapng_block *b,
                           lum_error *error)
{
    if (skip_block(r, b, error) != 0) {
        return LUM_PCAP_FAILED;
    }
    (void)lum_pcap_fail(r, error,
                        "a block of type %lu has %lu bytes; at most %u are "
                        "possible",
                        (unsigned long)b->type, (unsigned long)b->len,
                        LUM_PCAPNG_BLOCK_MAX);
    return LUM_PCAP_DAMAGED;
}

/* Returns LUM_PCAP_GO_ON with a block of a type that is read; LUM_PCAP_DAMAGED
 * with one that is too long, which is taken; LUM_PCAP_ENDED. */
static int next_block(lum_pcap *r, lum_pcapng_block *b, lum_error *error)
{
    lum_source *s = r->source;
    int result = 0;
    while ((result = read_block_header(r, b, error)) == 1 &&
           !is_read(b->type)) {
        if (skip_block(r, b, error) != 0) {
            return LUM_PCAP_FAILED;
        }
    }
    if (result != 1) {
        return result == 0 ? LUM_PCAP_ENDED : LUM_PCAP_FAILED;
    }
    if (b->len > LUM_PCAPNG_BLOCK_MAX) {
        return skip_long_block(r, b, error);
    }
    if (!lum_source_has(s, b->len)) {
        return lum_pcap_fail_cut(r, "block", b->len, error);
    }
    b->at = s->at;
    return check_trailer(r, b->len, b->at + b->len - LUM_PCAPNG_TRAILER_BYTES,
                         error) == 0
               ? LUM_PCAP_GO_ON
               : LUM_PCAP_FAILED;
}

/* --- Packets --- */

/* rest * 10^9 / ticks, where rest is less than ticks, without losing a
 * remainder: the product has up to 93 bits. */
static int64_t to_ns(uint64_t rest, uint64_t ticks)
{
    const uint64_t billion = 1000000000;
    if (ticks <= UINT64_MAX / billion) {
        return (int64_t)(rest * billion / ticks);
    }
    if (ticks % billion == 0) {
        return (int64_t)(rest / (ticks / billion));
    }
    /* a power of two, 2^35 or more */
    const uint64_t low = (rest & UINT32_MAX) * billion;
    const uint64_t high = (rest >> 32) * billion + (low >> 32);
    return (int64_t)(high / (ticks >> 32));
}

/* The seconds of a sum that may not fit in 64 bits, limited to the limit. */
static int64_t add_offset(uint64_t s, int64_t offset_s)
{
    const uint64_t limit = (uint64_t)LUM_PCAP_SECONDS_MAX;
    const uint64_t back = 0u - (uint64_t)offset_s;
    if (offset_s >= 0) {
        const uint64_t forth = (uint64_t)offset_s;
        return s > limit || forth > limit - s ? LUM_PCAP_SECONDS_MAX
                                              : (int64_t)(s + forth);
    }
    if (s >= back) {
        return s - back > limit ? LUM_PCAP_SECONDS_MAX : (int64_t)(s - back);
    }
    return back - s > limit ? -LUM_PCAP_SECONDS_MAX : -(int64_t)(back - s);
}

static int64_t time_of(const lum_pcap_interface *i, uint64_t ticks)
{
    const int64_t s = add_offset(ticks / i->ticks, i->offset_s);
    return s >= LUM_PCAP_SECONDS_MAX || s <= -LUM_PCAP_SECONDS_MAX
               ? s * 1000000000
               : s * 1000000000 + to_ns(ticks % i->ticks, i->ticks);
}

/* What its interface says of it. */
static int set_interface(const lum_pcap *r, uint32_t index, uint64_t ticks,
                         lum_pcap_record *out, lum_error *error)
{
    if (index >= r->interface_count) {
        return lum_pcap_fail(
            r, error, "a packet of interface %lu; its section has %lu",
            (unsigned long)index, (unsigned long)r->interface_count);
    }
    const lum_pcap_interface *i = &r->interfaces[index];
    if (i->is_lost) {
        return lum_pcap_fail(r, error,
                             "a packet of interface %lu, whose description "
                             "could not be read",
                             (unsigned long)index);
    }
    out->interface = index;
    out->name = i->name;
    out->link_type = i->link_type;
    out->time_ns = time_of(i, ticks);
    return 0;
}

/* Behind the fixed fields, within its block. */
static int set_bytes(const lum_pcap *r, const lum_pcapng_block *b, size_t from,
                     lum_pcap_record *out, lum_error *error)
{
    const size_t room = b->len - LUM_PCAPNG_TRAILER_BYTES - from;
    if (out->len > room) {
        return lum_pcap_fail(r, error,
                             "a packet of %lu bytes in a block with room for "
                             "%zu",
                             (unsigned long)out->len, room);
    }
    out->bytes = b->at + from;
    return 0;
}

/* How many bytes it holds, it does not say. The snap length does, unless the
 * block has more. */
static uint32_t simple_len(const lum_pcapng_block *b, uint32_t whole,
                           uint32_t snap)
{
    const size_t room = b->len - LUM_PCAPNG_TRAILER_BYTES - 12u;
    return whole <= snap || (room > lum_pcapng_padded(snap) && whole <= room)
               ? whole
               : snap;
}

static int read_simple(const lum_pcap *r, const lum_pcapng_block *b,
                       lum_pcap_record *out, lum_error *error)
{
    if (b->len < SIMPLE_PACKET_BYTES_MIN) {
        return lum_pcapng_fail_short(r, b, error);
    }
    if (set_interface(r, 0, 0, out, error) != 0) {
        return -1;
    }
    out->whole = file_u32(r, b->at + 8);
    out->len = simple_len(b, out->whole, r->interfaces[0].snap);
    return set_bytes(r, b, 12, out, error);
}

static int read_packet(const lum_pcap *r, const lum_pcapng_block *b,
                       lum_pcap_record *out, lum_error *error)
{
    if (b->len < PACKET_BYTES_MIN) {
        return lum_pcapng_fail_short(r, b, error);
    }
    const uint32_t index = b->type == LUM_PCAPNG_PACKET
                               ? file_u16(r, b->at + 8)
                               : file_u32(r, b->at + 8);
    const uint64_t ticks =
        (uint64_t)file_u32(r, b->at + 12) << 32 | file_u32(r, b->at + 16);
    if (set_interface(r, index, ticks, out, error) != 0) {
        return -1;
    }
    out->len = file_u32(r, b->at + 20);
    out->whole = file_u32(r, b->at + 24);
    if (set_bytes(r, b, 28, out, error) != 0) {
        return -1;
    }
    const size_t options = 28u + lum_pcapng_padded(out->len);
    if (options < b->len - LUM_PCAPNG_TRAILER_BYTES) {
        lum_pcapng_hand_out_options(r, LUM_PCAP_PACKET, b, options);
    }
    return 0;
}

/* --- From block to block --- */

static int lost(const lum_pcap *r, lum_error *error)
{
    (void)lum_pcap_fail(r, error,
                        "a block of a section whose header could not be read");
    return LUM_PCAP_DAMAGED;
}

/* A section or an interface: LUM_PCAP_GO_ON, LUM_PCAP_DAMAGED or
 * LUM_PCAP_FAILED. */
static int read_other(lum_pcap *r, const lum_pcapng_block *b, lum_error *error)
{
    return r->is_lost && b->type != LUM_PCAPNG_SECTION
               ? lost(r, error)
               : lum_pcapng_describe(r, b, error);
}

/* LUM_PCAP_READ, LUM_PCAP_GO_ON, LUM_PCAP_DAMAGED or LUM_PCAP_FAILED. */
static int read_block(lum_pcap *r, const lum_pcapng_block *b,
                      lum_pcap_record *out, lum_error *error)
{
    if (!is_packet(b->type)) {
        return read_other(r, b, error);
    }
    if (r->is_lost) {
        return lost(r, error);
    }
    const int read = b->type == LUM_PCAPNG_SIMPLE_PACKET
                         ? read_simple(r, b, out, error)
                         : read_packet(r, b, out, error);
    return read == 0 ? LUM_PCAP_READ : LUM_PCAP_DAMAGED;
}

static int next_step(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_pcapng_block b;
    int result = next_block(r, &b, error);
    if (result == LUM_PCAP_GO_ON) {
        result = read_block(r, &b, out, error);
        lum_source_take(r->source, result != LUM_PCAP_FAILED ? b.len : 0);
    } else if (result == LUM_PCAP_DAMAGED) {
        result = lum_pcapng_lose(r, &b, error);
    }
    return result;
}

/* A block counts once, also where the file is read again from before it. */
static void note_damage(lum_pcap *r, const lum_error *why)
{
    lum_pcap_note_damage(r, why);
    r->damaged_to = r->at >= r->damaged_to ? r->at + 1u : r->damaged_to;
}

static int next_packet(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    lum_error why; /* clearing all of it takes as long as a packet */
    int result = LUM_PCAP_GO_ON;
    why.text[0] = '\0';
    while (result == LUM_PCAP_GO_ON || result == LUM_PCAP_DAMAGED) {
        result = next_step(r, out, &why);
        if (result == LUM_PCAP_DAMAGED) {
            note_damage(r, &why);
        }
    }
    return result == LUM_PCAP_FAILED ? lum_error_set(error, "%s", why.text)
                                     : result;
}

/* --- Up to the first interface --- */

/* As next_step(), but a packet is left where it is. */
static int begin_step(lum_pcap *r, lum_pcapng_block *b, lum_error *error)
{
    int result = next_block(r, b, error);
    if (result == LUM_PCAP_DAMAGED) {
        return lum_pcapng_lose(r, b, error);
    }
    if (result != LUM_PCAP_GO_ON || is_packet(b->type)) {
        return result == LUM_PCAP_GO_ON ? LUM_PCAP_READ : result;
    }
    result = read_other(r, b, error);
    lum_source_take(r->source, result != LUM_PCAP_FAILED ? b->len : 0);
    return result == LUM_PCAP_DAMAGED && r->is_lost ? LUM_PCAP_FAILED : result;
}

static int refuse_without_interface(const lum_pcap *r, lum_error *error)
{
    return lum_error_set(error, "%s",
                         r->damaged != 0
                             ? r->damage.text
                             : "it describes no interface before its first "
                               "packet");
}

int lum_pcapng_begin(lum_pcap *reader, uint32_t *link_type, lum_error *error)
{
    lum_pcapng_block b = {.type = 0};
    lum_error why = {""};
    int result = LUM_PCAP_GO_ON;
    bool has_any = false;
    reader->next = next_packet;
    while (!reader->has_wanted && result >= LUM_PCAP_GO_ON) {
        result = begin_step(reader, &b, &why);
        if (result == LUM_PCAP_DAMAGED) {
            note_damage(reader, &why);
        } else if (result == LUM_PCAP_GO_ON && b.type == LUM_PCAPNG_INTERFACE) {
            const uint32_t last = reader->interface_count - 1u;
            const uint32_t found = reader->interfaces[last].link_type;
            *link_type = has_any && !reader->has_wanted ? *link_type : found;
            has_any = true;
        }
    }
    if (result == LUM_PCAP_FAILED) {
        return lum_error_set(error, "%s", why.text);
    }
    if (!has_any) {
        return refuse_without_interface(reader, error);
    }
    return reader->has_wanted ? 1 : result == LUM_PCAP_READ ? 2 : 0;
}
