#include "demux_sensors.h"

#include "base/sized.h"
#include "core/field.h"

#include <stdlib.h>

/* Two sensors are told if at least 3, and 1 of 8, of the packets that were
 * compared contradict those next to them. */
#define CONTRADICTING_MIN   3u
#define CONTRADICTING_SHARE 8u

/* A clock farther back has begun anew. */
#define LATE_MAX_US 1000000

/* --- Memory --- */

static void free_assembly(lum_demux_assembly *assembly)
{
    if (assembly != NULL) {
        free(assembly->slots);
        free(assembly->words);
        free(assembly->reach);
        free(assembly);
    }
}

lum_demux_assembly *lum_demux_new_assembly(const lum_demux_options *options,
                                           const lum_layout *layout)
{
    const lum_assembler_config *c = &options->config;
    lum_assembler_storage s = {
        .slot_count = LUM_ASSEMBLER_SLOTS(c->open_lines),
        .word_count = LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line),
        .reach_count = LUM_ASSEMBLER_REACH(c->reorder_lines)};
    lum_demux_assembly *assembly = calloc(1, sizeof *assembly);
    if (assembly == NULL) {
        return NULL;
    }
    s.slots = assembly->slots = malloc(s.slot_count * sizeof *s.slots);
    s.words = assembly->words = malloc(s.word_count * sizeof *s.words);
    s.reach = assembly->reach = malloc(s.reach_count * sizeof *s.reach);
    if (s.slots == NULL || s.words == NULL || s.reach == NULL ||
        lum_assembler_init(&assembly->assembler, c, layout, &s) != LUM_OK) {
        free_assembly(assembly);
        return NULL;
    }
    return assembly;
}

void lum_demux_free_queue(lum_demux *demux)
{
    if (demux->trials.queue != NULL) {
        free(demux->trials.queue->bytes);
        free(demux->trials.queue);
        demux->trials.queue = NULL;
    }
}

void lum_demux_clear(lum_demux *demux)
{
    for (size_t i = 0; i < demux->address_count; i++) {
        free_assembly(demux->addresses[i].assembly);
        free(demux->addresses[i].trial);
        free(demux->addresses[i].recent);
    }
    lum_demux_free_queue(demux);
}

/* --- Addresses and sensors --- */

/* An interface that is not known is taken for each. */
static bool is_of(const lum_demux_entry *entry, uint32_t address,
                  const char *interface)
{
    return entry->address == address &&
           (*interface == '\0' || *entry->interface == '\0' ||
            strcmp(entry->interface, interface) == 0);
}

/* An address on the present interface. */
static void begin_entry(const lum_demux *demux, lum_demux_entry *out,
                        uint32_t address)
{
    *out = (lum_demux_entry){.address = address,
                             .layout = lum_demux_layout_for(
                                 &demux->members, address, demux->interface,
                                 &demux->options.layout)};
    lum_demux_set_text(out->interface, demux->interface);
}

lum_demux_entry *lum_demux_find_address(lum_demux *demux, uint32_t address)
{
    size_t i = 0;
    while (i < demux->address_count &&
           !is_of(&demux->addresses[i], address, demux->interface)) {
        i++;
    }
    if (i == demux->address_count && i < LUM_DEMUX_ADDRESSES_MAX) {
        begin_entry(demux, &demux->addresses[i], address);
        demux->address_count++;
    }
    return &demux->addresses[i];
}

/* Whether a sensor with an address came whose interface no member has. */
static bool has_unnamed(const lum_demux *demux, uint32_t address)
{
    for (size_t i = 0; i < demux->sensor_count; i++) {
        const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
        if (sensor->address == address &&
            lum_demux_find_member(&demux->members, address, sensor->interface,
                                  true) == LUM_DEMUX_NO_MEMBER) {
            return true;
        }
    }
    return false;
}

lum_demux_entry *lum_demux_find_sensor(const lum_demux *demux, uint32_t address)
{
    for (size_t i = 0; i < demux->sensor_count; i++) {
        if (lum_demux_sensor_at(demux, i)->address == address) {
            return lum_demux_sensor_at(demux, i);
        }
    }
    return NULL;
}

/* The sensor that an entry is counted with; NULL: it is with none. */
static lum_demux_entry *counted_with(const lum_demux *demux,
                                     const lum_demux_entry *entry)
{
    return entry->sensor != NULL ? entry->sensor
                                 : lum_demux_find_sensor(demux, entry->address);
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
static void add_address(lum_demux_counters *to, const lum_demux_entry *entry)
{
    add_numbers(&to->packets, &entry->counters.packets,
                sizeof *to - offsetof(lum_demux_counters, packets));
    if (entry->assembly != NULL) {
        add_numbers(&to->assembly,
                    lum_assembler_counters(&entry->assembly->assembler),
                    sizeof to->assembly);
    }
}

static int member_of(const lum_demux *demux, const lum_demux_entry *entry)
{
    return lum_demux_find_member(&demux->members, entry->address,
                                 entry->interface, entry->is_beside);
}

static bool is_asked_for(const lum_demux *demux, const lum_demux_entry *entry)
{
    return demux->members.count == 0 ||
           lum_demux_members_want(&demux->members, member_of(demux, entry));
}

/* Those that are asked for keep their places. */
static bool has_room(const lum_demux *demux, int member)
{
    return demux->sensor_count +
               lum_demux_members_absent(&demux->members, member) <
           LUM_DEMUX_SENSORS_MAX;
}

void lum_demux_set_sensor(lum_demux *demux, lum_demux_entry *entry,
                          lum_demux_entry *sensor)
{
    if (entry->origin == 0) {
        entry->origin = ++demux->origin_count;
        entry->since = entry->since != 0 ? entry->since : demux->record;
    }
    entry->sensor = sensor;
    entry->layout = sensor != NULL ? sensor->layout : entry->layout;
}

bool lum_demux_admit_sensor(lum_demux *demux, lum_demux_entry *entry)
{
    if (entry->sensor == entry) {
        return true;
    }
    entry->is_further = lum_demux_find_sensor(demux, entry->address) != NULL;
    entry->is_beside = has_unnamed(demux, entry->address);
    const int member = member_of(demux, entry);
    if (!has_room(demux, member)) {
        return false;
    }
    /* without memory its repeats are not known */
    entry->recent = calloc(1, sizeof *entry->recent);
    lum_demux_set_sensor(demux, entry, entry);
    entry->sensor_index = demux->sensor_count;
    demux->sensors[demux->sensor_count++] = (size_t)(entry - demux->addresses);
    if (member != LUM_DEMUX_NO_MEMBER) {
        demux->members.of[member].is_there = true;
    }
    return true;
}

lum_demux_entry *lum_demux_claim_address(lum_demux *demux, uint32_t address)
{
    lum_demux_entry *rest = &demux->addresses[LUM_DEMUX_ADDRESSES_MAX];
    lum_demux_entry *entry = demux->addresses;
    while (entry < rest && (entry->origin != 0 || entry->trial != NULL)) {
        entry++;
    }
    if (entry < rest) {
        add_address(&rest->counters, entry);
        begin_entry(demux, entry, address);
    }
    return entry;
}

/* --- Order --- */

/* Beyond this a clock is corrupt, or began anew. */
#define BEHIND_MAX_NS INT64_C(1000000000000)

/* How far the sensor's clock is behind the newest record's; 0: not at all. */
static int64_t clock_behind_ns(const lum_order *order, const lum_field *field,
                               uint32_t unit_ns, uint64_t ticks)
{
    const uint64_t all = UINT64_MAX >> (64u - clock_bits(field));
    const uint64_t behind = (order->newest_ticks - ticks) & all;
    return behind <= all / 2u && behind < (uint64_t)BEHIND_MAX_NS / unit_ns
               ? (int64_t)(behind * unit_ns)
               : 0;
}

/* It is the latest now. */
static void go_on(lum_order *order, int64_t break_ns, int64_t time_ns,
                  uint64_t ticks)
{
    const bool is_break =
        !order->has_newest || time_ns - order->newest_ns > break_ns;
    *order = (lum_order){.has_newest = true,
                         .newest_ns = time_ns,
                         .newest_ticks = ticks,
                         .ahead = is_break ? 1u : order->ahead + 1u};
}

/* Whether it is one of more than stand ahead of it: then they are the ones that
 * are out of order. */
static bool has_majority(lum_order *order, int64_t time_ns)
{
    const bool is_in_row = order->behind != 0 && time_ns >= order->last_ns;
    order->behind = is_in_row ? order->behind + 1u : 1u;
    order->last_ns = time_ns;
    return order->behind > order->ahead;
}

/* By both clocks. */
static int64_t find_behind_ns(const lum_order *order, const lum_field *field,
                              uint32_t unit_ns, int64_t behind_ns,
                              uint64_t ticks)
{
    if (field->bytes == 0) {
        return behind_ns;
    }
    const int64_t clock_ns = clock_behind_ns(order, field, unit_ns, ticks);
    return behind_ns >= clock_ns / 2 && behind_ns <= clock_ns + clock_ns / 2
               ? behind_ns
               : 0;
}

int64_t lum_order_behind_ns(lum_order *order, const lum_field *field,
                            uint32_t unit_ns, int64_t break_ns, int64_t time_ns,
                            const lum_group *group)
{
    if (!order->has_newest || time_ns >= order->newest_ns) {
        go_on(order, break_ns, time_ns, group->clock_raw);
        return 0;
    }
    const int64_t behind_ns = find_behind_ns(
        order, field, unit_ns, order->newest_ns - time_ns, group->clock_raw);
    if (behind_ns > break_ns && has_majority(order, time_ns)) {
        const uint64_t behind = order->behind;
        order->has_newest = false;
        go_on(order, break_ns, time_ns, group->clock_raw);
        order->ahead = behind;
        return 0;
    }
    return behind_ns;
}

/* --- Their data --- */

void lum_demux_count_packet(const lum_demux *demux, const lum_record *record,
                            lum_demux_counters *c)
{
    c->packets[demux->packet.kind]++;
    c->joined += record->kind == LUM_RECORD_JOINED;
}

void lum_demux_count_data(const lum_demux *demux, const lum_record *record,
                          lum_demux_counters *c)
{
    lum_demux_count_packet(demux, record, c);
    if (demux->packet.group.tag == LUM_TAG_ANGLES) {
        c->angle_packets++;
    } else {
        c->range_packets++;
    }
}

static uint64_t count_late(const lum_demux_entry *entry)
{
    const lum_assembly_counters *c =
        lum_assembler_counters(&entry->assembly->assembler);
    return c->late + c->stray;
}

/* The group at hand is to be assembled. */
static void note_order(lum_demux *demux)
{
    const lum_profile *p = &demux->current->layout->profile;
    demux->packet.behind_ns = lum_order_behind_ns(
        &demux->current->order, &p->group[LUM_FIELD_TIMESTAMP],
        p->clock_unit_ns, (int64_t)demux->options.config.gap_us * 1000,
        demux->packet.time_ns, &demux->packet.group);
    demux->packet.lost_before = count_late(demux->current);
}

void lum_demux_judge_order(lum_demux *demux)
{
    const bool is_torn =
        demux->packet.behind_ns / 1000 > (int64_t)demux->options.config.gap_us;
    if (demux->packet.behind_ns > 0 &&
        (is_torn || count_late(demux->current) != demux->packet.lost_before)) {
        demux->current->counters.out_of_order++;
    }
}

bool lum_demux_takes(const lum_demux *demux, const lum_demux_entry *sensor)
{
    return is_asked_for(demux, sensor) &&
           (demux->held >> sensor->sensor_index & 1u) == 0;
}

lum_measure lum_demux_measure(const lum_demux *demux,
                              const lum_demux_entry *entry)
{
    const lum_assembler_config *config = &demux->options.config;
    return lum_measure_of(&entry->layout->profile, config->gap_us,
                          config->reorder_lines);
}

/* What is so far behind what its sensor sent on its first interface would be
 * taken for a break of the clock. */
static bool is_late_copy(const lum_demux *demux, const lum_demux_entry *entry)
{
    const lum_demux_entry *sensor = entry->sensor;
    if (entry == sensor || !sensor->has_clock) {
        return false;
    }
    const lum_measure m = lum_demux_measure(demux, sensor);
    const int64_t behind_us =
        lum_measure_us(&m, demux->packet.group.clock_raw, sensor->clock);
    return m.clock_bits != 0 && behind_us > (int64_t)m.gap_us &&
           behind_us <= LATE_MAX_US;
}

lum_result lum_demux_give(lum_demux *demux, lum_demux_entry *entry,
                          int64_t time_ns)
{
    lum_demux_entry *sensor = entry->sensor;
    if (!lum_demux_takes(demux, sensor)) {
        return LUM_OK;
    }
    if (is_late_copy(demux, entry)) {
        entry->counters.assembly.late++;
        return LUM_OK;
    }
    if (sensor->assembly == NULL) {
        sensor->assembly =
            lum_demux_new_assembly(&demux->options, sensor->layout);
    }
    if (sensor->assembly == NULL) {
        return LUM_E_SPACE;
    }
    if (entry == sensor) {
        sensor->has_clock = true;
        sensor->clock = demux->packet.group.clock_raw;
    }
    demux->current = sensor;
    demux->packet.time_ns = time_ns;
    demux->packet.is_pending = true;
    note_order(demux);
    return LUM_OK;
}

/* --- What is known --- */

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
    return lum_demux_sensor_at(demux, i)->address;
}

const char *lum_demux_interface(const lum_demux *demux, size_t i)
{
    const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
    return *sensor->interface != '\0' ? sensor->interface : NULL;
}

bool lum_demux_is_shared(const lum_demux *demux, size_t i)
{
    const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
    bool is_shared = sensor->is_further;
    for (size_t k = i + 1u; k < demux->sensor_count; k++) {
        is_shared |= lum_demux_sensor_at(demux, k)->address == sensor->address;
    }
    return is_shared;
}

const char *lum_demux_further(const lum_demux *demux, size_t sensor)
{
    const lum_demux_entry *entry = lum_demux_sensor_at(demux, sensor);
    return entry->is_further ? entry->interface : "";
}

const char *lum_demux_name(const lum_demux *demux, size_t i,
                           char out[LUM_SENSOR_NAME_BYTES])
{
    const uint32_t a = lum_demux_address(demux, i);
    const char *further = lum_demux_further(demux, i);
    (void)snprintf(out, LUM_SENSOR_NAME_BYTES, "%u.%u.%u.%u%s%s",
                   (unsigned)(a >> 24), (unsigned)(a >> 16 & 255u),
                   (unsigned)(a >> 8 & 255u), (unsigned)(a & 255u),
                   *further != '\0' ? "%" : "", further);
    return out;
}

bool lum_demux_is_requested(const lum_demux *demux, size_t i)
{
    return is_asked_for(demux, lum_demux_sensor_at(demux, i));
}

lum_demux_mixture lum_demux_mixed(const lum_demux *demux)
{
    lum_demux_mixture all = {.compared = 0};
    for (size_t i = 0; i < demux->sensor_count; i++) {
        const lum_demux_entry *sensor = lum_demux_sensor_at(demux, i);
        const lum_demux_mixture own = sensor->neighbours;
        if (is_asked_for(demux, sensor) &&
            own.contradicting >= CONTRADICTING_MIN &&
            own.contradicting >= own.compared / CONTRADICTING_SHARE) {
            all.compared += own.compared;
            all.contradicting += own.contradicting;
        }
    }
    return all;
}

int lum_demux_member_of(const lum_demux *demux, size_t i)
{
    return member_of(demux, lum_demux_sensor_at(demux, i));
}

bool lum_demux_is_wanted(const lum_demux *demux)
{
    const lum_demux_entry *entry = demux->last;
    if (demux->members.count == 0 || entry == NULL) {
        return demux->members.count == 0;
    }
    const bool is_own = entry->sensor == NULL &&
                        lum_demux_members_name(&demux->members, entry->address);
    const lum_demux_entry *sensor = is_own ? entry : counted_with(demux, entry);
    return is_asked_for(demux, sensor != NULL ? sensor : entry) &&
           (entry->trial == NULL || is_own ||
            demux->trials.stand < LUM_STAND_ASTRAY);
}

void lum_demux_set_interface(lum_demux *demux, const char *name)
{
    if (strcmp(demux->interface, name != NULL ? name : "") != 0) {
        lum_demux_set_text(demux->interface, name);
    }
}

lum_result lum_demux_count(const lum_demux *demux, size_t i,
                           lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c};
    for (size_t k = 0; k < demux->address_count; k++) {
        const lum_demux_entry *entry = &demux->addresses[k];
        if (counted_with(demux, entry) == lum_demux_sensor_at(demux, i)) {
            add_address(&c, entry);
        }
    }
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}

lum_result lum_demux_total(const lum_demux *demux, lum_demux_counters *out)
{
    lum_demux_counters c = {.struct_size = sizeof c, .other = demux->other};
    for (size_t i = 0; i < demux->address_count; i++) {
        const lum_demux_entry *entry = &demux->addresses[i];
        const lum_demux_entry *sensor = counted_with(demux, entry);
        if (sensor == NULL || is_asked_for(demux, sensor)) {
            add_address(&c, entry);
        }
    }
    add_address(&c, &demux->addresses[LUM_DEMUX_ADDRESSES_MAX]);
    return lum_sized_fill(out, &c, sizeof c) ? LUM_OK : LUM_E_VALUE;
}
