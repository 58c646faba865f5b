#include "rig_report.h"

#include "../common/number.h"

#include "base/text.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

/* --- Who is who --- */

const char *rig_name_of(const struct rig *rig, const lum_framer *framer,
                        size_t i)
{
    const int member = rig->is_live ? 0 : lum_framer_member(framer, i);
    return member >= 0 ? rig->sensors[member].of->name : NULL;
}

bool rig_has_data(const struct rig *rig, const lum_framer *framer, size_t k)
{
    const size_t n = lum_demux_sensor_count(lum_framer_demux(framer));
    bool has = false;
    for (size_t i = 0; i < n; i++) {
        has |= rig_member_of(rig, framer, i) == (int)k;
    }
    return has;
}

bool rig_has_any_data(const struct rig *rig, const lum_framer *framer)
{
    bool has = false;
    for (size_t k = 0; k < rig->count; k++) {
        has |= rig_has_data(rig, framer, k);
    }
    return has;
}

/* --- What is said --- */

static void add_sensors(char out[RIG_TEXT_BYTES], const lum_demux *demux)
{
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        char name[LUM_SENSOR_NAME_BYTES];
        lum_text_add(out, RIG_TEXT_BYTES, "%s%s", i > 0 ? ", " : "",
                     lum_demux_name(demux, i, name));
    }
}

bool rig_tell_missing(const struct rig *rig, const lum_framer *framer,
                      char out[RIG_TEXT_BYTES])
{
    const lum_demux *demux = lum_framer_demux(framer);
    size_t missing = 0;
    (void)snprintf(out, RIG_TEXT_BYTES, "no data of ");
    for (size_t k = 0; k < rig->count; k++) {
        const lum_rig_sensor *of = rig->sensors[k].of;
        if (!rig_has_data(rig, framer, k)) {
            lum_text_add(out, RIG_TEXT_BYTES, "%s%s (%s%s%s)",
                         missing > 0 ? ", " : "", of->name,
                         number_address(of->address).text,
                         of->interface[0] != '\0' ? "%" : "", of->interface);
            missing++;
        }
    }
    lum_text_add(out, RIG_TEXT_BYTES,
                 " in it, which %s names; there is data of ", rig->path);
    add_sensors(out, demux);
    if (lum_demux_sensor_count(demux) == 0) {
        lum_text_add(out, RIG_TEXT_BYTES, "no sensor");
    }
    return missing > 0;
}

const char *rig_line_for(const lum_framer *framer, size_t i,
                         char out[RIG_TEXT_BYTES])
{
    const lum_demux *demux = lum_framer_demux(framer);
    const char *interface = lum_demux_interface(demux, i);
    const bool is_shared = lum_demux_is_shared(demux, i) && interface != NULL;
    (void)snprintf(
        out, RIG_TEXT_BYTES, "  - {name: sensor%zu, address: %s%s%s}", i + 1u,
        number_address(lum_demux_address(demux, i)).text,
        is_shared ? ", interface: " : "", is_shared ? interface : "");
    return out;
}

/* --- Packets of others --- */

static struct rig_other *find(struct rig_others *others, uint32_t address,
                              const char *interface)
{
    for (size_t i = 0; i < others->count; i++) {
        struct rig_other *o = &others->list[i];
        if (o->address == address && strcmp(o->interface, interface) == 0) {
            return o;
        }
    }
    if (others->count == LUM_DEMUX_SENSORS_MAX) {
        return NULL;
    }
    struct rig_other *added = &others->list[others->count++];
    added->address = address;
    (void)snprintf(added->interface, sizeof added->interface, "%s", interface);
    return added;
}

void rig_others_note(struct rig_others *others, const struct options *options,
                     const lum_demux *demux, const lum_record *record,
                     const char *interface)
{
    const uint16_t port =
        options->sensor.port != 0 ? options->sensor.port : LUM_PORT;
    if (record->kind != LUM_RECORD_DATAGRAM || record->source_port != port ||
        rig_member(options->rig, demux, record, interface) >= 0) {
        return;
    }
    struct rig_other *other =
        find(others, record->source, interface != NULL ? interface : "");
    if (other != NULL) {
        other->packets++;
    }
}

uint64_t rig_others_packets(const struct rig_others *others,
                            const lum_framer *framer, size_t i)
{
    const lum_demux *demux = lum_framer_demux(framer);
    const char *interface = lum_demux_interface(demux, i);
    const char *its = interface != NULL ? interface : "";
    uint64_t packets = 0;
    for (size_t k = 0; k < others->count; k++) {
        const struct rig_other *o = &others->list[k];
        if (o->address == lum_demux_address(demux, i) &&
            strcmp(o->interface, its) == 0) {
            packets += o->packets;
        }
    }
    return packets;
}
