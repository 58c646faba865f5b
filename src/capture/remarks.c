#include "remarks.h"

#include "demux_state.h"
#include "lum/wire.h"
#include "remarks_members.h"

#include <inttypes.h>
#include <stdio.h>
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

/* A sensor's data goes to the port of whoever asked last, so from one port it
 * may go to many. */
static void note_way(lum_remarks *r, uint16_t from, uint16_t to)
{
    size_t i = 0;
    size_t of = 0;
    while (i < r->way_count &&
           !(r->ways[i].from == from &&
             (r->ways[i].to == to || (r->ways[i].to == 0 && to != LUM_PORT)))) {
        of += r->ways[i].from == from;
        i++;
    }
    if (i == LUM_REMARKS_WAYS) {
        return;
    }
    if (i == r->way_count) {
        r->ways[i].from = from;
        r->ways[i].to = of < LUM_REMARKS_WAYS_OF || to == LUM_PORT ? to : 0;
        r->way_count++;
    }
    r->ways[i].count++;
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
            note_way(remarks, out->source_port, out->destination_port);
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

/* Packets that came from a port and, like their sender's port, were not to the
 * one that is read. from 0: from any. */
static uint64_t count_unread(const lum_remarks *r, uint16_t from, uint16_t port)
{
    uint64_t count = 0;
    for (size_t i = 0; i < r->way_count; i++) {
        const bool is_read = r->ways[i].from == port || r->ways[i].to == port;
        const bool is_meant = from == 0 || r->ways[i].from == from;
        count += !is_read && is_meant ? r->ways[i].count : 0;
    }
    return count;
}

/* Data is sent from the sensor's port, to any. */
static bool say_port(const lum_remarks *r, uint16_t port, lum_error *out)
{
    uint64_t most = 0;
    unsigned other = 0;
    char rest[48] = "";
    for (size_t i = 0; i < r->way_count; i++) {
        const uint64_t count = count_unread(r, r->ways[i].from, port);
        other = count > most ? r->ways[i].from : other;
        most = count > most ? count : most;
    }
    if (most == 0) {
        return false;
    }
    const uint64_t more = count_unread(r, 0, port) - most;
    if (more != 0) {
        (void)snprintf(rest, sizeof rest, ", and %" PRIu64 " from others",
                       more);
    }
    (void)lum_error_set(out,
                        "%" PRIu64 " packet%s of a G2 came from UDP port %u%s, "
                        "but only port %u is read: something between has "
                        "changed the port (NAT); read %s with lumdump --port "
                        "%u, --sensor-port %u of lumview and lumsim, port=%u "
                        "in Python and ROS",
                        most, most == 1 ? "" : "s", other, rest, (unsigned)port,
                        most == 1 ? "it" : "them", other, other, other);
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
           (r->way_count == 0 && r->wrapped_count == 1);
}

/* Whether packets of a G2 are there that stand in something else, or plain. */
static bool has_others(const lum_remarks *r, size_t i)
{
    bool has = r->way_count != 0;
    for (size_t k = 0; k < r->wrapped_count; k++) {
        has |= k != i && r->wrapped[k].is == LUM_WRAPPED_OURS;
    }
    return has;
}

static bool say_wrapping(const lum_remarks *r, size_t i, lum_error *out)
{
    char name[LUM_WRAPPING_TEXT_BYTES];
    char remedy[LUM_WRAPPING_TEXT_BYTES];
    const bool is_ours = r->wrapped[i].is == LUM_WRAPPED_OURS;
    (void)lum_error_set(out,
                        "%" PRIu64 " packet%s%s wrapped in %s, which is not "
                        "read%s: %s%s",
                        r->wrapped[i].count,
                        r->wrapped[i].count == 1 ? "" : "s",
                        is_ours ? " of a G2 came" : " came",
                        lum_wrapping_name(&r->wrapped[i].what, name),
                        is_ours ? "" : "; if packets of a G2 are inside",
                        lum_wrapping_remedy(&r->wrapped[i].what, remedy),
                        has_others(r, i) && !r->wrapped[i].what.has_no_cut
                            ? ", but from these packets alone, since others of "
                              "a G2 are not wrapped in it: first put these "
                              "into a file of their own (tshark -r IN -Y "
                              "FILTER -w OUT)"
                            : "");
    return true;
}

static bool say_wrappings(const lum_remarks *r, size_t n, lum_error *out)
{
    for (size_t k = 0; k < r->wrapped_count; k++) {
        if (matters(r, k) && n-- == 0) {
            return say_wrapping(r, k, out);
        }
    }
    return false;
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

static bool is_much(uint64_t n, const lum_demux_counters *counters)
{
    return n >= STRAY_MIN &&
           n * STRAY_SHARE >= counters->packets[LUM_PACKET_DATA];
}

/* What shows that two sensors are taken for one: they disturb each other, or
 * both seem whole, or the second one's data is late. */
static bool find_mixture(const lum_demux_counters *counters,
                         const lum_demux_mixture *mixture, lum_error *out)
{
    const uint64_t stray =
        counters->assembly.stray + counters->assembly.conflict;
    if (is_much(stray, counters)) {
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
    if (counters->out_of_order < OUT_OF_ORDER_MIN &&
        is_much(counters->assembly.late, counters)) {
        (void)lum_error_set(out,
                            "%" PRIu64 " packets are late, behind newer lines "
                            "of their sensor, and are not used",
                            counters->assembly.late);
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
                        "copies; if the layout may be another one, lumdump "
                        "--infer finds it",
                        what.text);
    return true;
}

/* The n-th sensor too many of the address that was asked for. */
static bool say_shared(const lum_demux *demux, size_t *n, lum_error *out)
{
    const size_t count = demux != NULL ? lum_demux_sensor_count(demux) : 0;
    char name[LUM_SENSOR_NAME_BYTES];
    for (size_t k = 0; k < count; k++) {
        if (lum_demux_leaves_out(demux, k) && (*n)-- == 0) {
            (void)lum_error_set(out,
                                "several sensors have this address, and the "
                                "first one was taken: name the other as %s "
                                "(--sensor; sensor in Python and ROS)",
                                lum_demux_name(demux, k, name));
            return true;
        }
    }
    return false;
}

bool lum_remarks_get(const lum_remarks *remarks, const lum_demux *demux,
                     uint16_t port, size_t i, lum_error *out)
{
    size_t n = i;
    lum_demux_counters total = {.struct_size = sizeof total};
    const lum_demux_counters *counters = &total;
    lum_demux_mixture mixture = {.compared = 0};
    if (demux != NULL) {
        (void)lum_demux_total(demux, &total);
        mixture = lum_demux_mixed(demux);
        port = lum_demux_port(demux);
    }
    if ((demux != NULL && lum_remarks_say_members(demux, &n, out)) ||
        say_shared(demux, &n, out) || (say_order(counters, out) && n-- == 0)) {
        return true;
    }
    return remarks != NULL &&
           ((say_mixture(counters, &mixture, out) && n-- == 0) ||
            (say_port(remarks, port != 0 ? port : LUM_PORT, out) && n-- == 0) ||
            (say_cut(remarks, counters, out) && n-- == 0) ||
            say_wrappings(remarks, n, out));
}
