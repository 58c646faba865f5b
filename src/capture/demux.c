#include "lum/capture/demux.h"

#include "base/sized.h"
#include "demux_state.h"
#include "joined.h"
#include "lum/wire.h"
#include "order.h"

#include <stdlib.h>
#include <string.h>

/* Addresses that are counted separately; further ones are counted together. */
#define ADDRESSES_MAX 64u

struct assembly {
    lum_assembler assembler;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
};

struct address {
    uint32_t address;
    bool is_sensor;
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
    bool asked_is_there; /* the sensor that was asked for is one of them */
    uint64_t other;
    lum_joined joined; /* of the record at hand */
    bool is_pending;   /* its datagram was counted; that one's group is */
    lum_group group;
    lum_packet_kind kind;
    int64_t behind_ns;    /* how far it stands behind later records */
    uint64_t lost_before; /* late and stray, before it */
    struct address *current;
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
    *out = demux;
    return 0;
}

void lum_demux_free(lum_demux *demux)
{
    if (demux == NULL) {
        return;
    }
    for (size_t i = 0; i < demux->address_count; i++) {
        free_assembly(demux->addresses[i].assembly);
    }
    free(demux);
}

/* --- Addresses and sensors --- */

static struct address *find_address(lum_demux *demux, uint32_t address)
{
    size_t i = 0;
    while (i < demux->address_count && demux->addresses[i].address != address) {
        i++;
    }
    if (i == demux->address_count && i < ADDRESSES_MAX) {
        demux->addresses[i].address = address;
        demux->address_count++;
    }
    return &demux->addresses[i];
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

static bool is_asked_for(const lum_demux *demux, const struct address *entry)
{
    return !demux->options.has_sensor ||
           entry->address == demux->options.sensor;
}

/* How many more sensors fit; the one that was asked for keeps its place. */
static bool has_room(const lum_demux *demux, const struct address *entry)
{
    const bool reserves = demux->options.has_sensor && !demux->asked_is_there &&
                          entry->address != demux->options.sensor;
    return demux->sensor_count + (reserves ? 1u : 0u) < LUM_DEMUX_SENSORS_MAX;
}

/* Whether the entry is, or can become, a sensor. */
static bool admit_sensor(lum_demux *demux, struct address *entry)
{
    if (entry->is_sensor) {
        return true;
    }
    if (!has_room(demux, entry)) {
        return false;
    }
    entry->is_sensor = true;
    entry->sensor_index = demux->sensor_count;
    demux->sensors[demux->sensor_count++] = (size_t)(entry - demux->addresses);
    demux->asked_is_there |=
        demux->options.has_sensor && entry->address == demux->options.sensor;
    return true;
}

/* An address with data gets its own entry. It replaces an address that has sent
 * none, whose counts are added to the rest. */
static struct address *claim_entry(lum_demux *demux, uint32_t address)
{
    struct address *rest = &demux->addresses[ADDRESSES_MAX];
    struct address *entry = demux->addresses;
    while (entry < rest && entry->is_sensor) {
        entry++;
    }
    if (entry < rest) {
        add_address(&rest->counters, entry);
        *entry = (struct address){.address = address};
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
        find_address(demux, sensor_side(demux, record))->counters.cut_short++;
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

static void count_tag(lum_demux_counters *c, const lum_group *group)
{
    if (group->tag == LUM_TAG_ANGLES) {
        c->angle_packets++;
    } else {
        c->range_packets++;
    }
}

/* Counts data; LUM_LINE_READY: the current sensor's assembler is to take it. */
static lum_result take_data(lum_demux *demux, const lum_record *record,
                            struct address *entry)
{
    if (!admit_sensor(demux, entry)) {
        demux->other++;
        demux->kind = LUM_PACKET_KINDS;
        return LUM_OK;
    }
    if (!is_asked_for(demux, entry) || entry->is_held) {
        return LUM_OK;
    }
    if (entry->assembly == NULL) {
        entry->assembly = new_assembly(&demux->options);
    }
    if (entry->assembly == NULL) {
        return LUM_E_SPACE;
    }
    demux->current = entry;
    count_packet(demux, record, &entry->counters);
    count_tag(&entry->counters, &demux->group);
    return LUM_LINE_READY;
}

static lum_result count_datagram(lum_demux *demux, const lum_record *record)
{
    const uint32_t address = sensor_side(demux, record);
    struct address *entry = find_address(demux, address);
    demux->kind = lum_packet_decode(&demux->options.layout, record->payload,
                                    record->len, &demux->group);
    if (demux->kind != LUM_PACKET_DATA) {
        count_packet(demux, record, &entry->counters);
        return LUM_OK;
    }
    if (entry == &demux->addresses[ADDRESSES_MAX]) {
        entry = claim_entry(demux, address);
    }
    return take_data(demux, record, entry);
}

/* Counts one datagram, or another record; LUM_LINE_READY: the current sensor
 * has data to take. */
static lum_result count_record(lum_demux *demux, const lum_record *record)
{
    demux->kind = LUM_PACKET_KINDS;
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

static uint64_t count_late(const struct address *entry)
{
    const lum_assembly_counters *c =
        lum_assembler_counters(&entry->assembly->assembler);
    return c->late + c->stray;
}

static void note_order(lum_demux *demux, const lum_record *record)
{
    const lum_profile *p = &demux->options.layout.profile;
    demux->behind_ns = lum_order_behind_ns(
        &demux->current->order, &p->group[LUM_FIELD_TIMESTAMP],
        p->clock_unit_ns, record->time_ns, &demux->group);
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

/* --- Events --- */

/* The datagram whose group is at hand. */
static lum_result assemble(lum_demux *demux, int64_t time_ns)
{
    const lum_result r = lum_assembler_push(
        &demux->current->assembly->assembler, &demux->group, time_ns);
    demux->is_pending = r > 0;
    if (r <= 0) {
        judge_order(demux);
    }
    return r > 0 ? r : LUM_OK;
}

static lum_result take_one(lum_demux *demux, const lum_record *one)
{
    const lum_result counted = count_record(demux, one);
    if (counted != LUM_LINE_READY) {
        return counted;
    }
    note_order(demux, one);
    return assemble(demux, one->time_ns);
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
    lum_result r =
        demux->is_pending ? assemble(demux, record->time_ns) : LUM_OK;
    while (r == LUM_OK && lum_joined_next(&demux->joined, record, &one)) {
        r = take_one(demux, &one);
        if (kind != NULL) {
            *kind = demux->kind;
        }
    }
    if (r < 0) {
        drop_record(demux);
    }
    return r;
}

lum_result lum_demux_flush(lum_demux *demux)
{
    drop_record(demux);
    for (; demux->flushing < demux->sensor_count; demux->flushing++) {
        demux->current = &demux->addresses[demux->sensors[demux->flushing]];
        if (demux->current->assembly != NULL) {
            const lum_result r =
                lum_assembler_flush(&demux->current->assembly->assembler);
            if (r > 0) {
                return r;
            }
        }
    }
    demux->flushing = 0;
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
    pack_profile(o.layout.profile, pack);
    lum_pack_u8(pack, &o.config.open_lines);
    lum_pack_u8(pack, &o.config.reorder_lines);
    lum_pack_u32(pack, &o.config.words_per_line);
    lum_pack_u32(pack, &o.config.gap_us);
    lum_pack_bool(pack, &o.has_sensor);
    lum_pack_u32(pack, &o.sensor);
    uint32_t port = o.port;
    lum_pack_u32(pack, &port);
}

void lum_demux_restart(lum_demux *demux)
{
    const lum_demux_options options = demux->options;
    for (size_t i = 0; i < demux->address_count; i++) {
        free_assembly(demux->addresses[i].assembly);
    }
    memset(demux, 0, sizeof *demux);
    demux->options = options;
    demux->current = demux->addresses;
}

void lum_demux_admit(lum_demux *demux, uint32_t address)
{
    (void)admit_sensor(demux, find_address(demux, address));
}

static struct address *sensor_at(lum_demux *demux, size_t sensor)
{
    return &demux->addresses[demux->sensors[sensor]];
}

bool lum_demux_is_asked(const lum_demux *demux, size_t sensor)
{
    return is_asked_for(demux, &demux->addresses[demux->sensors[sensor]]);
}

void lum_demux_hold(lum_demux *demux, size_t sensor, bool is_held)
{
    sensor_at(demux, sensor)->is_held = is_held;
}

bool lum_demux_newest(const lum_demux *demux, size_t *sensor, uint32_t *frame)
{
    const struct address *entry = demux->current;
    if (entry == NULL || entry->assembly == NULL) {
        return false;
    }
    const lum_eye_state *eyes = entry->assembly->assembler.eye;
    const lum_eye_frames *blue = &eyes[LUM_EYE_BLUE].frames;
    const lum_eye_frames *green = &eyes[LUM_EYE_GREEN].frames;
    const bool is_blue =
        blue->begun &&
        (!green->begun || (blue->frame - green->frame) >> 31 == 0);
    *sensor = entry->sensor_index;
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
    return demux->addresses[demux->sensors[i]].address;
}

lum_result lum_demux_count(const lum_demux *demux, size_t i,
                           lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c};
    add_address(&c, &demux->addresses[demux->sensors[i]]);
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}

lum_result lum_demux_total(const lum_demux *demux, lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c, .other = demux->other};
    for (size_t i = 0; i < demux->address_count; i++) {
        const struct address *entry = &demux->addresses[i];
        if (!entry->is_sensor || is_asked_for(demux, entry)) {
            add_address(&c, entry);
        }
    }
    add_address(&c, &demux->addresses[ADDRESSES_MAX]);
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}
