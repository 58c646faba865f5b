/* Records to the assembler of their sensor, and events of assemblers back. */
#include "lum/capture/demux.h"

#include "base/sized.h"
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

/* --- What is on trial --- */

/* One address on several interfaces of a capture: data is held until it is
 * known whether it is of one sensor or of several (docs/protocol.md, section
 * 9). */

/* Where a sensor's interface has no name, only the first LOOK_PACKETS of each
 * LOOK_EVERY packets are remembered, to be compared with each other: there is
 * no other interface's data to be compared with. */
#define LOOK_PACKETS 5120u
#define LOOK_EVERY   65536u

/* To compare a packet with those next to it takes as long as tens of others. */
#define COMPARED_FROM 1024u /* before, too few are remembered */
#define RARELY        2048u /* one packet of these is compared, */
#define OFTEN         512u  /* and of these among the first LOOK_PACKETS */

/* The first sensor that an entry's data may be of; NULL: there is none. */
static lum_demux_entry *first_like(const lum_demux *demux,
                                   const lum_demux_entry *entry)
{
    for (size_t i = 0; i < demux->sensor_count; i++) {
        lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
        if (lum_demux_may_be(entry, sensor)) {
            return sensor;
        }
    }
    return NULL;
}

/* Whether its address has a sensor on another interface, and nothing says yet
 * whose data it brings. */
static bool is_doubtful(const lum_demux *demux, const lum_demux_entry *entry)
{
    return entry->sensor == NULL && *entry->interface != '\0' &&
           first_like(demux, entry) != NULL;
}

static void end_trial(lum_demux *demux, lum_demux_entry *entry,
                      lum_verdict verdict)
{
    free(entry->trial);
    entry->trial = NULL;
    demux->trials.open--;
    if (verdict == LUM_VERDICT_SAME) {
        lum_demux_set_sensor(demux, entry, entry->like);
    } else if (!lum_demux_admit_sensor(demux, entry)) {
        demux->other += entry->counters.packets[LUM_PACKET_DATA];
        entry->counters.packets[LUM_PACKET_DATA] = 0;
        entry->counters.angle_packets = 0;
        entry->counters.range_packets = 0;
        lum_demux_set_sensor(demux, entry, NULL);
    }
}

/* End the trials that have come to something; is_over: all. */
static void judge_trials(lum_demux *demux, int64_t now_ns, bool is_over)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        lum_demux_entry *entry = &demux->addresses[i];
        if (entry->trial != NULL) {
            const lum_measure measure = lum_demux_measure(demux, entry);
            const lum_verdict verdict =
                is_over ? lum_trial_settle(entry->trial, &measure)
                        : lum_trial_judge(entry->trial, &measure, now_ns);
            if (verdict != LUM_VERDICT_OPEN) {
                end_trial(demux, entry, verdict);
            }
        }
    }
}

/* Hold a packet until it is known whose it is.
 * Returns false without memory. */
static bool enqueue(lum_demux *demux, const lum_record *record,
                    lum_demux_entry *entry)
{
    if (demux->trials.queue == NULL) {
        demux->trials.queue = calloc(1, sizeof *demux->trials.queue);
    }
    entry->is_waiting = demux->trials.queue != NULL &&
                        lum_queue_add(demux->trials.queue, record,
                                      (size_t)(entry - demux->addresses));
    return entry->is_waiting;
}

/* The turn-th packet of LOOK_EVERY is remembered. */
static void look_at_sent(const lum_demux *demux, lum_demux_entry *sensor,
                         const lum_record *record, uint32_t turn)
{
    if (sensor->recent == NULL) {
        return;
    }
    if (turn == 0 && *sensor->interface == '\0') {
        lum_recent_interrupt(sensor->recent);
    }
    const lum_seen seen = lum_seen_of(record, &demux->packet.group);
    lum_recent_note(sensor->recent, &seen, record->time_ns, demux->record);
    if (turn >= COMPARED_FROM &&
        turn % (turn < LOOK_PACKETS ? OFTEN : RARELY) == 0) {
        const lum_measure measure = lum_demux_measure(demux, sensor);
        sensor->neighbours.compared++;
        sensor->neighbours.contradicting +=
            lum_recent_contradicts(sensor->recent, &measure);
    }
}

/* Remember a packet of a sensor. */
static void note_sent(const lum_demux *demux, lum_demux_entry *sensor,
                      const lum_record *record)
{
    const uint32_t turn = sensor->sent++ % LOOK_EVERY;
    if (turn < LOOK_PACKETS || *sensor->interface != '\0') {
        look_at_sent(demux, sensor, record, turn);
    }
}

/* Those on trial under a sensor's address meet its packet.
 * Returns whether it has to wait: others of its address do. */
static bool meet_trials(lum_demux *demux, const lum_record *record,
                        const lum_demux_entry *sensor)
{
    const lum_seen seen = lum_seen_of(record, &demux->packet.group);
    const lum_measure measure = lum_demux_measure(demux, sensor);
    bool waits = false;
    for (size_t i = 0; i < demux->address_count; i++) {
        lum_demux_entry *entry = &demux->addresses[i];
        if (entry->address == sensor->address) {
            waits |= entry->is_waiting;
        }
        if (entry->trial != NULL && lum_demux_may_be(entry, sensor)) {
            lum_trial_meet(entry->trial, &measure, &seen);
        }
    }
    return waits;
}

/* Where a packet stands among those of the sensors of its address; like becomes
 * the one that it stands best to. */
static lum_stand find_place(const lum_demux *demux, const lum_record *record,
                            const lum_seen *seen, lum_demux_entry *entry,
                            lum_place_among *out)
{
    const lum_measure measure = lum_demux_measure(demux, entry);
    lum_stand best = LUM_STAND_ELSEWHERE;
    *out = (lum_place_among){.stand = best};
    for (size_t i = 0; i < demux->sensor_count; i++) {
        lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
        if (sensor->recent != NULL && lum_demux_may_be(entry, sensor)) {
            const lum_place_among place = lum_recent_place(
                sensor->recent, &measure, seen, record->time_ns);
            const lum_stand stand = lum_place_stand(&place, &measure, seen);
            if (stand < best) {
                best = stand;
                entry->like = sensor;
                *out = place;
            }
        }
    }
    return best;
}

/* A trial looks at what the sensors of its address sent of late.
 * Returns whether all of that is there. */
static bool look_back(const lum_demux *demux, lum_demux_entry *entry)
{
    bool is_whole = true;
    entry->since = demux->record;
    for (size_t i = 0; i < demux->sensor_count; i++) {
        const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
        if (sensor->recent != NULL && lum_demux_may_be(entry, sensor)) {
            const uint64_t since = sensor->recent->since;
            entry->since = since < entry->since ? since : entry->since;
            is_whole &= lum_recent_is_whole(sensor->recent);
        }
    }
    return is_whole;
}

static bool begin_trial(lum_demux *demux, lum_demux_entry *entry)
{
    entry->like = first_like(demux, entry);
    entry->trial = calloc(1, sizeof *entry->trial);
    demux->trials.open += entry->trial != NULL;
    return entry->trial != NULL;
}

/* Data that is on trial.
 * Returns LUM_OK, or LUM_E_SPACE without memory. */
static lum_result try_data(lum_demux *demux, const lum_record *record,
                           lum_demux_entry *entry)
{
    if (entry->trial == NULL && !look_back(demux, entry)) {
        demux->trials.is_unsure = true;
        return LUM_OK;
    }
    if ((entry->trial == NULL && !begin_trial(demux, entry)) ||
        !enqueue(demux, record, entry)) {
        return LUM_E_SPACE;
    }
    const lum_seen seen = lum_seen_of(record, &demux->packet.group);
    lum_place_among place;
    demux->trials.stand = find_place(demux, record, &seen, entry, &place);
    lum_trial_add(entry->trial, &seen, &place, record->time_ns);
    lum_demux_count_data(demux, record, &entry->counters);
    return LUM_OK;
}

static void end_waiting(lum_demux *demux)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        demux->addresses[i].is_waiting = false;
    }
    lum_demux_free_queue(demux);
}

/* The next packet that was held becomes the one at hand.
 * Returns LUM_OK, or LUM_E_SPACE without memory: then it stays held. */
static lum_result give_held(lum_demux *demux)
{
    lum_record record;
    size_t way = 0;
    lum_result r = LUM_OK;
    while (!demux->packet.is_pending && r == LUM_OK &&
           lum_queue_take(demux->trials.queue, &record, &way)) {
        lum_demux_entry *entry = &demux->addresses[way];
        lum_demux_entry *sensor = entry->sensor;
        demux->packet.len = record.len;
        (void)lum_packet_decode(entry->layout, record.payload, record.len,
                                &demux->packet.group);
        demux->trials.has_given = true;
        if (sensor != NULL && entry->like != NULL) {
            note_sent(demux, sensor, &record); /* was on trial */
        }
        if (sensor != NULL) {
            r = lum_demux_give(demux, entry, record.time_ns);
        }
    }
    if (r < 0) {
        demux->trials.queue->next--; /* it stays */
    } else if (!demux->packet.is_pending) {
        end_waiting(demux);
    }
    return r;
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
        demux->trials.open > 0 && meet_trials(demux, record, sensor);
    if (is_held && !enqueue(demux, record, entry)) {
        return LUM_E_SPACE;
    }
    note_sent(demux, sensor, record);
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
    const bool is_doubted = is_doubtful(demux, entry);
    if (!is_doubted && entry->sensor == NULL &&
        !lum_demux_admit_sensor(demux, entry)) {
        return refuse_data(demux);
    }
    const lum_result r = is_doubted ? try_data(demux, record, entry)
                                    : take_known(demux, record, entry);
    if (demux->trials.open > 0 && demux->trials.queue != NULL) {
        judge_trials(demux, record->time_ns,
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
            const lum_result r = give_held(demux);
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
    judge_trials(demux, 0, true);
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
