#include "remarks.h"

#include "lum/wire.h"

#include <inttypes.h>
#include <string.h>

#define OUT_OF_ORDER_MIN 3u

/* From so many on, and one of so many packets of data. */
#define STRAY_MIN   16u
#define STRAY_SHARE 16u

/* --- Looking --- */

static void note_wrapping(lum_remarks *r, const lum_wrapping *what,
                          lum_wrapped is)
{
    size_t i = 0;
    while (i < r->wrapped_count &&
           (r->wrapped[i].is != is ||
            memcmp(&r->wrapped[i].what, what, sizeof *what) != 0)) {
        i++;
    }
    if (i == LUM_REMARKS_WRAPPINGS) {
        return;
    }
    if (i == r->wrapped_count) {
        r->wrapped[i].what = *what;
        r->wrapped[i].is = is;
        r->wrapped_count++;
    }
    r->wrapped[i].count++;
}

static void note_port(lum_remarks *r, uint16_t port, bool is_source)
{
    size_t i = 0;
    while (i < r->port_count && r->ports[i].port != port) {
        i++;
    }
    if (i == LUM_REMARKS_PORTS) {
        return;
    }
    if (i == r->port_count) {
        r->ports[r->port_count++].port = port;
    }
    r->ports[i].from += is_source;
}

static bool is_of_a_g2(const lum_record *record, uint8_t *type)
{
    return record->kind == LUM_RECORD_DATAGRAM &&
           lum_header_decode(record->payload, record->len, type) !=
               LUM_E_FOREIGN;
}

/* Requests, answers and heartbeats go to and from other ports, too. */
static bool may_be_data(const lum_record *record, uint8_t type)
{
    return type != LUM_TYPE_SET_IP && type != LUM_TYPE_TIMESTAMP &&
           type != LUM_TYPE_TLV && record->len > LUM_HEADER_BYTES;
}

void lum_remarks_take(lum_remarks *remarks, const lum_pcap_record *from,
                      const lum_record *out)
{
    lum_wrapping what;
    uint8_t type = 0;
    if (from->len < from->whole && from->len > remarks->held_max) {
        remarks->held_max = from->len;
    }
    if (is_of_a_g2(out, &type)) {
        if (may_be_data(out, type)) {
            note_port(remarks, out->source_port, true);
            note_port(remarks, out->destination_port, false);
        }
    } else if (out->kind != LUM_RECORD_FRAGMENT) {
        const lum_wrapped is = lum_wrapping_find(
            from->link_type, (lum_span){from->bytes, from->len}, &what);
        if (is != LUM_WRAPPED_NOT) {
            note_wrapping(remarks, &what, is);
        }
    }
}

/* --- Saying --- */

static bool has_data_of(const lum_remarks *r, uint16_t port)
{
    for (size_t i = 0; i < r->port_count; i++) {
        if (r->ports[i].port == port) {
            return true;
        }
    }
    return false;
}

static bool say_port(const lum_remarks *r, uint16_t port, lum_error *out)
{
    size_t most = 0;
    for (size_t i = 1; i < r->port_count; i++) {
        most = r->ports[i].from > r->ports[most].from ? i : most;
    }
    if (r->port_count == 0 || has_data_of(r, port)) {
        return false;
    }
    (void)lum_error_set(out,
                        "%" PRIu64 " packets of a G2 came from UDP port %u, "
                        "and none from or to port %u: something between has "
                        "changed the port (NAT); read it with lumdump --port "
                        "%u, lumview --sensor-port %u, in Python port=%u",
                        r->ports[most].from, (unsigned)r->ports[most].port,
                        (unsigned)port, (unsigned)r->ports[most].port,
                        (unsigned)r->ports[most].port,
                        (unsigned)r->ports[most].port);
    return true;
}

static bool say_cut(const lum_remarks *r, const lum_demux_counters *counters,
                    lum_error *out)
{
    if (counters->cut_short == 0) {
        return false;
    }
    if (r->held_max == 0) {
        (void)lum_error_set(out,
                            "%" PRIu64 " datagrams are in the capture only in "
                            "part, and are not used",
                            counters->cut_short);
    } else {
        (void)lum_error_set(out,
                            "%" PRIu64 " datagrams are in the capture only in "
                            "part, and are not used: it was recorded with a "
                            "snap length of %" PRIu32 " bytes; record whole "
                            "packets (tcpdump -s 0)",
                            counters->cut_short, r->held_max);
    }
    return true;
}

/* What is wrapped and not of a G2 is in many captures: it matters where nothing
 * else is there. */
static bool matters(const lum_remarks *r, size_t i)
{
    return r->wrapped[i].is == LUM_WRAPPED_OURS ||
           (r->port_count == 0 && r->wrapped_count == 1);
}

static bool say_wrapping(const lum_remarks *r, size_t i, lum_error *out)
{
    char name[LUM_WRAPPING_TEXT_BYTES];
    char remedy[LUM_WRAPPING_TEXT_BYTES];
    const bool is_ours = r->wrapped[i].is == LUM_WRAPPED_OURS;
    (void)lum_error_set(out,
                        "%" PRIu64 " packet%s%s wrapped in %s, which is not "
                        "read%s: %s",
                        r->wrapped[i].count,
                        r->wrapped[i].count == 1 ? "" : "s",
                        is_ours ? " of a G2 came" : " came",
                        lum_wrapping_name(&r->wrapped[i].what, name),
                        is_ours ? "" : "; if packets of a G2 are inside",
                        lum_wrapping_remedy(&r->wrapped[i].what, remedy));
    return true;
}

/* Fewer come of the network alone. */
static bool say_order(const lum_demux_counters *counters, lum_error *out)
{
    if (counters->out_of_order < OUT_OF_ORDER_MIN) {
        return false;
    }
    (void)lum_error_set(out,
                        "%" PRIu64
                        " packets stand out of order in the capture by "
                        "their times, too far to be put together: reordercap "
                        "IN OUT sorts a pcap or pcapng file",
                        counters->out_of_order);
    return true;
}

/* What shows that two sensors are taken for one: they disturb each other, or
 * both seem whole. */
static bool find_mixture(const lum_demux_counters *counters,
                         const lum_demux_mixture *mixture, lum_error *out)
{
    const uint64_t stray =
        counters->assembly.stray + counters->assembly.conflict;
    if (stray >= STRAY_MIN &&
        stray * STRAY_SHARE >= counters->packets[LUM_PACKET_DATA]) {
        (void)lum_error_set(out,
                            "%" PRIu64 " packets contradict others of their "
                            "sensor or are far from its clock",
                            stray);
        return true;
    }
    if (mixture->contradicting != 0) {
        (void)lum_error_set(out,
                            "two sensors seem to be taken for one, and frames "
                            "to have points of both: %" PRIu32 " of %" PRIu32
                            " packets that were looked at do not fit to those "
                            "next to them in time",
                            mixture->contradicting, mixture->compared);
        return true;
    }
    return false;
}

static bool say_mixture(const lum_demux_counters *counters,
                        const lum_demux_mixture *mixture, lum_error *out)
{
    lum_error what;
    if (!find_mixture(counters, mixture, &what)) {
        return false;
    }
    (void)lum_error_set(out,
                        "%s. If two sensors have one address, record each on "
                        "an interface of its own, not on \"any\", into one "
                        "pcapng file: dumpcap -i eth0 -i eth1 -w out. If each "
                        "packet is there twice, editcap -w 1 IN OUT drops the "
                        "copies",
                        what.text);
    return true;
}

bool lum_remarks_get(const lum_remarks *remarks,
                     const lum_demux_counters *counters,
                     const lum_demux_mixture *mixture, uint16_t port, size_t i,
                     lum_error *out)
{
    size_t n = i;
    if (say_order(counters, out) && n-- == 0) {
        return true;
    }
    if (remarks == NULL) {
        return false;
    }
    if (say_mixture(counters, mixture, out) && n-- == 0) {
        return true;
    }
    if (say_port(remarks, port, out) && n-- == 0) {
        return true;
    }
    if (say_cut(remarks, counters, out) && n-- == 0) {
        return true;
    }
    for (size_t k = 0; k < remarks->wrapped_count; k++) {
        if (matters(remarks, k) && n-- == 0) {
            return say_wrapping(remarks, k, out);
        }
    }
    return false;
}
