/* Blocks that describe the sections and interfaces of a pcapng file, and the
 * options of any block, to what the reader keeps of them. */
#include "pcapng_sections.h"

#include <stdio.h>
#include <string.h>

enum {
    SECTION_BYTES_MIN = 28,
    INTERFACE_BYTES_MIN = 20,
    VERSION = 1,

    OPTION_END = 0,
    OPTION_NAME = 2,
    OPTION_RESOLUTION = 9,
    OPTION_OFFSET = 14,
    DECIMAL_MAX = 19, /* 10^19 ticks a second, the most of 64 bits */
    BINARY = 0x80,
    BINARY_MAX = 63
};

struct option {
    unsigned code;
    const uint8_t *value;
    size_t len;
};

int lum_pcapng_fail_short(const lum_pcap *r, const lum_pcapng_block *b,
                          lum_error *error)
{
    return lum_pcap_fail(r, error,
                         "a block of type %lu has %lu bytes, too few for it",
                         (unsigned long)b->type, (unsigned long)b->len);
}

/* --- Options --- */

/* Returns 1 with the option at a place in the block, which goes on; 0 after the
 * last; -1 if it is cut short. */
static int next_option(const lum_pcap *r, const lum_pcapng_block *b, size_t *at,
                       struct option *out)
{
    const uint8_t *p = b->at + *at;
    const size_t left = b->len - LUM_PCAPNG_TRAILER_BYTES - *at;
    if (left < 4) {
        return left == 0 ? 0 : -1;
    }
    out->code = file_u16(r, p);
    out->len = file_u16(r, p + 2);
    out->value = p + 4;
    const size_t all = 4u + lum_pcapng_padded(out->len);
    if (all > left) {
        return -1;
    }
    *at += all;
    return out->code == OPTION_END && out->len == 0 ? 0 : 1;
}

/* A broken option ends the list; other programs may write such options. */
void lum_pcapng_hand_out_options(const lum_pcap *r, lum_pcap_place place,
                                 const lum_pcapng_block *b, size_t from)
{
    struct option option;
    while (r->take_option != NULL && next_option(r, b, &from, &option) == 1) {
        r->take_option(r->option_context, place, option.code, option.value,
                       option.len);
    }
}

/* --- Interfaces --- */

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
    out->offset_s = (int64_t)(r->is_big ? load_big_u64(option->value)
                                        : load_u64(option->value));
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

static int read_option(const lum_pcap *r, const struct option *option,
                       lum_pcap_interface *out, lum_error *error)
{
    switch (option->code) {
    case OPTION_NAME:
        read_name(option, out);
        return 0;
    case OPTION_RESOLUTION:
        return read_resolution(r, option, out, error);
    case OPTION_OFFSET:
        return read_offset(r, option, out, error);
    default:
        return 0;
    }
}

static int read_interface_options(const lum_pcap *r, const lum_pcapng_block *b,
                                  lum_pcap_interface *out, lum_error *error)
{
    struct option option;
    size_t at = 16;
    unsigned seen = 0; /* a bit for each that may come only once */
    int result = 0;
    while ((result = next_option(r, b, &at, &option)) == 1) {
        const unsigned bit = option.code == OPTION_RESOLUTION ? 1u
                             : option.code == OPTION_OFFSET   ? 2u
                                                              : 0u;
        if (read_option(r, &option, out, error) != 0) {
            return -1;
        }
        if ((seen & bit) != 0) {
            return lum_pcap_fail(r, error,
                                 "an interface has two times of option %u",
                                 option.code);
        }
        seen |= bit;
    }
    return result == 0 ? 0
                       : lum_pcap_fail(r, error,
                                       "an interface's options are cut short");
}

static int parse_interface(const lum_pcap *r, const lum_pcapng_block *b,
                           lum_pcap_interface *out, lum_error *error)
{
    if (b->len < INTERFACE_BYTES_MIN) {
        return lum_pcapng_fail_short(r, b, error);
    }
    out->snap = lum_pcap_snap(file_u32(r, b->at + 12));
    out->link_type = file_u16(r, b->at + 8);
    (void)snprintf(out->name, sizeof out->name, "%lu",
                   (unsigned long)r->interface_count);
    return read_interface_options(r, b, out, error);
}

/* One that cannot be read keeps its place, so that packets of others are not
 * taken for its own. */
static int add_lost(lum_pcap *r, lum_error *error)
{
    const lum_pcap_interface lost = {.ticks = 1, .is_lost = true};
    return lum_pcap_add_interface(r, &lost, error) == 0 ? LUM_PCAP_DAMAGED
                                                        : LUM_PCAP_FAILED;
}

static int read_interface(lum_pcap *r, const lum_pcapng_block *b,
                          lum_error *error)
{
    lum_pcap_interface interface = {.ticks = 1000000};
    if (parse_interface(r, b, &interface, error) != 0) {
        return add_lost(r, error);
    }
    if (lum_pcap_add_interface(r, &interface, error) != 0) {
        return LUM_PCAP_FAILED;
    }
    lum_pcapng_hand_out_options(r, LUM_PCAP_INTERFACE, b, 16);
    return LUM_PCAP_GO_ON;
}

/* --- Sections --- */

static void lose_section(lum_pcap *r)
{
    r->interface_count = 0;
    r->is_lost = true;
}

/* Nothing of a section can be read whose header cannot. */
static int read_section(lum_pcap *r, const lum_pcapng_block *b,
                        lum_error *error)
{
    lose_section(r);
    if (b->len < SECTION_BYTES_MIN) {
        (void)lum_pcapng_fail_short(r, b, error);
        return LUM_PCAP_DAMAGED;
    }
    const unsigned version = file_u16(r, b->at + 12);
    if (version != VERSION) {
        (void)lum_pcap_fail(
            r, error, "a section of pcapng version %u; 1 can be read", version);
        return LUM_PCAP_DAMAGED;
    }
    r->is_lost = false;
    lum_pcapng_hand_out_options(r, LUM_PCAP_SECTION, b, 24);
    return LUM_PCAP_GO_ON;
}

/* --- Either --- */

int lum_pcapng_describe(lum_pcap *r, const lum_pcapng_block *b,
                        lum_error *error)
{
    return b->type == LUM_PCAPNG_SECTION ? read_section(r, b, error)
                                         : read_interface(r, b, error);
}

int lum_pcapng_lose(lum_pcap *r, const lum_pcapng_block *b, lum_error *error)
{
    if (b->type == LUM_PCAPNG_SECTION) {
        lose_section(r);
    }
    return b->type == LUM_PCAPNG_INTERFACE ? add_lost(r, error)
                                           : LUM_PCAP_DAMAGED;
}
