/* Records to the assembler of their sensor, and events of assemblers back. */
#include "lum/capture/demux.h"

#include "base/sized.h"
#include "demux_interfaces.h"
#include "demux_sensors.h"
#include "lum/wire.h"

#include <stdlib.h>

/* --- Making and freeing --- */

int lum_demux_new(const lum_demux_options *options, lum_demux **out,
                  lum_error *error)
{
    lum_demux_options known;
    *out = NULL;
    if (lum_sized_take(&known, sizeof known, options,
                       "the demultiplexer's options", "lum_demux_options",
                       error) != 0) {
        return -1;
    }
    lum_demux *demux = calloc(1, sizeof *demux);
    if (demux == NULL) {
        return lum_error_set(error, "out of memory");
    }
    known.port = known.port != 0 ? known.port : (uint16_t)LUM_PORT;
    demux->options = known;
    demux->options.sensor_interface = NULL; /* of the caller, both */
    demux->options.members = NULL;
    if (lum_demux_take_members(&demux->members, &known, error) != 0) {
        free(demux);
        return -1;
    }
    *out = demux;
    return 0;
}

void lum_demux_free(lum_demux *demux)
{
    if (demux == NULL) {
        return;
    }
    lum_demux_clear(demux);
    free(demux);
}

void lum_demux_watch(lum_demux *demux, lum_demux_watcher watcher, void *context)
{
    demux->watch = (lum_demux_watch_state){watcher, context};
}

/* --- What a record is --- */

static bool is_ours(const lum_demux *demux, const lum_record *record)
{
    return record->source_port == demux->options.port ||
           record->destination_port == demux->options.port;
}

/* The address on the side of the sensors' port; the sender's when both are. */
static uint32_t sensor_side(const lum_demux *demux, const lum_record *record)
{
    return record->source_port == demux->options.port ? record->source
                                                      : record->destination;
}

/* A datagram that was cut before its ports may be ours. */
static void count_cut_short(lum_demux *demux, const lum_record *record)
{
    const bool has_ports =
        record->source_port != 0 || record->destination_port != 0;
    if (is_ours(demux, record)) {
        demux->last = lum_demux_find_address(demux, sensor_side(demux, record));
        demux->last->counters.cut_short++;
    } else if (has_ports) {
        demux->other++;
    } else {
        demux->addresses[LUM_DEMUX_ADDRESSES_MAX].counters.cut_short++;
    }
}

static lum_result refuse_data(lum_demux *demux)
{
    demux->other++;
    demux->packet.kind = LUM_PACKET_KINDS;
    return LUM_OK;
}

/* Of a sensor that is known. */
static lum_result take_known(lum_demux *demux, const lum_record *record,
                             lum_demux_entry *entry)
{
    lum_demux_entry *sensor = entry->sensor;
    const bool is_held =
        demux->trials.open > 0 && lum_demux_meet_trials(demux, record, sensor);
    if (is_held && !lum_demux_enqueue(demux, record, entry)) {
        return LUM_E_SPACE;
    }
    lum_demux_note_sent(demux, sensor, record);
    const lum_result r =
        is_held ? LUM_OK : lum_demux_give(demux, entry, record->time_ns);
    if (r == LUM_OK && lum_demux_takes(demux, sensor)) {
        lum_demux_count_data(demux, record, &entry->counters);
    }
    return r;
}

static lum_result take_data(lum_demux *demux, const lum_record *record,
                            lum_demux_entry *entry)
{
    if (entry == &demux->addresses[LUM_DEMUX_ADDRESSES_MAX] ||
        (entry->sensor == NULL && entry->origin != 0)) { /* one too many */
        return refuse_data(demux);
    }
    const bool is_doubted = lum_demux_is_doubtful(demux, entry);
    if (!is_doubted && entry->sensor == NULL &&
        !lum_demux_admit_sensor(demux, entry)) {
        return refuse_data(demux);
    }
    const lum_result r = is_doubted ? lum_demux_try(demux, record, entry)
                                    : take_known(demux, record, entry);
    if (demux->trials.open > 0 && demux->trials.queue != NULL) {
        lum_demux_judge_trials(demux, record->time_ns,
                               lum_queue_is_full(demux->trials.queue));
    }
    return r;
}

static lum_result count_datagram(lum_demux *demux, const lum_record *record)
{
    const uint32_t address = sensor_side(demux, record);
    lum_demux_entry *entry = lum_demux_find_address(demux, address);
    const lum_layout *layout =
        entry->layout != NULL ? entry->layout : &demux->options.layout;
    demux->packet.len = record->len;
    demux->packet.kind = lum_packet_decode(layout, record->payload, record->len,
                                           &demux->packet.group);
    if (demux->packet.kind != LUM_PACKET_DATA) {
        lum_demux_count_packet(demux, record, &entry->counters);
        demux->last = entry;
        return LUM_OK;
    }
    if (entry == &demux->addresses[LUM_DEMUX_ADDRESSES_MAX]) {
        entry = lum_demux_claim_address(demux, address);
    }
    demux->last = entry;
    return take_data(demux, record, entry);
}

/* Counts one datagram, or another record. Data is pending then, or held. */
static lum_result count_record(lum_demux *demux, const lum_record *record)
{
    demux->packet.kind = LUM_PACKET_KINDS;
    demux->last = NULL;
    demux->other += record->dropped_fragments;
    switch (record->kind) {
    case LUM_RECORD_FRAGMENT:
        return LUM_OK;
    case LUM_RECORD_CUT_SHORT:
        count_cut_short(demux, record);
        return LUM_OK;
    case LUM_RECORD_DATAGRAM:
    case LUM_RECORD_JOINED:
        if (is_ours(demux, record)) {
            return count_datagram(demux, record);
        }
        break;
    case LUM_RECORD_OTHER:
    default:
        break;
    }
    demux->other++;
    return LUM_OK;
}

/* --- Events --- */

static void tell(const lum_demux *demux, lum_result result)
{
    const lum_demux_taken packet = {.result = result,
                                    .sensor = demux->current->sensor_index,
                                    .assembler =
                                        &demux->current->assembly->assembler,
                                    .layout = demux->current->layout,
                                    .group = &demux->packet.group,
                                    .len = demux->packet.len,
                                    .time_ns = demux->packet.time_ns};
    demux->watch.watcher(demux->watch.context, &packet);
}

/* What waits for an assembler: the datagram at hand, or all that was held. */
static lum_result assemble(lum_demux *demux)
{
    while (true) {
        if (!demux->packet.is_pending && demux->trials.open == 0 &&
            demux->trials.queue != NULL && demux->trials.queue->count > 0) {
            const lum_result r = lum_demux_give_held(demux);
            if (r < 0) {
                return r;
            }
        }
        if (!demux->packet.is_pending) {
            return LUM_OK;
        }
        lum_assembler *assembler = &demux->current->assembly->assembler;
        const lum_result r = lum_assembler_push(assembler, &demux->packet.group,
                                                demux->packet.time_ns);
        demux->packet.is_pending = r > 0;
        if (r > 0) {
            return r;
        }
        if (demux->watch.watcher != NULL) {
            tell(demux, r);
        }
        lum_demux_judge_order(demux);
    }
}

static void drop_record(lum_demux *demux)
{
    demux->packet.is_pending = false;
    demux->joined = (lum_joined){.each = 0};
}

lum_result lum_demux_push(lum_demux *demux, const lum_record *record,
                          lum_packet_kind *kind)
{
    lum_record one;
    demux->trials.has_given =
        demux->trials.has_given && demux->joined.each != 0;
    if (demux->options.records_are_single && demux->joined.each == 0) {
        demux->joined.each = record->len; /* it is not several */
    }
    lum_result r = assemble(demux);
    while (r == LUM_OK && lum_joined_next(&demux->joined, record, &one)) {
        r = count_record(demux, &one);
        if (kind != NULL) {
            *kind = demux->packet.kind;
        }
        if (r < 0) {
            drop_record(demux);
            return r;
        }
        r = assemble(demux);
    }
    return r;
}

/* Trials end with what there is. */
static void begin_flush(lum_demux *demux)
{
    drop_record(demux);
    demux->is_flushing = true;
    lum_demux_judge_trials(demux, 0, true);
}

lum_result lum_demux_flush(lum_demux *demux)
{
    if (!demux->is_flushing) {
        begin_flush(demux);
    }
    const lum_result held = assemble(demux);
    if (held != LUM_OK) {
        return held;
    }
    for (; demux->flushing < demux->sensor_count; demux->flushing++) {
        demux->current = lum_demux_sensor_at(demux, demux->flushing);
        if (demux->current->assembly != NULL) {
            const lum_result r =
                lum_assembler_flush(&demux->current->assembly->assembler);
            if (r > 0) {
                return r;
            }
        }
    }
    demux->flushing = 0;
    demux->is_flushing = false;
    return LUM_OK;
}
