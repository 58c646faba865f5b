#include "demux_state.h"

#include "demux_sensors.h"

void lum_demux_pack_options(const lum_demux *demux, lum_pack *pack)
{
    lum_demux_options o = demux->options;
    char interface[LUM_INTERFACE_BYTES] = "";
    lum_demux_pack_profile(o.layout.profile, pack);
    lum_pack_u8(pack, &o.config.open_lines);
    lum_pack_u8(pack, &o.config.reorder_lines);
    lum_pack_u32(pack, &o.config.words_per_line);
    lum_pack_u32(pack, &o.config.gap_us);
    lum_pack_bool(pack, &o.has_sensor);
    lum_pack_u32(pack, &o.sensor);
    uint32_t port = o.port;
    lum_pack_u32(pack, &port);
    if (o.has_sensor) {
        memcpy(interface, demux->members.of[0].interface, sizeof interface);
    }
    lum_pack_text(pack, interface, sizeof interface);
    if (!o.has_sensor) {
        lum_demux_pack_members(&demux->members, pack);
    }
}

void lum_demux_restart(lum_demux *demux)
{
    const lum_demux_options options = demux->options;
    const lum_demux_members members = demux->members;
    const lum_demux_watch_state watch = demux->watch;
    lum_demux_clear(demux);
    memset(demux, 0, sizeof *demux);
    demux->options = options;
    demux->members = members;
    demux->watch = watch;
    for (size_t i = 0; i < members.count; i++) {
        demux->members.of[i].is_there = false;
    }
    demux->current = demux->addresses;
}

void lum_demux_admit(lum_demux *demux, const lum_demux_origin *origin)
{
    lum_demux_set_interface(demux, origin->interface);
    lum_demux_entry *entry = lum_demux_find_address(demux, origin->address);
    if (entry->origin != 0) {
        return;
    }
    if (origin->sensor == demux->sensor_count) {
        (void)lum_demux_admit_sensor(demux, entry);
    } else {
        lum_demux_set_sensor(demux, entry,
                             origin->sensor < demux->sensor_count
                                 ? lum_demux_sensor_at(demux, origin->sensor)
                                 : NULL);
    }
}

size_t lum_demux_origin_count(const lum_demux *demux)
{
    return demux->origin_count;
}

lum_demux_origin lum_demux_origin_at(const lum_demux *demux, size_t i)
{
    const lum_demux_entry *entry = demux->addresses;
    while (entry->origin != i + 1u) {
        entry++;
    }
    lum_demux_origin origin = {
        .address = entry->address,
        .sensor = entry->sensor != NULL ? (uint32_t)entry->sensor->sensor_index
                                        : LUM_DEMUX_SENSORS_MAX,
        .since = entry->since};
    lum_demux_set_text(origin.interface, entry->interface);
    return origin;
}

void lum_demux_set_record(lum_demux *demux, uint64_t number)
{
    demux->record = number;
}

void lum_demux_interrupt(lum_demux *demux)
{
    for (size_t i = 0; i < demux->sensor_count; i++) {
        lum_recent *recent = lum_demux_sensor_at(demux, i)->recent;
        if (recent != NULL) {
            lum_recent_interrupt(recent);
        }
    }
}

bool lum_demux_is_unsure(const lum_demux *demux)
{
    return demux->trials.is_unsure;
}

bool lum_demux_is_behind(const lum_demux *demux)
{
    return demux->trials.open > 0 || demux->trials.has_given;
}

void lum_demux_hold(lum_demux *demux, size_t sensor, bool is_held)
{
    const uint32_t bit = UINT32_C(1) << sensor;
    demux->held = is_held ? demux->held | bit : demux->held & ~bit;
}

bool lum_demux_sender(const lum_demux *demux, size_t *sensor)
{
    const lum_demux_entry *entry =
        demux->last != NULL ? demux->last->sensor : NULL;
    if (entry == NULL || !lum_demux_takes(demux, entry)) {
        return false;
    }
    *sensor = entry->sensor_index;
    return true;
}

bool lum_demux_last(const lum_demux *demux, size_t *sensor)
{
    const lum_demux_entry *entry = demux->current;
    if (entry == NULL || entry->assembly == NULL) {
        return false;
    }
    *sensor = entry->sensor_index;
    return true;
}

bool lum_demux_newest(const lum_demux *demux, size_t sensor, uint32_t *frame)
{
    const lum_demux_entry *entry = lum_demux_sensor_at(demux, sensor);
    if (entry->assembly == NULL) {
        return false;
    }
    const lum_eye_state *eyes = entry->assembly->assembler.eye;
    const lum_eye_frames *blue = &eyes[LUM_EYE_BLUE].frames;
    const lum_eye_frames *green = &eyes[LUM_EYE_GREEN].frames;
    const bool is_blue =
        blue->begun &&
        (!green->begun || (blue->frame - green->frame) >> 31 == 0);
    *frame = is_blue ? blue->frame : green->frame;
    return blue->begun || green->begun;
}

bool lum_demux_pack_sensor(lum_demux *demux, size_t sensor, uint32_t from,
                           lum_pack *pack)
{
    lum_demux_entry *entry = lum_demux_sensor_at(demux, sensor);
    if (entry->assembly == NULL) {
        entry->assembly =
            lum_demux_new_assembly(&demux->options, entry->layout);
    }
    if (entry->assembly == NULL) {
        pack->has_failed = true;
        return false;
    }
    lum_pack_bool(pack, &entry->has_clock);
    lum_pack_u64(pack, &entry->clock);
    demux->current = lum_pack_is_reading(pack) ? entry : demux->current;
    return lum_assembler_pack(&entry->assembly->assembler, from, pack);
}
