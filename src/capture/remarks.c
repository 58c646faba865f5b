#include "remarks.h"

#include "base/text.h"
#include "demux_sensors.h"
#include "link.h"
#include "lum/wire.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define OUT_OF_ORDER_MIN 3u

/* From so many on, and one of so many packets of data. */
#define STRAY_MIN   16u
#define STRAY_SHARE 16u

/* --- Looking --- */

static void note_hidden(lum_remarks *r, uint32_t link_type, size_t at)
{
    size_t i = 0;
    while (i < r->hidden_count &&
           (r->hidden[i].link_type != link_type || r->hidden[i].at != at)) {
        i++;
    }
    if (i == LUM_REMARKS_HIDDEN) {
        return;
    }
    if (i == r->hidden_count) {
        r->hidden[i].link_type = link_type;
        r->hidden[i].at = at;
        r->hidden_count++;
    }
    r->hidden[i].count++;
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
    uint8_t type = 0;
    if (from->len < from->whole && from->len > remarks->held_max) {
        remarks->held_max = from->len;
    }
    if (is_of_a_g2(out, &type)) {
        if (may_be_data(out, type)) {
            note_way(remarks, out->source_port, out->destination_port);
        }
    } else if (out->kind != LUM_RECORD_FRAGMENT) {
        const size_t at = lum_link_find_hidden(
            from->link_type, (lum_span){from->bytes, from->len});
        if (at != 0) {
            note_hidden(remarks, from->link_type, at);
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
    (void)lum_error_set(
        out,
        "%" PRIu64 " packet%s of a G2 came from UDP port %u%s, but only port "
        "%u is read: a device on the way has changed the port "
        "(NAT); read %s with lumdump --port %u, --sensor-port %u of "
        "lumview and lumsim, port=%u in Python and ROS",
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

static bool say_hidden(const lum_remarks *r, size_t i, lum_error *out)
{
    char fix[LUM_LINK_FIX_BYTES];
    if (i >= r->hidden_count) {
        return false;
    }
    const uint64_t count = r->hidden[i].count;
    (void)lum_error_set(
        out,
        "%" PRIu64 " packet%s of a G2 came wrapped in %zu bytes of other "
        "headers, such as a tunnel's, which are not read: %s%s",
        count, count == 1 ? "" : "s", r->hidden[i].at,
        lum_link_fix(r->hidden[i].link_type, r->hidden[i].at, fix),
        r->way_count != 0 || r->hidden_count > 1
            ? ", but from these packets alone, since others of a G2 are not "
              "wrapped in it: first put these into a file of their own "
              "(tshark -r IN -Y FILTER -w OUT)"
            : "");
    return true;
}

/* Fewer come of the network alone. */
static bool say_order(const lum_demux_counters *counters, lum_error *out)
{
    if (counters->out_of_order < OUT_OF_ORDER_MIN) {
        return false;
    }
    (void)lum_error_set(
        out,
        "%" PRIu64 " packets are too far out of order in the capture to be put "
        "together: reordercap IN OUT sorts a pcap or pcapng file",
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
        (void)lum_error_set(
            out,
            "two sensors seem to be read as one, so that frames have points of "
            "both: %" PRIu32 " of %" PRIu32
            " packets examined do not fit their neighbours in time",
            mixture->contradicting, mixture->compared);
        return true;
    }
    if (counters->out_of_order < OUT_OF_ORDER_MIN &&
        is_much(counters->assembly.late, counters)) {
        (void)lum_error_set(
            out,
            "%" PRIu64
            " packets came after newer lines of their sensor and are not used",
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

/* --- Members that are not there --- */

/* Adds a name: its address, and its interface if that is known. */
static void add_name(lum_error *out, const char *before, uint32_t a,
                     const char *interface)
{
    lum_text_add(out->text, sizeof out->text, "%s%u.%u.%u.%u%s%s", before,
                 (unsigned)(a >> 24), (unsigned)(a >> 16 & 255u),
                 (unsigned)(a >> 8 & 255u), (unsigned)(a & 255u),
                 *interface != '\0' ? "%" : "", interface);
}

/* The entry of a member whose data is another sensor's too; NULL: none. */
static const lum_demux_entry *find_copy(const lum_demux *demux,
                                        const lum_demux_known *member)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        const lum_demux_entry *entry = &demux->addresses[i];
        if (entry->address == member->address && entry->sensor != NULL &&
            entry->sensor != entry &&
            strcmp(entry->interface, member->interface) == 0) {
            return entry;
        }
    }
    return NULL;
}

/* Adds the i-th sensor; its interface if it is asked for, or where its address
 * is not enough. */
static void add_sensor(lum_error *out, const char *before,
                       const lum_demux *demux, size_t i, bool has_interface)
{
    const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
    const bool is_full = has_interface || lum_demux_is_shared(demux, i);
    add_name(out, before, sensor->address, is_full ? sensor->interface : "");
}

static void add_sensors(const lum_demux *demux, bool has_interface,
                        lum_error *out)
{
    if (demux->sensor_count == 0) {
        lum_text_add(out->text, sizeof out->text, "no sensor did");
        return;
    }
    for (size_t i = 0; i < demux->sensor_count; i++) {
        add_sensor(out, i == 0 ? "these did: " : ", ", demux, i, has_interface);
    }
}

static void say_absent(const lum_demux *demux, const lum_demux_known *member,
                       lum_error *out)
{
    const lum_demux_entry *copy = find_copy(demux, member);
    const lum_demux_entry *other =
        lum_demux_find_sensor(demux, member->address);
    out->text[0] = '\0';
    add_name(out, "the rig's sensor ", member->address, member->interface);
    if (copy != NULL) {
        add_name(out, " is not another sensor: its data duplicates that of ",
                 copy->sensor->address, copy->sensor->interface);
        lum_text_add(out->text, sizeof out->text,
                     "; leave one of them out of the rig");
        return;
    }
    lum_text_add(out->text, sizeof out->text, " sent no data; ");
    if (other == NULL || *other->interface != '\0') {
        add_sensors(demux, *member->interface != '\0', out);
    } else {
        add_name(out, "", other->address, "");
        lum_text_add(out->text, sizeof out->text,
                     " did, on an unknown interface: record with dumpcap -i "
                     "eth0 -i eth1 -w out, whose pcapng files name them, or "
                     "leave the interface out of the rig");
    }
}

/* --- Sensors that no member names --- */

static bool say_unnamed(const lum_demux *demux, lum_error *out)
{
    size_t count = 0;
    lum_error names = {""};
    for (size_t i = 0; i < demux->sensor_count; i++) {
        if (lum_demux_member_of(demux, i) == LUM_DEMUX_NO_MEMBER) {
            add_sensor(&names, count++ == 0 ? "" : ", ", demux, i, false);
        }
    }
    if (count != 0) {
        (void)lum_error_set(out,
                            "%zu sensor%s sent data and %s not in the rig, so "
                            "%s left out; to have %s, name in the rig: %.300s",
                            count, count == 1 ? "" : "s",
                            count == 1 ? "is" : "are",
                            count == 1 ? "it was" : "they were",
                            count == 1 ? "it" : "them", names.text);
    }
    return count != 0;
}

/* The n-th remark on them; n becomes less by those that there are. */
static bool say_members(const lum_demux *demux, size_t *n, lum_error *out)
{
    const lum_demux_members *members = &demux->members;
    if (members->count == 0 || demux->options.has_sensor) {
        return false;
    }
    for (size_t i = 0; i < members->count; i++) {
        if (lum_demux_members_want(members, (int)i) &&
            !members->of[i].is_there && (*n)-- == 0) {
            say_absent(demux, &members->of[i], out);
            return true;
        }
    }
    return say_unnamed(demux, out) && (*n)-- == 0;
}

/* --- All of them --- */

/* Whether it has the address that was requested, without an interface, and
 * another one with it was taken. */
static bool is_left_out(const lum_demux *demux, size_t i)
{
    const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
    return demux->options.has_sensor && !lum_demux_is_requested(demux, i) &&
           lum_demux_find_member(&demux->members, sensor->address, "", false) !=
               LUM_DEMUX_NO_MEMBER;
}

/* The n-th sensor too many of the address that was asked for. */
static bool say_shared(const lum_demux *demux, size_t *n, lum_error *out)
{
    const size_t count = demux != NULL ? lum_demux_sensor_count(demux) : 0;
    char name[LUM_SENSOR_NAME_BYTES];
    for (size_t k = 0; k < count; k++) {
        if (is_left_out(demux, k) && (*n)-- == 0) {
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
        port = demux->options.port;
    }
    if ((demux != NULL && say_members(demux, &n, out)) ||
        say_shared(demux, &n, out) || (say_order(counters, out) && n-- == 0)) {
        return true;
    }
    return remarks != NULL &&
           ((say_mixture(counters, &mixture, out) && n-- == 0) ||
            (say_port(remarks, port != 0 ? port : LUM_PORT, out) && n-- == 0) ||
            (say_cut(remarks, counters, out) && n-- == 0) ||
            say_hidden(remarks, n, out));
}
