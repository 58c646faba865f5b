#include "link.h"

#include "be.h"

#include <pcap/dlt.h>

enum {
    ETHERTYPE_IPV4 = 0x0800,
    ETHERTYPE_8021Q = 0x8100,
    ETHERTYPE_8021AD = 0x88a8,
    ETHERTYPE_QINQ = 0x9100,
    TAG_BYTES = 4,
    ETHERNET_BYTES = 14,
    SLL_BYTES = 16,
    SLL2_BYTES = 20,
    LOOPBACK_BYTES = 4,
    AF_INET_EVERYWHERE = 2
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
        ethertype = load_be16(rest.at + 2);
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
           skip_tags(load_be16(frame.at + 12), behind(frame, ETHERNET_BYTES),
                     packet);
}

static bool read_cooked(lum_span frame, lum_span *packet)
{
    return frame.len >= SLL_BYTES &&
           skip_tags(load_be16(frame.at + 14), behind(frame, SLL_BYTES),
                     packet);
}

static bool read_cooked_v2(lum_span frame, lum_span *packet)
{
    return frame.len >= SLL2_BYTES &&
           skip_tags(load_be16(frame.at), behind(frame, SLL2_BYTES), packet);
}

/* The family is in the byte order of the machine that captured. */
static bool read_loopback(lum_span frame, lum_span *packet)
{
    if (frame.len < LOOPBACK_BYTES) {
        return false;
    }
    const uint32_t family = load_be32(frame.at);
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

lum_link_reader *lum_link_find(int link_type)
{
    static const struct {
        int link_type;
        lum_link_reader *reader;
    } readers[] = {
        {DLT_EN10MB, read_ethernet},
        {DLT_LINUX_SLL, read_cooked},
        {DLT_LINUX_SLL2, read_cooked_v2},
        {DLT_RAW, read_raw},
        {DLT_IPV4, read_raw},
        {DLT_NULL, read_loopback},
        {DLT_LOOP, read_loopback},
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
