#include "pcap_internal.h"

#include <stdio.h>
#include <string.h>

enum {
    BLOCK_SECTION = 0x0a0d0d0a, /* the same in either byte order */
    BLOCK_INTERFACE = 1,
    BLOCK_PACKET = 2, /* obsolete */
    BLOCK_SIMPLE_PACKET = 3,
    BLOCK_ENHANCED_PACKET = 6,

    HEADER_BYTES = 8,
    TRAILER_BYTES = 4,
    BLOCK_BYTES_MIN = HEADER_BYTES + TRAILER_BYTES,
    SECTION_BYTES_MIN = 28,
    INTERFACE_BYTES_MIN = 20,
    SIMPLE_PACKET_BYTES_MIN = 16,
    PACKET_BYTES_MIN = 32,

    BYTE_ORDER = 0x1a2b3c4d,
    VERSION = 1,

    OPTION_END = 0,
    OPTION_NAME = 2,
    OPTION_RESOLUTION = 9,
    OPTION_OFFSET = 14,
    DECIMAL_MAX = 19, /* 10^19 ticks a second, the most of 64 bits */
    BINARY = 0x80,
    BINARY_MAX = 63
};

/* A block at hand, from its header to behind its trailer. */
struct block {
    const uint8_t *at;
    uint32_t type;
    uint32_t len;
};

/* What is left of a block's options. */
struct options {
    const uint8_t *at;
    size_t left;
};

struct option {
    unsigned code;
    const uint8_t *value;
    size_t len;
};

/* --- Options --- */

bool lum_pcapng_is(lum_source *source)
{
    return lum_source_has(source, 4) && load_be32(source->at) == BLOCK_SECTION;
}

static size_t padded(size_t len)
{
    return (len + 3u) / 4u * 4u;
}

/* Returns 1 with an option; 0 after the last; -1 if it is cut short. */
static int next_option(const lum_pcap *r, struct options *o, struct option *out)
{
    if (o->left == 0) {
        return 0;
    }
    if (o->left < 4) {
        return -1;
    }
    out->code = load_u16(r, o->at);
    out->len = load_u16(r, o->at + 2);
    out->value = o->at + 4;
    if (padded(out->len) > o->left - 4u) {
        return -1;
    }
    if (out->code == OPTION_END && out->len == 0) {
        return 0;
    }
    o->at += 4u + padded(out->len);
    o->left -= 4u + padded(out->len);
    return 1;
}

/* From a place in the block to its trailer. */
static struct options options_from(const struct block *b, size_t from)
{
    return (struct options){b->at + from, b->len - TRAILER_BYTES - from};
}

/* A broken option ends the list; other programs may write such options. */
static void hand_out_options(const lum_pcap *r, lum_pcap_place place,
                             struct options o)
{
    struct option option;
    while (r->take_option != NULL && next_option(r, &o, &option) == 1) {
        r->take_option(r->option_context, place, option.code, option.value,
                       option.len);
    }
}

static int read_resolution(const lum_pcap *r, const struct option *option,
                           lum_pcap_interface *out, lum_error *error)
{
    const unsigned value = option->len == 1 ? option->value[0] : 255;
    const unsigned exponent = value & ~(unsigned)BINARY;
    const bool is_binary = (value & BINARY) != 0;
    if (exponent > (is_binary ? BINARY_MAX : DECIMAL_MAX)) {
        return lum_pcap_fail(r, error,
                             "an interface's resolution of time is out of "
                             "range");
    }
    out->ticks = is_binary ? UINT64_C(1) << exponent : 1;
    for (unsigned i = 0; !is_binary && i < exponent; i++) {
        out->ticks *= 10u;
    }
    return 0;
}

static int read_offset(const lum_pcap *r, const struct option *option,
                       lum_pcap_interface *out, lum_error *error)
{
    if (option->len != 8) {
        return lum_pcap_fail(r, error,
                             "an interface's offset of time has %zu bytes; it "
                             "needs 8",
                             option->len);
    }
    const uint32_t first = load_u32(r, option->value);
    const uint32_t second = load_u32(r, option->value + 4);
    const uint64_t high = r->is_big ? first : second;
    const uint64_t low = r->is_big ? second : first;
    out->offset_s = (int64_t)(high << 32 | low);
    return 0;
}

/* A name that could not be typed, or told from another one, is not taken: the
 * number stays. */
static void read_name(const struct option *option, lum_pcap_interface *out)
{
    size_t len = option->len;
    while (len > 0 && option->value[len - 1u] == '\0') {
        len--; /* which some programs count */
    }
    bool is_plain = len > 0 && len < sizeof out->name;
    for (size_t i = 0; i < len && is_plain; i++) {
        is_plain = option->value[i] > ' ' && option->value[i] <= '~';
    }
    if (is_plain) {
        memcpy(out->name, option->value, len);
        out->name[len] = '\0';
    }
}

static int read_interface_options(const lum_pcap *r, struct options o,
                                  lum_pcap_interface *out, lum_error *error)
{
    struct option option;
    bool has_resolution = false;
    bool has_offset = false;
    int result = 0;
    while ((result = next_option(r, &o, &option)) == 1) {
        bool *has = NULL;
        int read = 0;
        if (option.code == OPTION_RESOLUTION) {
            has = &has_resolution;
            read = read_resolution(r, &option, out, error);
        } else if (option.code == OPTION_OFFSET) {
            has = &has_offset;
            read = read_offset(r, &option, out, error);
        } else if (option.code == OPTION_NAME) {
            read_name(&option, out);
        }
        if (read != 0) {
            return -1;
        }
        if (has != NULL && *has) {
            return lum_pcap_fail(r, error,
                                 "an interface has two times of option %u",
                                 option.code);
        }
        if (has != NULL) {
            *has = true;
        }
    }
    return result == 0 ? 0
                       : lum_pcap_fail(r, error,
                                       "an interface's options are cut short");
}

/* --- Sections and interfaces --- */

static int too_short(const lum_pcap *r, const struct block *b, lum_error *error)
{
    return lum_pcap_fail(r, error,
                         "a block of type %lu has %lu bytes, too few for it",
                         (unsigned long)b->type, (unsigned long)b->len);
}

static int parse_interface(const lum_pcap *r, const struct block *b,
                           lum_pcap_interface *out, lum_error *error)
{
    if (b->len < INTERFACE_BYTES_MIN) {
        return too_short(r, b, error);
    }
    out->snap = lum_pcap_snap(load_u32(r, b->at + 12));
    out->link_type = load_u16(r, b->at + 8);
    (void)snprintf(out->name, sizeof out->name, "%lu",
                   (unsigned long)r->interface_count);
    return read_interface_options(r, options_from(b, 16), out, error);
}

/* One that cannot be read keeps its place, so that packets of others are not
 * taken for its own. */
static int read_interface(lum_pcap *r, const struct block *b, lum_error *error)
{
    lum_pcap_interface interface = {.ticks = 1000000};
    lum_error why = {""};
    if (parse_interface(r, b, &interface, &why) != 0) {
        interface = (lum_pcap_interface){.ticks = 1, .is_lost = true};
    }
    if (lum_pcap_add_interface(r, &interface, error) != 0) {
        return LUM_PCAP_FAILED;
    }
    if (interface.is_lost) {
        (void)lum_error_set(error, "%s", why.text);
        return LUM_PCAP_DAMAGED;
    }
    hand_out_options(r, LUM_PCAP_INTERFACE, options_from(b, 16));
    return LUM_PCAP_GO_ON;
}

/* Nothing of a section can be read whose header cannot. */
static int read_section(lum_pcap *r, const struct block *b, lum_error *error)
{
    r->interface_count = 0;
    r->is_lost = true;
    if (b->len < SECTION_BYTES_MIN) {
        (void)too_short(r, b, error);
        return LUM_PCAP_DAMAGED;
    }
    const unsigned version = load_u16(r, b->at + 12);
    if (version != VERSION) {
        (void)lum_pcap_fail(
            r, error, "a section of pcapng version %u; 1 can be read", version);
        return LUM_PCAP_DAMAGED;
    }
    r->is_lost = false;
    hand_out_options(r, LUM_PCAP_SECTION, options_from(b, 24));
    return LUM_PCAP_GO_ON;
}

/* The byte order of a section comes after its length. */
static int read_order(lum_pcap *r, lum_error *error)
{
    lum_source *s = r->source;
    if (!lum_source_has(s, HEADER_BYTES + 4)) {
        return lum_pcap_fail_cut(r, "section header", s->left, 0, error);
    }
    r->is_big = load_be32(s->at + HEADER_BYTES) == BYTE_ORDER;
    if (load_u32(r, s->at + HEADER_BYTES) != BYTE_ORDER) {
        return lum_pcap_fail(r, error, "a section without a valid byte order");
    }
    return 0;
}

/* --- Blocks --- */

static bool is_read(uint32_t type)
{
    return (type >= BLOCK_INTERFACE && type <= BLOCK_SIMPLE_PACKET) ||
           type == BLOCK_ENHANCED_PACKET || type == BLOCK_SECTION;
}

static bool is_packet(uint32_t type)
{
    return is_read(type) && type != BLOCK_SECTION && type != BLOCK_INTERFACE;
}

static bool is_possible(const lum_pcap *r, const struct block *b,
                        lum_error *error)
{
    if (b->len < BLOCK_BYTES_MIN || b->len % 4u != 0) {
        (void)lum_pcap_fail(r, error,
                            "a block of %lu bytes; there are at least %d, and "
                            "a multiple of 4",
                            (unsigned long)b->len, (int)BLOCK_BYTES_MIN);
        return false;
    }
    return true;
}

/* Returns 1 with a block's type and length; 0 at the end. */
static int read_block_header(lum_pcap *r, struct block *b, lum_error *error)
{
    lum_source *s = r->source;
    r->at = lum_source_offset(s);
    if (!lum_source_has(s, HEADER_BYTES)) {
        if (s->left == 0 && !s->has_failed) {
            return 0;
        }
        (void)lum_pcap_fail_cut(r, "block", s->left, 0, error);
        return -1;
    }
    if (load_be32(s->at) == BLOCK_SECTION && read_order(r, error) != 0) {
        return -1;
    }
    b->type = load_u32(r, s->at);
    b->len = load_u32(r, s->at + 4);
    return is_possible(r, b, error) ? 1 : -1;
}

/* Both ends of a block say its length. */
static int check_trailer(const lum_pcap *r, uint32_t len,
                         const uint8_t *trailer, lum_error *error)
{
    const uint32_t again = load_u32(r, trailer);
    return again == len
               ? 0
               : lum_pcap_fail(r, error,
                               "a block of %lu bytes at its start has "
                               "%lu at its end",
                               (unsigned long)len, (unsigned long)again);
}

/* Of a type that is not known, of any length. */
static int skip_block(lum_pcap *r, const struct block *b, lum_error *error)
{
    lum_source *s = r->source;
    if (!lum_source_skip(s, b->len - TRAILER_BYTES) ||
        !lum_source_has(s, TRAILER_BYTES)) {
        return lum_pcap_fail_cut(r, "block", s->end - r->at, b->len, error);
    }
    if (check_trailer(r, b->len, s->at, error) != 0) {
        return -1;
    }
    lum_source_take(s, TRAILER_BYTES);
    return 0;
}

/* Of a type that is read. */
static int skip_long_block(lum_pcap *r, const struct block *b, lum_error *error)
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
static int next_block(lum_pcap *r, struct block *b, lum_error *error)
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
        (void)lum_pcap_fail_cut(r, "block", s->left, b->len, error);
        return LUM_PCAP_FAILED;
    }
    b->at = s->at;
    return check_trailer(r, b->len, b->at + b->len - TRAILER_BYTES, error) == 0
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

/* NULL: with the reason in error. */
static const lum_pcap_interface *find_interface(const lum_pcap *r,
                                                uint32_t index,
                                                lum_error *error)
{
    if (index >= r->interface_count) {
        (void)lum_pcap_fail(
            r, error, "a packet of interface %lu; its section has %lu",
            (unsigned long)index, (unsigned long)r->interface_count);
        return NULL;
    }
    if (r->interfaces[index].is_lost) {
        (void)lum_pcap_fail(r, error,
                            "a packet of interface %lu, whose description "
                            "could not be read",
                            (unsigned long)index);
        return NULL;
    }
    return &r->interfaces[index];
}

/* Behind the fixed fields, within its block. */
static int set_bytes(const lum_pcap *r, const struct block *b, size_t from,
                     lum_pcap_record *out, lum_error *error)
{
    const size_t room = b->len - TRAILER_BYTES - from;
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
static uint32_t simple_len(const struct block *b, uint32_t whole, uint32_t snap)
{
    const size_t room = b->len - TRAILER_BYTES - 12u;
    return whole <= snap || (room > padded(snap) && whole <= room) ? whole
                                                                   : snap;
}

static int read_simple(const lum_pcap *r, const struct block *b,
                       lum_pcap_record *out, lum_error *error)
{
    if (b->len < SIMPLE_PACKET_BYTES_MIN) {
        return too_short(r, b, error);
    }
    const lum_pcap_interface *i = find_interface(r, 0, error);
    if (i == NULL) {
        return -1;
    }
    out->interface = 0;
    out->name = i->name;
    out->link_type = i->link_type;
    out->time_ns = time_of(i, 0);
    out->whole = load_u32(r, b->at + 8);
    out->len = simple_len(b, out->whole, i->snap);
    return set_bytes(r, b, 12, out, error);
}

static int read_packet(const lum_pcap *r, const struct block *b,
                       lum_pcap_record *out, lum_error *error)
{
    if (b->len < PACKET_BYTES_MIN) {
        return too_short(r, b, error);
    }
    out->interface = b->type == BLOCK_PACKET ? load_u16(r, b->at + 8)
                                             : load_u32(r, b->at + 8);
    const lum_pcap_interface *i = find_interface(r, out->interface, error);
    if (i == NULL) {
        return -1;
    }
    out->name = i->name;
    out->link_type = i->link_type;
    out->time_ns = time_of(i, (uint64_t)load_u32(r, b->at + 12) << 32 |
                                  load_u32(r, b->at + 16));
    out->len = load_u32(r, b->at + 20);
    out->whole = load_u32(r, b->at + 24);
    if (set_bytes(r, b, 28, out, error) != 0) {
        return -1;
    }
    if (r->take_option != NULL &&
        28u + padded(out->len) <= b->len - TRAILER_BYTES) {
        hand_out_options(r, LUM_PCAP_PACKET,
                         options_from(b, 28u + padded(out->len)));
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
static int read_other(lum_pcap *r, const struct block *b, lum_error *error)
{
    if (b->type == BLOCK_SECTION) {
        return read_section(r, b, error);
    }
    return r->is_lost ? lost(r, error) : read_interface(r, b, error);
}

/* LUM_PCAP_READ, LUM_PCAP_GO_ON, LUM_PCAP_DAMAGED or LUM_PCAP_FAILED. */
static int read_block(lum_pcap *r, const struct block *b, lum_pcap_record *out,
                      lum_error *error)
{
    if (!is_packet(b->type)) {
        return read_other(r, b, error);
    }
    if (r->is_lost) {
        return lost(r, error);
    }
    const int read = b->type == BLOCK_SIMPLE_PACKET
                         ? read_simple(r, b, out, error)
                         : read_packet(r, b, out, error);
    return read == 0 ? LUM_PCAP_READ : LUM_PCAP_DAMAGED;
}

/* What follows a block that is too long to be read knows that it was there. */
static int lose_block(lum_pcap *r, const struct block *b, lum_error *error)
{
    const lum_pcap_interface lost = {.ticks = 1, .is_lost = true};
    if (b->type == BLOCK_SECTION) {
        r->interface_count = 0;
        r->is_lost = true;
    }
    return b->type != BLOCK_INTERFACE ||
                   lum_pcap_add_interface(r, &lost, error) == 0
               ? LUM_PCAP_DAMAGED
               : LUM_PCAP_FAILED;
}

static int next_step(lum_pcap *r, lum_pcap_record *out, lum_error *error)
{
    struct block b;
    int result = next_block(r, &b, error);
    if (result == LUM_PCAP_GO_ON) {
        result = read_block(r, &b, out, error);
        lum_source_take(r->source, result != LUM_PCAP_FAILED ? b.len : 0);
    } else if (result == LUM_PCAP_DAMAGED) {
        result = lose_block(r, &b, error);
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
static int begin_step(lum_pcap *r, struct block *b, lum_error *error)
{
    int result = next_block(r, b, error);
    if (result == LUM_PCAP_DAMAGED) {
        return lose_block(r, b, error);
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
    struct block b = {.type = 0};
    lum_error why = {""};
    int result = LUM_PCAP_GO_ON;
    bool has_any = false;
    reader->next = next_packet;
    while (!reader->has_wanted && result >= LUM_PCAP_GO_ON) {
        result = begin_step(reader, &b, &why);
        if (result == LUM_PCAP_DAMAGED) {
            note_damage(reader, &why);
        } else if (result == LUM_PCAP_GO_ON && b.type == BLOCK_INTERFACE) {
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
