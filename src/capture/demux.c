#include "lum/capture/demux.h"

#include "base/sized.h"
#include "demux_state.h"
#include "joined.h"
#include "lum/wire.h"
#include "order.h"
#include "trial.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Addresses that are counted separately, each on each of its interfaces;
 * further ones are counted together. */
#define ADDRESSES_MAX LUM_DEMUX_WAYS_MAX

struct assembly {
    lum_assembler assembler;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
};

struct address {
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES]; /* empty: it is not known */
    struct address *sensor; /* whose data it brings: itself, or the same on
                               another interface; NULL: that is not known */
    lum_trial *trial;       /* that is to tell; NULL: there is none */
    struct address *like;   /* the sensor that it may be */
    lum_recent *recent;     /* of a sensor on a known interface; or NULL */
    bool is_waiting;        /* data of it is held */
    bool is_sensor;
    bool is_further;     /* another sensor with this address came before */
    bool is_refused;     /* a sensor too many */
    bool is_held;        /* its data is passed over */
    size_t sensor_index; /* valid if it is one */
    lum_demux_counters counters;
    struct assembly *assembly;
    lum_order order;
};

struct lum_demux {
    lum_demux_options options;
    struct address addresses[ADDRESSES_MAX + 1]; /* the last: all the rest */
    size_t address_count;
    size_t sensors[LUM_DEMUX_SENSORS_MAX]; /* indices of addresses */
    size_t sensor_count;
    bool has_several;    /* records came from more than one interface */
    size_t way_count;    /* addresses on interfaces whose sensor is known */
    bool asked_is_there; /* the sensor that was asked for is one of them */
    char asked_interface[LUM_INTERFACE_BYTES]; /* empty: none was asked for */
    char interface[LUM_INTERFACE_BYTES];       /* of the records to come */
    uint64_t other;
    lum_joined joined; /* of the record at hand */
    bool is_pending;   /* the group at hand waits for an assembler */
    lum_queue *queue;  /* what is held while a trial is open; or NULL */
    size_t trials;     /* that are open */
    bool has_given;    /* of the queue, for the last record */
    lum_group group;
    int64_t group_ns; /* when it came */
    lum_packet_kind kind;
    int64_t behind_ns;    /* how far it stands behind later records */
    uint64_t lost_before; /* late and stray, before it */
    struct address *current;
    struct address *last; /* whose record was pushed last; NULL: nobody's */
    lum_stand stand;      /* of that record, if it is on trial */
    bool is_flushing;
    size_t flushing;
};

/* --- Making and freeing --- */

static void free_assembly(struct assembly *assembly)
{
    if (assembly != NULL) {
        free(assembly->slots);
        free(assembly->words);
        free(assembly->reach);
        free(assembly);
    }
}

static struct assembly *new_assembly(const lum_demux_options *options)
{
    const lum_assembler_config *c = &options->config;
    lum_assembler_storage s = {
        .slot_count = LUM_ASSEMBLER_SLOTS(c->open_lines),
        .word_count = LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line),
        .reach_count = LUM_ASSEMBLER_REACH(c->reorder_lines)};
    struct assembly *assembly = calloc(1, sizeof *assembly);
    if (assembly == NULL) {
        return NULL;
    }
    s.slots = assembly->slots = malloc(s.slot_count * sizeof *s.slots);
    s.words = assembly->words = malloc(s.word_count * sizeof *s.words);
    s.reach = assembly->reach = malloc(s.reach_count * sizeof *s.reach);
    if (s.slots == NULL || s.words == NULL || s.reach == NULL ||
        lum_assembler_init(&assembly->assembler, c, &options->layout, &s) !=
            LUM_OK) {
        free_assembly(assembly);
        return NULL;
    }
    return assembly;
}

static void set_text(char *to, const char *text)
{
    (void)snprintf(to, LUM_INTERFACE_BYTES, "%s", text != NULL ? text : "");
}

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
    set_text(demux->asked_interface, known.sensor_interface);
    demux->options.sensor_interface = NULL; /* of the caller */
    *out = demux;
    return 0;
}

static void free_queue(lum_demux *demux)
{
    if (demux->queue != NULL) {
        free(demux->queue->bytes);
        free(demux->queue);
        demux->queue = NULL;
    }
}

static void free_addresses(lum_demux *demux)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        free_assembly(demux->addresses[i].assembly);
        free(demux->addresses[i].trial);
        free(demux->addresses[i].recent);
    }
    free_queue(demux);
}

void lum_demux_free(lum_demux *demux)
{
    if (demux == NULL) {
        return;
    }
    free_addresses(demux);
    free(demux);
}

/* --- Addresses and sensors --- */

/* An interface that is not known is taken for each. */
static bool is_of(const struct address *entry, uint32_t address,
                  const char *interface)
{
    return entry->address == address &&
           (*interface == '\0' || *entry->interface == '\0' ||
            strcmp(entry->interface, interface) == 0);
}

static struct address *find_address(lum_demux *demux, uint32_t address)
{
    size_t i = 0;
    while (i < demux->address_count &&
           !is_of(&demux->addresses[i], address, demux->interface)) {
        i++;
    }
    if (i == demux->address_count && i < ADDRESSES_MAX) {
        demux->addresses[i].address = address;
        set_text(demux->addresses[i].interface, demux->interface);
        demux->address_count++;
    }
    return &demux->addresses[i];
}

static struct address *sensor_at(const lum_demux *demux, size_t sensor)
{
    return (struct address *)&demux->addresses[demux->sensors[sensor]];
}

/* The first sensor with an address; NULL: there is none. */
static struct address *find_sensor(const lum_demux *demux, uint32_t address)
{
    for (size_t i = 0; i < demux->sensor_count; i++) {
        if (sensor_at(demux, i)->address == address) {
            return sensor_at(demux, i);
        }
    }
    return NULL;
}

/* The sensor that an entry is counted with; NULL: it is with none. */
static struct address *counted_with(const lum_demux *demux,
                                    const struct address *entry)
{
    return entry->sensor != NULL ? entry->sensor
                                 : find_sensor(demux, entry->address);
}

/* Counters are numbers of 64 bits alone, so a sum needs no list of them, in
 * which one could be forgotten. */
static void add_numbers(void *to, const void *more, size_t bytes)
{
    uint64_t *sums = to;
    const uint64_t *numbers = more;
    for (size_t i = 0; i < bytes / sizeof *sums; i++) {
        sums[i] += numbers[i];
    }
}

/* An address has no *other*, and its assembler's counters are there alone. */
static void add_address(lum_demux_counters *to, const struct address *entry)
{
    add_numbers(&to->packets, &entry->counters.packets,
                sizeof *to - offsetof(lum_demux_counters, packets));
    if (entry->assembly != NULL) {
        add_numbers(&to->assembly,
                    lum_assembler_counters(&entry->assembly->assembler),
                    sizeof to->assembly);
    }
}

/* Without an interface the first sensor of an address is meant. */
static bool is_asked_for(const lum_demux *demux, const struct address *entry)
{
    const char *interface = demux->asked_interface;
    return !demux->options.has_sensor ||
           (entry->address == demux->options.sensor &&
            (*interface == '\0' ? !entry->is_further
                                : strcmp(entry->interface, interface) == 0));
}

/* How many more sensors fit; the one that was asked for keeps its place. */
static bool has_room(const lum_demux *demux, const struct address *entry)
{
    const bool reserves = demux->options.has_sensor && !demux->asked_is_there &&
                          !is_asked_for(demux, entry);
    return demux->sensor_count + (reserves ? 1u : 0u) < LUM_DEMUX_SENSORS_MAX;
}

static void set_sensor(lum_demux *demux, struct address *entry,
                       struct address *sensor)
{
    demux->way_count += entry->sensor == NULL;
    entry->sensor = sensor;
}

/* Whether the entry is, or can become, a sensor. */
static bool admit_sensor(lum_demux *demux, struct address *entry)
{
    if (entry->is_sensor) {
        return true;
    }
    entry->is_further = find_sensor(demux, entry->address) != NULL;
    if (!has_room(demux, entry)) {
        return false;
    }
    if (*entry->interface != '\0') {
        /* without memory its repeats are not known */
        entry->recent = calloc(1, sizeof *entry->recent);
    }
    entry->is_sensor = true;
    set_sensor(demux, entry, entry);
    entry->sensor_index = demux->sensor_count;
    demux->sensors[demux->sensor_count++] = (size_t)(entry - demux->addresses);
    demux->asked_is_there |=
        demux->options.has_sensor && is_asked_for(demux, entry);
    return true;
}

/* An address with data gets its own entry. It replaces an address that has sent
 * none, whose counts are added to the rest. */
static struct address *claim_entry(lum_demux *demux, uint32_t address)
{
    struct address *rest = &demux->addresses[ADDRESSES_MAX];
    struct address *entry = demux->addresses;
    while (entry < rest && (entry->sensor != NULL || entry->trial != NULL ||
                            entry->is_refused)) {
        entry++;
    }
    if (entry < rest) {
        add_address(&rest->counters, entry);
        *entry = (struct address){.address = address};
        set_text(entry->interface, demux->interface);
    }
    return entry;
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
        demux->last = find_address(demux, sensor_side(demux, record));
        demux->last->counters.cut_short++;
    } else if (has_ports) {
        demux->other++;
    } else {
        demux->addresses[ADDRESSES_MAX].counters.cut_short++;
    }
}

static void count_packet(const lum_demux *demux, const lum_record *record,
                         lum_demux_counters *c)
{
    c->packets[demux->kind]++;
    c->joined += record->kind == LUM_RECORD_JOINED;
}

static void count_data(const lum_demux *demux, const lum_record *record,
                       lum_demux_counters *c)
{
    count_packet(demux, record, c);
    if (demux->group.tag == LUM_TAG_ANGLES) {
        c->angle_packets++;
    } else {
        c->range_packets++;
    }
}

static lum_result refuse_data(lum_demux *demux)
{
    demux->other++;
    demux->kind = LUM_PACKET_KINDS;
    return LUM_OK;
}

static bool is_taken(const lum_demux *demux, const struct address *sensor)
{
    return is_asked_for(demux, sensor) && !sensor->is_held;
}

/* --- Their order --- */

static uint64_t count_late(const struct address *entry)
{
    const lum_assembly_counters *c =
        lum_assembler_counters(&entry->assembly->assembler);
    return c->late + c->stray;
}

/* The group at hand is to be assembled. */
static void note_order(lum_demux *demux)
{
    const lum_profile *p = &demux->options.layout.profile;
    demux->behind_ns = lum_order_behind_ns(
        &demux->current->order, &p->group[LUM_FIELD_TIMESTAMP],
        p->clock_unit_ns, demux->group_ns, &demux->group);
    demux->lost_before = count_late(demux->current);
}

/* Behind by more than reassembly takes: dropped, or taken for a jump of the
 * clock. */
static void judge_order(lum_demux *demux)
{
    const bool is_torn =
        demux->behind_ns / 1000 > (int64_t)demux->options.config.gap_us;
    if (demux->behind_ns > 0 &&
        (is_torn || count_late(demux->current) != demux->lost_before)) {
        demux->current->counters.out_of_order++;
    }
}

/* The group at hand is the sensor's. */
static lum_result give(lum_demux *demux, struct address *sensor,
                       int64_t time_ns)
{
    if (!is_taken(demux, sensor)) {
        return LUM_OK;
    }
    if (sensor->assembly == NULL) {
        sensor->assembly = new_assembly(&demux->options);
    }
    if (sensor->assembly == NULL) {
        return LUM_E_SPACE;
    }
    demux->current = sensor;
    demux->group_ns = time_ns;
    demux->is_pending = true;
    note_order(demux);
    return LUM_OK;
}

/* --- One address on several interfaces --- */

static bool is_on_trial(const struct address *entry)
{
    return entry->trial != NULL;
}

static void end_trial(lum_demux *demux, struct address *entry,
                      lum_verdict verdict)
{
    free(entry->trial);
    entry->trial = NULL;
    demux->trials--;
    if (verdict == LUM_VERDICT_SAME) {
        set_sensor(demux, entry, entry->like);
    } else if (!admit_sensor(demux, entry)) {
        demux->other += entry->counters.packets[LUM_PACKET_DATA];
        entry->counters.packets[LUM_PACKET_DATA] = 0;
        entry->counters.angle_packets = 0;
        entry->counters.range_packets = 0;
        entry->is_refused = true;
    }
}

static lum_measure measure_of(const lum_demux *demux)
{
    const lum_demux_options *o = &demux->options;
    return lum_measure_of(&o->layout.profile, o->config.gap_us,
                          o->config.reorder_lines);
}

static void judge_trials(lum_demux *demux, int64_t now_ns, bool is_over)
{
    const lum_measure measure = measure_of(demux);
    for (size_t i = 0; i < demux->address_count; i++) {
        struct address *entry = &demux->addresses[i];
        if (is_on_trial(entry)) {
            const lum_verdict verdict =
                is_over ? lum_trial_settle(entry->trial, &measure)
                        : lum_trial_judge(entry->trial, &measure, now_ns);
            if (verdict != LUM_VERDICT_OPEN) {
                end_trial(demux, entry, verdict);
            }
        }
    }
}

static bool hold(lum_demux *demux, const lum_record *record,
                 struct address *entry)
{
    if (demux->queue == NULL) {
        demux->queue = calloc(1, sizeof *demux->queue);
    }
    entry->is_waiting =
        demux->queue != NULL &&
        lum_queue_add(demux->queue, record, (size_t)(entry - demux->addresses));
    return entry->is_waiting;
}

/* Remember a packet of a sensor. */
static void note_sent(const lum_demux *demux, struct address *sensor,
                      const lum_record *record)
{
    if (sensor->recent != NULL) {
        const lum_seen seen = lum_seen_of(record, &demux->group);
        lum_recent_note(sensor->recent, &seen, record->time_ns);
    }
}

/* Those on trial under a sensor's address meet its packet.
 * Returns whether it has to wait: others of its address do. */
static bool meet_trials(lum_demux *demux, const lum_record *record,
                        const struct address *sensor)
{
    const lum_seen seen = lum_seen_of(record, &demux->group);
    const lum_measure measure = measure_of(demux);
    bool waits = false;
    for (size_t i = 0; i < demux->address_count; i++) {
        struct address *entry = &demux->addresses[i];
        if (entry->address == sensor->address) {
            waits |= entry->is_waiting;
        }
        if (entry->address == sensor->address && is_on_trial(entry)) {
            lum_trial_meet(entry->trial, &measure, &seen);
        }
    }
    return waits;
}

/* Where a packet stands among those of the sensors of its address; like becomes
 * the one that it stands best to. */
static lum_stand find_place(const lum_demux *demux, const lum_record *record,
                            const lum_seen *seen, struct address *entry,
                            lum_place_among *out)
{
    const lum_measure measure = measure_of(demux);
    lum_stand best = LUM_STAND_ELSEWHERE;
    *out = (lum_place_among){.stand = best};
    for (size_t i = 0; i < demux->sensor_count; i++) {
        struct address *sensor = sensor_at(demux, i);
        if (sensor->address == entry->address && sensor->recent != NULL) {
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

static bool begin_trial(lum_demux *demux, struct address *entry)
{
    entry->like = find_sensor(demux, entry->address);
    entry->trial = calloc(1, sizeof *entry->trial);
    demux->trials += entry->trial != NULL;
    return entry->trial != NULL;
}

static lum_result try_data(lum_demux *demux, const lum_record *record,
                           struct address *entry)
{
    if ((!is_on_trial(entry) && !begin_trial(demux, entry)) ||
        !hold(demux, record, entry)) {
        return LUM_E_SPACE;
    }
    const lum_seen seen = lum_seen_of(record, &demux->group);
    lum_place_among place;
    demux->stand = find_place(demux, record, &seen, entry, &place);
    lum_trial_add(entry->trial, &seen, &place, record->time_ns);
    count_data(demux, record, &entry->counters);
    return LUM_OK;
}

static void end_waiting(lum_demux *demux)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        demux->addresses[i].is_waiting = false;
    }
    free_queue(demux);
}

/* The next packet that was held becomes the one at hand. */
static lum_result give_held(lum_demux *demux)
{
    lum_record record;
    size_t way = 0;
    lum_result r = LUM_OK;
    while (!demux->is_pending && r == LUM_OK &&
           lum_queue_take(demux->queue, &record, &way)) {
        const struct address *entry = &demux->addresses[way];
        struct address *sensor = entry->sensor;
        (void)lum_packet_decode(&demux->options.layout, record.payload,
                                record.len, &demux->group);
        demux->has_given = true;
        if (sensor != NULL && entry->like != NULL) {
            note_sent(demux, sensor, &record); /* was on trial */
        }
        if (sensor != NULL) {
            r = give(demux, sensor, record.time_ns);
        }
    }
    if (r < 0) {
        lum_queue_put_back(demux->queue);
    } else if (!demux->is_pending) {
        end_waiting(demux);
    }
    return r;
}

/* --- Data --- */

/* Whether its address has a sensor on another interface, and nothing says yet
 * whose data it brings. */
static bool is_doubtful(const lum_demux *demux, const struct address *entry)
{
    return entry->sensor == NULL && *entry->interface != '\0' &&
           find_sensor(demux, entry->address) != NULL;
}

/* Of a sensor that is known. */
static lum_result take_known(lum_demux *demux, const lum_record *record,
                             struct address *entry)
{
    struct address *sensor = entry->sensor;
    const bool is_held =
        demux->trials > 0 && meet_trials(demux, record, sensor);
    if (is_held && !hold(demux, record, entry)) {
        return LUM_E_SPACE;
    }
    note_sent(demux, sensor, record);
    const lum_result r =
        is_held ? LUM_OK : give(demux, sensor, record->time_ns);
    if (r == LUM_OK && is_taken(demux, sensor)) {
        count_data(demux, record, &entry->counters);
    }
    return r;
}

static lum_result take_data(lum_demux *demux, const lum_record *record,
                            struct address *entry)
{
    if (entry == &demux->addresses[ADDRESSES_MAX] || entry->is_refused) {
        return refuse_data(demux);
    }
    const bool is_doubted = is_doubtful(demux, entry);
    if (!is_doubted && entry->sensor == NULL && !admit_sensor(demux, entry)) {
        return refuse_data(demux);
    }
    const lum_result r = is_doubted ? try_data(demux, record, entry)
                                    : take_known(demux, record, entry);
    if (demux->trials > 0 && demux->queue != NULL) {
        judge_trials(demux, record->time_ns, lum_queue_is_full(demux->queue));
    }
    return r;
}

static lum_result count_datagram(lum_demux *demux, const lum_record *record)
{
    const uint32_t address = sensor_side(demux, record);
    struct address *entry = find_address(demux, address);
    demux->kind = lum_packet_decode(&demux->options.layout, record->payload,
                                    record->len, &demux->group);
    if (demux->kind != LUM_PACKET_DATA) {
        count_packet(demux, record, &entry->counters);
        demux->last = entry;
        return LUM_OK;
    }
    if (entry == &demux->addresses[ADDRESSES_MAX]) {
        entry = claim_entry(demux, address);
    }
    demux->last = entry;
    return take_data(demux, record, entry);
}

/* Counts one datagram, or another record. Data is pending then, or held. */
static lum_result count_record(lum_demux *demux, const lum_record *record)
{
    demux->kind = LUM_PACKET_KINDS;
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

/* What waits for an assembler: the datagram at hand, or all that was held. */
static lum_result assemble(lum_demux *demux)
{
    while (true) {
        if (!demux->is_pending && demux->trials == 0 && demux->queue != NULL &&
            demux->queue->count > 0) {
            const lum_result r = give_held(demux);
            if (r < 0) {
                return r;
            }
        }
        if (!demux->is_pending) {
            return LUM_OK;
        }
        const lum_result r =
            lum_assembler_push(&demux->current->assembly->assembler,
                               &demux->group, demux->group_ns);
        demux->is_pending = r > 0;
        if (r > 0) {
            return r;
        }
        judge_order(demux);
    }
}

static void drop_record(lum_demux *demux)
{
    demux->is_pending = false;
    demux->joined = (lum_joined){.each = 0};
}

lum_result lum_demux_push(lum_demux *demux, const lum_record *record,
                          lum_packet_kind *kind)
{
    lum_record one;
    demux->has_given = demux->has_given && demux->joined.each != 0;
    lum_result r = assemble(demux);
    while (r == LUM_OK && lum_joined_next(&demux->joined, record, &one)) {
        r = count_record(demux, &one);
        if (kind != NULL) {
            *kind = demux->kind;
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
        demux->current = sensor_at(demux, demux->flushing);
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

/* --- From a place in the middle --- */

static void pack_profile(lum_profile p, lum_pack *pack)
{
    lum_pack_u32(pack, &p.data_packet_type);
    for (unsigned i = 0; i < LUM_GROUP_FIELDS; i++) {
        lum_pack_u8(pack, &p.group[i].at);
        lum_pack_u8(pack, &p.group[i].bytes);
        lum_pack_u8(pack, &p.group[i].order);
        lum_pack_u8(pack, &p.group[i].low);
        lum_pack_u8(pack, &p.group[i].bits);
    }
    lum_pack_u8(pack, &p.samples_at);
    lum_pack_u8(pack, &p.angle_order);
    lum_pack_u8(pack, &p.sample_order);
    lum_pack_u32(pack, &p.eye_values[LUM_EYE_BLUE]);
    lum_pack_u32(pack, &p.eye_values[LUM_EYE_GREEN]);
    lum_pack_u32(pack, &p.line_span_us);
    lum_pack_u32(pack, &p.clock_unit_ns);
}

void lum_demux_pack_options(const lum_demux *demux, lum_pack *pack)
{
    lum_demux_options o = demux->options;
    char interface[LUM_INTERFACE_BYTES];
    pack_profile(o.layout.profile, pack);
    lum_pack_u8(pack, &o.config.open_lines);
    lum_pack_u8(pack, &o.config.reorder_lines);
    lum_pack_u32(pack, &o.config.words_per_line);
    lum_pack_u32(pack, &o.config.gap_us);
    lum_pack_bool(pack, &o.has_sensor);
    lum_pack_u32(pack, &o.sensor);
    uint32_t port = o.port;
    lum_pack_u32(pack, &port);
    memcpy(interface, demux->asked_interface, sizeof interface);
    lum_pack_text(pack, interface, sizeof interface);
}

void lum_demux_restart(lum_demux *demux)
{
    const lum_demux_options options = demux->options;
    char asked_interface[LUM_INTERFACE_BYTES];
    memcpy(asked_interface, demux->asked_interface, sizeof asked_interface);
    free_addresses(demux);
    memset(demux, 0, sizeof *demux);
    demux->options = options;
    memcpy(demux->asked_interface, asked_interface, sizeof asked_interface);
    demux->current = demux->addresses;
}

void lum_demux_admit(lum_demux *demux, const lum_demux_way *way)
{
    lum_demux_set_interface(demux, way->interface);
    struct address *entry = find_address(demux, way->address);
    if (way->sensor >= demux->sensor_count) {
        (void)admit_sensor(demux, entry);
    } else if (entry->sensor == NULL) {
        set_sensor(demux, entry, sensor_at(demux, way->sensor));
    }
}

size_t lum_demux_way_count(const lum_demux *demux)
{
    return demux->way_count;
}

bool lum_demux_get_way(const lum_demux *demux, size_t i, lum_demux_way *out)
{
    const struct address *entry = &demux->addresses[i];
    if (i >= demux->address_count || entry->sensor == NULL) {
        return false;
    }
    out->address = entry->address;
    out->sensor = entry->sensor->sensor_index;
    set_text(out->interface, entry->interface);
    return true;
}

bool lum_demux_is_behind(const lum_demux *demux)
{
    return demux->trials > 0 || demux->has_given;
}

void lum_demux_hold(lum_demux *demux, size_t sensor, bool is_held)
{
    sensor_at(demux, sensor)->is_held = is_held;
}

bool lum_demux_last(const lum_demux *demux, size_t *sensor)
{
    const struct address *entry = demux->current;
    if (entry == NULL || entry->assembly == NULL) {
        return false;
    }
    *sensor = entry->sensor_index;
    return true;
}

bool lum_demux_newest(const lum_demux *demux, size_t sensor, uint32_t *frame)
{
    const struct address *entry = sensor_at(demux, sensor);
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
    struct address *entry = sensor_at(demux, sensor);
    if (entry->assembly == NULL) {
        entry->assembly = new_assembly(&demux->options);
    }
    if (entry->assembly == NULL) {
        pack->has_failed = true;
        return false;
    }
    demux->current = lum_pack_is_reading(pack) ? entry : demux->current;
    return lum_assembler_pack(&entry->assembly->assembler, from, pack);
}

/* --- What is known --- */

uint16_t lum_demux_port(const lum_demux *demux)
{
    return demux->options.port;
}

const lum_assembler *lum_demux_current(const lum_demux *demux)
{
    return &demux->current->assembly->assembler;
}

size_t lum_demux_current_index(const lum_demux *demux)
{
    return demux->current->sensor_index;
}

size_t lum_demux_sensor_count(const lum_demux *demux)
{
    return demux->sensor_count;
}

uint32_t lum_demux_address(const lum_demux *demux, size_t i)
{
    return sensor_at(demux, i)->address;
}

const char *lum_demux_interface(const lum_demux *demux, size_t i)
{
    const struct address *sensor = sensor_at(demux, i);
    return *sensor->interface != '\0' ? sensor->interface : NULL;
}

bool lum_demux_is_shared(const lum_demux *demux, size_t i)
{
    const struct address *sensor = sensor_at(demux, i);
    bool is_shared = sensor->is_further;
    for (size_t k = i + 1u; k < demux->sensor_count; k++) {
        is_shared |= sensor_at(demux, k)->address == sensor->address;
    }
    return is_shared;
}

const char *lum_demux_name(const lum_demux *demux, size_t i,
                           char out[LUM_SENSOR_NAME_BYTES])
{
    const struct address *sensor = sensor_at(demux, i);
    const uint32_t a = sensor->address;
    (void)snprintf(out, LUM_SENSOR_NAME_BYTES, "%u.%u.%u.%u%s%s",
                   (unsigned)(a >> 24), (unsigned)(a >> 16 & 255u),
                   (unsigned)(a >> 8 & 255u), (unsigned)(a & 255u),
                   sensor->is_further ? "%" : "",
                   sensor->is_further ? sensor->interface : "");
    return out;
}

bool lum_demux_is_requested(const lum_demux *demux, size_t i)
{
    return is_asked_for(demux, sensor_at(demux, i));
}

bool lum_demux_is_wanted(const lum_demux *demux)
{
    const struct address *entry = demux->last;
    if (!demux->options.has_sensor || entry == NULL) {
        return !demux->options.has_sensor;
    }
    const bool is_own =
        entry->sensor == NULL && *demux->asked_interface != '\0';
    const struct address *sensor = is_own ? entry : counted_with(demux, entry);
    return is_asked_for(demux, sensor != NULL ? sensor : entry) &&
           (!is_on_trial(entry) || is_own || demux->stand < LUM_STAND_ASTRAY);
}

void lum_demux_set_interface(lum_demux *demux, const char *name)
{
    if (strcmp(demux->interface, name != NULL ? name : "") != 0) {
        set_text(demux->interface, name);
    }
}

lum_result lum_demux_count(const lum_demux *demux, size_t i,
                           lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c};
    for (size_t k = 0; k < demux->address_count; k++) {
        const struct address *entry = &demux->addresses[k];
        if (counted_with(demux, entry) == sensor_at(demux, i)) {
            add_address(&c, entry);
        }
    }
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}

lum_result lum_demux_total(const lum_demux *demux, lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c, .other = demux->other};
    for (size_t i = 0; i < demux->address_count; i++) {
        const struct address *entry = &demux->addresses[i];
        const struct address *sensor = counted_with(demux, entry);
        if (sensor == NULL || is_asked_for(demux, sensor)) {
            add_address(&c, entry);
        }
    }
    add_address(&c, &demux->addresses[ADDRESSES_MAX]);
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}
