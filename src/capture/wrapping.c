#include "wrapping.h"

#include "byte_order.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

/* No link layer that is read. */
enum {
    LINKTYPE_DSA_FIRST = 281,
    LINKTYPE_DSA_LAST = 285
};

enum {
    IPV6_BYTES = 40,
    FIXED_BYTES =
        IPV4_BYTES + UDP_BYTES, /* before the magic, without options */
    LAYERS_MAX = 24,            /* of a frame, tags included */
    SEARCHED_BYTES = 256, /* for the magic, where the layers are not known */
    LLC_LENGTH_MAX = 1500 /* above, it is the type of what follows */
};

enum {
    TYPE_IPV4 = 0x0800,
    TYPE_TEB = 0x6558, /* an Ethernet frame */
    TYPE_8021Q = 0x8100,
    TYPE_IPV6 = 0x86dd,
    TYPE_MPLS = 0x8847,
    TYPE_MPLS_MULTICAST = 0x8848,
    TYPE_PPPOE = 0x8864,
    TYPE_8021AD = 0x88a8,
    TYPE_ERSPAN = 0x88be,
    TYPE_ERSPAN_3 = 0x22eb,
    TYPE_QINQ = 0x9100
};

enum {
    PROTOCOL_IPV4 = 4,
    PROTOCOL_UDP = 17,
    PROTOCOL_IPV6 = 41,
    PROTOCOL_GRE = 47
};

enum {
    PORT_VXLAN = 4789,
    PORT_GENEVE = 6081,
    PORT_VXLAN_LINUX = 8472 /* before it had a number of its own */
};

enum kind {
    KIND_NONE,
    KIND_LINK, /* what the link layer is called */
    KIND_VXLAN,
    KIND_GENEVE,
    KIND_GRE,
    KIND_ERSPAN_1,
    KIND_ERSPAN_2,
    KIND_ERSPAN_3,
    KIND_MPLS,
    KIND_PPPOE,
    KIND_IPV4,
    KIND_IPV6,
    KIND_SNAP,
    KIND_DSA,
    KIND_HEADER,
    KINDS
};

static const char *const kind_names[KINDS] = {
    [KIND_VXLAN] = "VXLAN",
    [KIND_GENEVE] = "Geneve",
    [KIND_GRE] = "GRE",
    [KIND_ERSPAN_1] = "ERSPAN type I",
    [KIND_ERSPAN_2] = "ERSPAN type II",
    [KIND_ERSPAN_3] = "ERSPAN type III",
    [KIND_MPLS] = "MPLS",
    [KIND_PPPOE] = "PPPoE",
    [KIND_IPV4] = "IPv4",
    [KIND_IPV6] = "IPv6",
    [KIND_SNAP] = "LLC/SNAP",
    [KIND_DSA] = "tags of a switch (DSA)",
    [KIND_HEADER] = "a header that is not known",
};

/* From layer to layer. */
struct walk {
    lum_span rest; /* from the layer that comes next */
    size_t at;     /* where that is in the frame */
    lum_wrapping *out;
    size_t kinds;
    size_t base;      /* where what is wrapped would begin */
    bool is_ethernet; /* an Ethernet frame begins there */
    bool is_ipv6;     /* the innermost packet */
    bool is_ours;
};

/* Reads a layer and goes behind it; NULL: there is nothing more to tell. */
typedef struct layer {
    struct layer (*read)(struct walk *w);
} layer;

static const layer no_layer = {NULL};

static layer next_is(layer (*read)(struct walk *w))
{
    return (layer){read};
}

/* What an Ethernet frame has inside may be no Ethernet frame. */
static void add_kind(struct walk *w, enum kind kind)
{
    w->is_ethernet = false;
    if (w->kinds < LUM_WRAPPINGS_MAX) {
        w->out->kinds[w->kinds++] = (uint8_t)kind;
    }
}

static bool has(const struct walk *w, size_t bytes)
{
    return w->rest.len >= bytes;
}

static unsigned u16_at(const struct walk *w, size_t at)
{
    return load_be16(w->rest.at + at);
}

/* As far as there are bytes: what comes then looks at what is left. */
static layer go_behind(struct walk *w, size_t bytes, layer next)
{
    const size_t n = bytes < w->rest.len ? bytes : w->rest.len;
    w->rest = (lum_span){w->rest.at + n, w->rest.len - n};
    w->at += n;
    return next;
}

/* --- Layers --- */

static layer read_ethernet(struct walk *w);
static layer read_ip(struct walk *w);
static layer read_mpls(struct walk *w);
static layer read_pppoe(struct walk *w);
static layer read_tag(struct walk *w);
static layer read_erspan_3(struct walk *w);

static layer of_type(unsigned type)
{
    static const struct {
        unsigned type;
        layer layer;
    } layers[] = {
        {TYPE_IPV4, {read_ip}},
        {TYPE_IPV6, {read_ip}},
        {TYPE_8021Q, {read_tag}},
        {TYPE_8021AD, {read_tag}},
        {TYPE_QINQ, {read_tag}},
        {TYPE_MPLS, {read_mpls}},
        {TYPE_MPLS_MULTICAST, {read_mpls}},
        {TYPE_PPPOE, {read_pppoe}},
        {TYPE_TEB, {read_ethernet}},
        {TYPE_ERSPAN_3, {read_erspan_3}},
    };
    for (size_t i = 0; i < sizeof layers / sizeof layers[0]; i++) {
        if (layers[i].type == type) {
            return layers[i].layer;
        }
    }
    return no_layer;
}

static layer read_tag(struct walk *w)
{
    return has(w, 4) ? go_behind(w, 4, of_type(u16_at(w, 2))) : no_layer;
}

/* The length of the frame in place of its type: what follows has its own. */
static layer read_snap(struct walk *w)
{
    static const uint8_t snap[] = {0xaa, 0xaa, 3, 0, 0, 0};
    if (!has(w, sizeof snap + 2u) ||
        memcmp(w->rest.at, snap, sizeof snap) != 0) {
        return no_layer;
    }
    add_kind(w, KIND_SNAP);
    return go_behind(w, sizeof snap + 2u, of_type(u16_at(w, sizeof snap)));
}

static layer read_ethernet(struct walk *w)
{
    if (!has(w, ETHERNET_BYTES)) {
        return no_layer;
    }
    const unsigned type = u16_at(w, 12);
    w->base = w->at;
    w->is_ethernet = true;
    return go_behind(w, ETHERNET_BYTES,
                     type <= LLC_LENGTH_MAX ? next_is(read_snap)
                                            : of_type(type));
}

/* Labels up to the last. Behind them, nothing says what follows; of an Ethernet
 * frame there may be a word before it, which begins with 0 as no packet does.
 */
static layer read_mpls(struct walk *w)
{
    bool is_last = false;
    add_kind(w, KIND_MPLS);
    while (!is_last && has(w, 5)) {
        is_last = (w->rest.at[2] & 1u) != 0;
        (void)go_behind(w, 4, no_layer);
    }
    const unsigned version = is_last ? w->rest.at[0] >> 4 : 15;
    if (version == 4 || version == 6) {
        return next_is(read_ip);
    }
    return is_last ? go_behind(w, version == 0 ? 4 : 0, next_is(read_ethernet))
                   : no_layer;
}

static layer read_pppoe(struct walk *w)
{
    add_kind(w, KIND_PPPOE);
    return go_behind(w, 8, next_is(read_ip));
}

static layer read_erspan_3(struct walk *w)
{
    const bool has_more = has(w, 12) && (w->rest.at[11] & 1u) != 0;
    return go_behind(w, has_more ? 20 : 12, next_is(read_ethernet));
}

/* Type II has a number and a header, type I neither. */
static layer read_erspan(struct walk *w, bool has_number)
{
    add_kind(w, has_number ? KIND_ERSPAN_2 : KIND_ERSPAN_1);
    return go_behind(w, has_number ? 8 : 0, next_is(read_ethernet));
}

static layer read_gre(struct walk *w)
{
    if (!has(w, 4)) {
        return no_layer;
    }
    const unsigned flags = u16_at(w, 0);
    const unsigned type = u16_at(w, 2);
    const bool has_number = (flags & 0x1000u) != 0;
    const size_t more = ((flags & 0x8000u) != 0 ? 4u : 0u) +
                        ((flags & 0x2000u) != 0 ? 4u : 0u) +
                        (has_number ? 4u : 0u);
    (void)go_behind(w, 4u + more, no_layer);
    if (type == TYPE_ERSPAN) {
        return read_erspan(w, has_number);
    }
    add_kind(w, type == TYPE_ERSPAN_3 ? KIND_ERSPAN_3 : KIND_GRE);
    return of_type(type);
}

static layer read_geneve(struct walk *w)
{
    if (!has(w, 8)) {
        return no_layer;
    }
    const size_t options = (w->rest.at[0] & 0x3fu) * 4u;
    add_kind(w, KIND_GENEVE);
    return go_behind(w, 8u + options, of_type(u16_at(w, 2)));
}

static layer read_vxlan(struct walk *w)
{
    add_kind(w, KIND_VXLAN);
    return go_behind(w, 8, next_is(read_ethernet));
}

static bool is_magic(lum_span bytes)
{
    uint8_t type = 0;
    return lum_header_decode(bytes.at, bytes.len, &type) != LUM_E_FOREIGN;
}

static layer read_udp(struct walk *w)
{
    if (!has(w, UDP_BYTES)) {
        return no_layer;
    }
    const unsigned port = u16_at(w, 2);
    (void)go_behind(w, UDP_BYTES, no_layer);
    w->is_ours = is_magic(w->rest);
    if (w->is_ours) {
        return no_layer;
    }
    if (port == PORT_VXLAN || port == PORT_VXLAN_LINUX) {
        return next_is(read_vxlan);
    }
    return port == PORT_GENEVE ? next_is(read_geneve) : no_layer;
}

static layer read_inner_ip(struct walk *w)
{
    const unsigned version = has(w, 1) ? w->rest.at[0] >> 4 : 0;
    if (version == 4) {
        add_kind(w, KIND_IPV4);
    }
    return next_is(read_ip);
}

static layer of_protocol(unsigned protocol)
{
    switch (protocol) {
    case PROTOCOL_UDP:
        return next_is(read_udp);
    case PROTOCOL_GRE:
        return next_is(read_gre);
    case PROTOCOL_IPV4:
    case PROTOCOL_IPV6:
        return next_is(read_inner_ip);
    default:
        return no_layer;
    }
}

/* Behind its fixed header and those that may follow it. */
static layer read_ipv6(struct walk *w)
{
    unsigned next = w->rest.at[6];
    add_kind(w, KIND_IPV6);
    w->is_ipv6 = true;
    (void)go_behind(w, IPV6_BYTES, no_layer);
    while ((next == 0 || next == 43 || next == 60) && has(w, 8)) {
        const size_t bytes = 8u + 8u * w->rest.at[1];
        next = w->rest.at[0];
        (void)go_behind(w, bytes, no_layer);
    }
    return of_protocol(next);
}

static layer read_ipv4(struct walk *w)
{
    const size_t bytes = (w->rest.at[0] & 0x0fu) * 4u;
    const unsigned protocol = w->rest.at[9];
    w->base = w->is_ethernet ? w->base : w->at;
    w->is_ipv6 = false;
    return go_behind(w, bytes, of_protocol(protocol));
}

static layer read_ip(struct walk *w)
{
    const unsigned version = has(w, 1) ? w->rest.at[0] >> 4 : 0;
    if (version == 4 && has(w, IPV4_BYTES)) {
        return read_ipv4(w);
    }
    return version == 6 && has(w, IPV6_BYTES) ? read_ipv6(w) : no_layer;
}

/* --- Frames --- */

static layer first_layer(struct walk *w, uint32_t link_type)
{
    switch (link_type) {
    case LINKTYPE_ETHERNET:
        return next_is(read_ethernet);
    case LINKTYPE_RAW:
    case LINKTYPE_RAW_OLD:
    case LINKTYPE_IPV4:
        return next_is(read_ip);
    case LINKTYPE_LINUX_SLL:
        return has(w, SLL_BYTES)
                   ? go_behind(w, SLL_BYTES, of_type(u16_at(w, 14)))
                   : no_layer;
    case LINKTYPE_LINUX_SLL2:
        return has(w, SLL2_BYTES)
                   ? go_behind(w, SLL2_BYTES, of_type(u16_at(w, 0)))
                   : no_layer;
    default:
        return no_layer;
    }
}

static bool is_ipv4_udp(const uint8_t *packet)
{
    return packet[0] == 0x45 && packet[9] == PROTOCOL_UDP;
}

/* Where a packet of a G2 stands in a frame whose layers are not known; 0: none
 * does. */
static size_t search(lum_span frame)
{
    const size_t end = frame.len < SEARCHED_BYTES ? frame.len : SEARCHED_BYTES;
    for (size_t at = 1; at + FIXED_BYTES + LUM_HEADER_BYTES <= end; at++) {
        const lum_span payload = {frame.at + at + FIXED_BYTES,
                                  end - at - FIXED_BYTES};
        if (is_ipv4_udp(frame.at + at) && is_magic(payload)) {
            return at;
        }
    }
    return 0;
}

/* A switch puts its tag between the addresses and the type, which stays. */
static enum kind kind_at(uint32_t link_type, lum_span frame, size_t ip)
{
    if (lum_link_find(link_type) == NULL) {
        return KIND_LINK;
    }
    return link_type == LINKTYPE_ETHERNET &&
                   (ip == ETHERNET_BYTES + 4 || ip == ETHERNET_BYTES + 8) &&
                   load_be16(frame.at + ip - 2) == TYPE_IPV4
               ? KIND_DSA
               : KIND_HEADER;
}

/* Wireshark's tools may not know these. */
static bool is_dsa(uint32_t link_type)
{
    return link_type >= LINKTYPE_DSA_FIRST && link_type <= LINKTYPE_DSA_LAST;
}

/* Whether a packet there is read, whatever is wrong with its lengths. */
static bool is_read(uint32_t link_type, lum_span frame, size_t ip)
{
    lum_span packet;
    lum_link_reader *const reader = lum_link_find(link_type);
    return reader != NULL && reader(frame, &packet) &&
           packet.at == frame.at + ip;
}

static bool find_unknown(uint32_t link_type, lum_span frame, lum_wrapping *out)
{
    const size_t ip = search(frame);
    if (ip == 0 || is_read(link_type, frame, ip)) {
        return false;
    }
    *out = (lum_wrapping){.link_type = link_type, .cut = (uint16_t)ip};
    out->kinds[0] = (uint8_t)kind_at(link_type, frame, ip);
    out->has_no_cut = is_dsa(link_type);
    return true;
}

lum_wrapped lum_wrapping_find(uint32_t link_type, lum_span frame,
                              lum_wrapping *out)
{
    lum_wrapping found = {.link_type = link_type};
    struct walk w = {.rest = frame, .out = &found};
    layer next = first_layer(&w, link_type);
    for (unsigned i = 0; i < LAYERS_MAX && next.read != NULL; i++) {
        next = next.read(&w);
    }
    if (!w.is_ours && find_unknown(link_type, frame, out)) {
        return LUM_WRAPPED_OURS;
    }
    if (w.kinds == 0 ||
        (!w.is_ours && w.kinds == 1 && found.kinds[0] == KIND_IPV6)) {
        return LUM_WRAPPED_NOT; /* IPv6 of others is in every capture */
    }
    found.cut = (uint16_t)w.base;
    found.is_ethernet = w.is_ethernet;
    found.has_no_cut = w.is_ipv6 || w.base == 0;
    *out = found;
    return w.is_ours ? LUM_WRAPPED_OURS : LUM_WRAPPED_OTHER;
}

/* --- Texts --- */

const char *lum_wrapping_name(const lum_wrapping *wrapping,
                              char out[LUM_WRAPPING_TEXT_BYTES])
{
    size_t len = 0;
    out[0] = '\0';
    for (size_t i = 0; i < LUM_WRAPPINGS_MAX && wrapping->kinds[i] != 0; i++) {
        const unsigned kind = wrapping->kinds[i];
        const char *name = kind == KIND_LINK
                               ? lum_link_name(wrapping->link_type)
                               : kind_names[kind];
        len += (size_t)snprintf(out + len, LUM_WRAPPING_TEXT_BYTES - len,
                                "%s%s", i > 0 ? ", then " : "", name);
    }
    return out;
}

static bool is_raw(uint32_t link_type)
{
    return link_type == LINKTYPE_RAW || link_type == LINKTYPE_RAW_OLD ||
           link_type == LINKTYPE_IPV4;
}

/* What is left has another link type than the file says. */
static const char *type_option(const lum_wrapping *w)
{
    if (w->is_ethernet) {
        return w->link_type == LINKTYPE_ETHERNET ? "" : " -T ether";
    }
    return is_raw(w->link_type) ? "" : " -T rawip4";
}

const char *lum_wrapping_remedy(const lum_wrapping *wrapping,
                                char out[LUM_WRAPPING_TEXT_BYTES])
{
    if (is_dsa(wrapping->link_type)) {
        (void)snprintf(out, LUM_WRAPPING_TEXT_BYTES,
                       "record at a port of the switch, such as lan1, where "
                       "packets have no tag");
    } else if (wrapping->has_no_cut) {
        (void)snprintf(out, LUM_WRAPPING_TEXT_BYTES,
                       "record where the sensor's packets are plain IPv4");
    } else {
        (void)snprintf(out, LUM_WRAPPING_TEXT_BYTES,
                       "strip it by editcap -C %u -L%s IN OUT",
                       (unsigned)wrapping->cut, type_option(wrapping));
    }
    return out;
}
