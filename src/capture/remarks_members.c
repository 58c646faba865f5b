#include "remarks_members.h"
#include "demux_sensors.h"

/* --- Members that are not there --- */

/* Adds a name: its address, and its interface if that is known. */
static void add_name(lum_error *out, const char *before, uint32_t a,
                     const char *interface)
{
    const size_t used = strlen(out->text);
    (void)snprintf(out->text + used, sizeof out->text - used,
                   "%s%u.%u.%u.%u%s%s", before, (unsigned)(a >> 24),
                   (unsigned)(a >> 16 & 255u), (unsigned)(a >> 8 & 255u),
                   (unsigned)(a & 255u), *interface != '\0' ? "%" : "",
                   interface);
}

static void add_text(lum_error *out, const char *text)
{
    const size_t used = strlen(out->text);
    (void)snprintf(out->text + used, sizeof out->text - used, "%s", text);
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
        add_text(out, "no sensor did");
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
        add_name(out, " is no sensor of its own: its data is that of ",
                 copy->sensor->address, copy->sensor->interface);
        add_text(out, " once more; leave one of them out of the rig");
        return;
    }
    add_text(out, " sent no data; ");
    if (other == NULL || *other->interface != '\0') {
        add_sensors(demux, *member->interface != '\0', out);
    } else {
        add_name(out, "", other->address, "");
        add_text(out, " did, but on which interface is not known: record with "
                      "dumpcap -i eth0 -i eth1 -w out, whose pcapng files name "
                      "them, or leave the interface out of the rig");
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

bool lum_remarks_say_members(const lum_demux *demux, size_t *n, lum_error *out)
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
