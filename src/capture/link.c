#include "link.h"

#include "byte_order.h"

#include "lum/wire.h"

#include <stdio.h>

enum {
    ETHERTYPE_IPV4 = 0x0800,
    ETHERTYPE_8021Q = 0x8100,
    ETHERTYPE_8021AD = 0x88a8,
    ETHERTYPE_QINQ = 0x9100,
    TAG_BYTES = 4,
    LOOPBACK_BYTES = 4,
    AF_INET_EVERYWHERE = 2,
    DSA_FIRST = 281, /* link types that Wireshark's tools may not know */
    DSA_LAST = 285,
    PROTOCOL_UDP = 17,
    SEARCHED_BYTES = 256 /* of a frame, for a packet of a G2 */
};

static lum_span behind(lum_span span, size_t bytes)
{
    return (lum_span){span.at + bytes, span.len - bytes};
}

static bool is_tag(unsigned ethertype)
{
    return ethertype == ETHERTYPE_8021Q || ethertype == ETHERTYPE_8021AD ||
           ethertype == ETHERTYPE_QINQ;
}

/* A tag is the control word and the type of what follows it. */
static bool skip_tags(unsigned ethertype, lum_span rest, lum_span *packet)
{
    while (is_tag(ethertype) && rest.len >= TAG_BYTES) {
        ethertype = load_big_u16(rest.at + 2);
        rest = behind(rest, TAG_BYTES);
    }
    if (ethertype != ETHERTYPE_IPV4) {
        return false;
    }
    *packet = rest;
    return true;
}

static bool read_ethernet(lum_span frame, lum_span *packet)
{
    return frame.len >= ETHERNET_BYTES &&
           skip_tags(load_big_u16(frame.at + 12), behind(frame, ETHERNET_BYTES),
                     packet);
}

static bool read_cooked(lum_span frame, lum_span *packet)
{
    return frame.len >= SLL_BYTES &&
           skip_tags(load_big_u16(frame.at + 14), behind(frame, SLL_BYTES),
                     packet);
}

static bool read_cooked_v2(lum_span frame, lum_span *packet)
{
    return frame.len >= SLL2_BYTES &&
           skip_tags(load_big_u16(frame.at), behind(frame, SLL2_BYTES), packet);
}

/* The family is in the byte order of the machine that captured. */
static bool read_loopback(lum_span frame, lum_span *packet)
{
    if (frame.len < LOOPBACK_BYTES) {
        return false;
    }
    const uint32_t family = load_big_u32(frame.at);
    if (family != AF_INET_EVERYWHERE && family != (uint32_t)AF_INET_EVERYWHERE
                                                      << 24) {
        return false;
    }
    *packet = behind(frame, LOOPBACK_BYTES);
    return true;
}

/* IPv6 may be among it; the packet's version tells. */
static bool read_raw(lum_span frame, lum_span *packet)
{
    *packet = frame;
    return true;
}

lum_link_reader *lum_link_find(uint32_t link_type)
{
    static const struct {
        uint32_t link_type;
        lum_link_reader *reader;
    } readers[] = {
        {LINKTYPE_ETHERNET, read_ethernet},
        {LINKTYPE_LINUX_SLL, read_cooked},
        {LINKTYPE_LINUX_SLL2, read_cooked_v2},
        {LINKTYPE_RAW, read_raw},
        {LINKTYPE_RAW_OLD, read_raw},
        {LINKTYPE_IPV4, read_raw},
        {LINKTYPE_NULL, read_loopback},
        {LINKTYPE_LOOP, read_loopback},
    };
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; i++) {
        if (readers[i].link_type == link_type) {
            return readers[i].reader;
        }
    }
    return NULL;
}

const char *lum_link_supported(void)
{
    return "Ethernet, Linux cooked v1 and v2, raw IP and BSD loopback";
}

const char *lum_link_name(uint32_t link_type)
{
    static const struct {
        uint32_t link_type;
        const char *name;
    } names[] = {
        {6, "token ring"},
        {9, "PPP"},
        {10, "FDDI"},
        {50, "PPP over serial line"},
        {51, "PPP over Ethernet"},
        {105, "Wi-Fi: IEEE 802.11"},
        {117, "OpenBSD pflog"},
        {119, "Wi-Fi: Prism"},
        {127, "Wi-Fi: IEEE 802.11 with radiotap"},
        {149, "of the user, or pktap"},
        {187, "Bluetooth"},
        {189, "USB"},
        {190, "CAN"},
        {195, "IEEE 802.15.4"},
        {201, "Bluetooth"},
        {210, "FlexRay"},
        {212, "LIN"},
        {219, "MPLS"},
        {220, "USB"},
        {227, "CAN"},
        {229, "IPv6 alone"},
        {239, "NFLOG"},
        {249, "USB"},
        {253, "netlink"},
        {258, "pktap"},
        {281, "tags of a Broadcom switch (DSA)"},
        {282, "tags of a Broadcom switch (DSA)"},
        {284, "tags of a Marvell switch (DSA)"},
        {285, "tags of a Marvell switch (EDSA)"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].link_type == link_type) {
            return names[i].name;
        }
    }
    return "unknown";
}

/* --- Packets that are not read as they stand --- */

/* IPv4 without options, and UDP with the magic. */
static bool is_of_a_g2(lum_span packet)
{
    const size_t headers = IPV4_BYTES + UDP_BYTES;
    uint8_t type = 0;
    return packet.at[0] == 0x45 && packet.at[9] == PROTOCOL_UDP &&
           lum_header_decode(packet.at + headers, packet.len - headers,
                             &type) != LUM_E_FOREIGN;
}

/* Whether a packet there is read, whatever is wrong with its lengths. */
static bool is_read(uint32_t link_type, lum_span frame, size_t at)
{
    lum_span packet;
    lum_link_reader *const reader = lum_link_find(link_type);
    return reader != NULL && reader(frame, &packet) &&
           packet.at == frame.at + at;
}

size_t lum_link_find_hidden(uint32_t link_type, lum_span frame)
{
    const size_t end = frame.len < SEARCHED_BYTES ? frame.len : SEARCHED_BYTES;
    const lum_span searched = {frame.at, end};
    const size_t needed = IPV4_BYTES + UDP_BYTES + LUM_HEADER_BYTES;
    for (size_t at = 1; at + needed <= end; at++) {
        if (is_of_a_g2(behind(searched, at))) {
            return is_read(link_type, frame, at) ? 0 : at;
        }
    }
    return 0;
}

const char *lum_link_fix(uint32_t link_type, size_t hidden_at,
                         char out[LUM_LINK_FIX_BYTES])
{
    const bool is_raw = lum_link_find(link_type) == read_raw;
    if (link_type >= DSA_FIRST && link_type <= DSA_LAST) {
        (void)snprintf(out, LUM_LINK_FIX_BYTES,
                       "record at a port of the switch, such as lan1, where "
                       "packets have no tag");
    } else {
        (void)snprintf(out, LUM_LINK_FIX_BYTES,
                       "strip them by editcap -C %zu -L%s IN OUT", hidden_at,
                       is_raw ? "" : " -T rawip4");
    }
    return out;
}
