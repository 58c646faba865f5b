/* Carries out a jump in a capture: to its first record, or to a state in the
 * index. seek.c decides which. */
#include "capture/capture_internal.h"
#include "framer_state.h"
#include "reader_internal.h"

/* --- The start and the end --- */

void lum_place_begin(lum_reader *reader)
{
    struct place *p = &reader->place;
    if (p->has_begun) {
        return;
    }
    p->has_begun = true;
    p->frames.highest_ns = INT64_MIN;
    p->index.stride = p->index.stride != 0 ? p->index.stride : 1u;
    if (reader->capture == NULL || !lum_capture_can_seek(reader->capture)) {
        p->keeps_index = false;
    } else if (lum_capture_pack(reader->capture, &p->start, NULL) != 0) {
        lum_pack_reset(&p->start);
        p->keeps_index = false;
    }
    if (!lum_framer_pack_clocks(reader->framer, &p->clocks)) {
        lum_pack_reset(&p->clocks);
    }
    p->keeps_index = p->keeps_index && lum_framer_gives(reader->framer, 0);
}

static void forget(struct place *p)
{
    lum_index_entries_forget(&p->entries);
    p->jump = (struct jump){.is_made = false};
    p->frames = (struct frames){.highest_ns = INT64_MIN};
    p->target.what = SOUGHT_NOTHING;
}

void lum_place_free(struct place *place)
{
    forget(place);
    lum_pack_reset(&place->start);
    lum_pack_reset(&place->clocks);
    lum_index_clear(&place->index);
}

/* --- Going to another place --- */

int lum_place_restart(lum_reader *r, lum_error *error)
{
    struct place *p = &r->place;
    lum_pack clocks = lum_pack_of(p->clocks.written, p->clocks.len);
    lum_pack start = lum_pack_of(p->start.written, p->start.len);
    lum_framer_restart(r->framer);
    if (p->clocks.len != 0 && !lum_framer_pack_clocks(r->framer, &clocks)) {
        return lum_error_set(error, "out of memory");
    }
    forget(p);
    p->records = 0;
    r->stage = READING;
    r->status = 0;
    r->record = (lum_record){.kind = LUM_RECORD_OTHER};
    return p->start.len != 0 ? lum_capture_pack(r->capture, &start, error)
                             : lum_reader_reopen(r, error);
}

/* The awaited stand in the order of their records. */
static void await(lum_reader *r, size_t sensor)
{
    struct place *p = &r->place;
    struct jump *j = &p->jump;
    const lum_index_entry *entry =
        lum_index_of(&p->index, (uint32_t)sensor, j->anchor.order);
    const struct awaited a = {
        .sensor = (uint32_t)sensor,
        .after = entry != NULL ? entry->after : p->index.births[sensor].after,
        .entry = entry};
    size_t at = j->awaited_count++;
    while (at > 0 && j->awaited[at - 1u].after > a.after) {
        j->awaited[at] = j->awaited[at - 1u];
        at--;
    }
    j->awaited[at] = a;
    lum_demux_hold(lum_framer_sensors(r->framer), sensor, true);
}

/* As near before a record as it is sure whose data comes. Whose it is by then
 * is told, as the records that show it are passed over. */
static int move_capture(lum_reader *r, uint64_t after, lum_error *error)
{
    struct place *p = &r->place;
    lum_demux *demux = lum_framer_sensors(r->framer);
    const lum_index_place to = lum_index_place_at(&p->index, after);
    lum_pack pack = to.capture != NULL
                        ? lum_pack_of(to.capture, to.capture_len)
                        : lum_pack_of(p->start.written, p->start.len);
    for (size_t i = 0; i < p->index.origin_count; i++) {
        if (p->index.origins[i].known <= to.after) {
            lum_demux_admit(demux, &p->index.origins[i].is);
        }
    }
    lum_demux_interrupt(demux);
    p->records = to.after;
    return lum_capture_pack(r->capture, &pack, error);
}

/* Each sensor needs its own state before the frame, and these hold after
 * different records:
 * 1. All begins anew.
 * 2. Every sensor that has sent something by then is awaited: its data is
 *    passed over up to the record after which its state holds.
 * 3. The capture goes to the first of these records; lum_place_approach() does
 *    the rest. */
static int go_to(lum_reader *r, const lum_index_entry *to, lum_error *error)
{
    struct place *p = &r->place;
    struct jump *j = &p->jump;
    const lum_index_entry anchor = *to;
    if (lum_place_restart(r, error) != 0) {
        return -1;
    }
    j->is_made = true;
    j->is_approaching = true;
    j->anchor = anchor;
    j->anchor.capture = NULL;
    j->anchor.state = NULL;
    for (size_t i = 0; i < p->index.birth_count; i++) {
        if (anchor.active[i] != 0 && lum_framer_gives(r->framer, i)) {
            await(r, i);
        }
    }
    return j->awaited_count != 0 ? move_capture(r, j->awaited[0].after, error)
                                 : -1;
}

/* From the start, up to the present place, or to what is sought. */
static int read_again(lum_reader *r, lum_error *error)
{
    const struct place *p = &r->place;
    const struct target target =
        p->target.what != SOUGHT_NOTHING
            ? p->target
            : (struct target){.what = SOUGHT_ORDER, .order = p->frames.order};
    const int result = lum_place_restart(r, error);
    r->place.target = target;
    return result;
}

/* An index that is of no use is dropped. */
static int go_without_index(lum_reader *r, lum_error *error)
{
    lum_index_clear(&r->place.index);
    return read_again(r, error);
}

int lum_place_jump(lum_reader *reader, const lum_index_entry *to,
                   lum_error *error)
{
    return go_to(reader, to, NULL) == 0 ? 0 : go_without_index(reader, error);
}

/* The state of a sensor that was awaited. False: it is of no use. */
static bool load(lum_reader *r, const struct awaited *a)
{
    lum_demux_hold(lum_framer_sensors(r->framer), a->sensor, false);
    if (a->entry == NULL) {
        return true;
    }
    lum_pack pack = lum_pack_of(a->entry->state, a->entry->state_len);
    if (a->sensor >= lum_demux_sensor_count(lum_framer_demux(r->framer)) ||
        !lum_framer_pack_sensor(r->framer, a->sensor, a->entry->from, &pack)) {
        return false;
    }
    lum_framer_set_lines(r->framer, a->sensor, a->entry->from, a->entry->lines);
    lum_index_entries_go_on(r, a->entry);
    return true;
}

/* Whether no sensor that has its state sends before the next one gets its: as
 * far as is known, up to the anchor. */
static bool is_idle(const lum_reader *r)
{
    const struct place *p = &r->place;
    const struct jump *j = &p->jump;
    const struct awaited *next = &j->awaited[j->awaited_next];
    if (next->after <= p->records || next->after > j->anchor.after ||
        !lum_index_is_certain(&p->index, next->after) ||
        lum_demux_is_behind(lum_framer_demux(r->framer))) {
        return false;
    }
    for (size_t i = 0; i < j->awaited_next; i++) {
        if (j->anchor.active[j->awaited[i].sensor] > p->records) {
            return false;
        }
    }
    return true;
}

/* Before each record, until all states are loaded:
 * 1. Load the state of each sensor that is awaited after the record before.
 * 2. If none of those that have their state is known to send anything until
 *    the next one gets its, pass over the records between.
 * 3. Else read the record. A state that cannot be used ends the way: all is
 *    read from the first record. */
static int approach(lum_reader *reader, lum_error *error)
{
    struct jump *j = &reader->place.jump;
    lum_error reason = {""};
    while (j->awaited_next < j->awaited_count) {
        const struct awaited *a = &j->awaited[j->awaited_next];
        if (a->after == reader->place.records) {
            if (!load(reader, a)) {
                return go_without_index(reader, error);
            }
            j->awaited_next++;
        } else if (!is_idle(reader)) {
            break;
        } else if (move_capture(reader, a->after, &reason) != 0) {
            return go_without_index(reader, error);
        }
    }
    return 0;
}

/* Asked before each record, so what is rare is apart. */
int lum_place_approach(lum_reader *reader, lum_error *error)
{
    const struct jump *j = &reader->place.jump;
    if (lum_demux_is_unsure(lum_framer_demux(reader->framer))) {
        return read_again(reader, error);
    }
    return j->awaited_next < j->awaited_count ? approach(reader, error) : 0;
}

bool lum_place_is_reached(struct place *place, size_t sensor, int64_t number)
{
    struct jump *j = &place->jump;
    if (!j->is_approaching) {
        return true;
    }
    if (sensor != j->anchor.sensor ||
        lum_frame_is_before(number, j->anchor.from)) {
        return false;
    }
    j->is_approaching = false;
    place->frames.order = j->anchor.order;
    place->frames.highest_ns = j->anchor.highest_ns;
    return true;
}
