#include "demux_interfaces.h"

#include <stdlib.h>

/* To compare a packet with those next to it takes as long as tens of others. */
#define COMPARED_FROM 1024u /* before, too few are remembered */
#define RARELY        2048u /* one packet of these is compared, */
#define OFTEN         512u  /* and of these among the first LOOK_PACKETS */
#define LOOK_PACKETS  LUM_DEMUX_LOOK_PACKETS

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

bool lum_demux_is_doubtful(const lum_demux *demux, const lum_demux_entry *entry)
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

void lum_demux_judge_trials(lum_demux *demux, int64_t now_ns, bool is_over)
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

bool lum_demux_enqueue(lum_demux *demux, const lum_record *record,
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

void lum_demux_look_at_sent(const lum_demux *demux, lum_demux_entry *sensor,
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

bool lum_demux_meet_trials(lum_demux *demux, const lum_record *record,
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

lum_result lum_demux_try(lum_demux *demux, const lum_record *record,
                         lum_demux_entry *entry)
{
    if (entry->trial == NULL && !look_back(demux, entry)) {
        demux->trials.is_unsure = true;
        return LUM_OK;
    }
    if ((entry->trial == NULL && !begin_trial(demux, entry)) ||
        !lum_demux_enqueue(demux, record, entry)) {
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

lum_result lum_demux_give_held(lum_demux *demux)
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
            lum_demux_note_sent(demux, sensor, &record); /* was on trial */
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
