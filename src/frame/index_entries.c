/* Makes entries of an index while a capture is read: at the start of some
 * frames, a state from which reading can go on. */
#include "capture/capture_internal.h"
#include "framer_state.h"
#include "reader_internal.h"

#include <stdlib.h>
#include <string.h>

/* Longer states are not worth their memory. */
#define STATE_BYTES_MAX ((size_t)1024 * 1024)

/* Records between two states that are kept for sensors that appear. */
#define EARLY_RECORDS 1024u

/* --- One entry --- */

static bool copy_bytes(const lum_pack *from, uint8_t **bytes, size_t *len)
{
    *bytes = malloc(from->len + 1u);
    if (*bytes == NULL) {
        return false;
    }
    if (from->len != 0) {
        memcpy(*bytes, from->written, from->len);
    }
    *len = from->len;
    return true;
}

/* NULL: there is no memory, or a state is too long. */
static lum_index_entry *make_entry(lum_reader *r, size_t sensor, uint32_t from)
{
    lum_pack capture = {.written = NULL};
    lum_pack state = {.written = NULL};
    lum_index_entry *e = calloc(1, sizeof *e);
    const bool is_made =
        e != NULL && lum_capture_pack(r->capture, &capture, NULL) == 0 &&
        lum_framer_pack_sensor(r->framer, sensor, from, &state) &&
        capture.len + state.len <= STATE_BYTES_MAX &&
        copy_bytes(&capture, &e->capture, &e->capture_len) &&
        copy_bytes(&state, &e->state, &e->state_len);
    lum_pack_reset(&capture);
    lum_pack_reset(&state);
    if (!is_made) {
        lum_index_entry_free(e);
        return NULL;
    }
    e->sensor = (uint32_t)sensor;
    e->from = from;
    e->after = r->place.records;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        e->active[i] = r->place.entries.sensors[i].active;
    }
    return e;
}

static lum_index_entry *take_oldest(struct entry_maker *m)
{
    lum_index_entry *oldest = m->pending[0];
    m->pending_count--;
    for (size_t i = 0; i < m->pending_count; i++) {
        m->pending[i] = m->pending[i + 1u];
    }
    return oldest;
}

/* The oldest goes where there are too many. */
static void add_pending(struct entry_maker *m, lum_index_entry *entry)
{
    if (m->pending_count == LUM_INDEX_PENDING_MAX) {
        lum_index_entry_free(take_oldest(m));
    }
    m->pending[m->pending_count++] = entry;
}

void lum_index_entries_forget(struct index_entries *entries)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        struct entry_maker *m = &entries->sensors[i];
        while (m->pending_count > 0) {
            lum_index_entry_free(m->pending[--m->pending_count]);
        }
        *m = (struct entry_maker){.has_newest = false};
    }
    lum_pack_reset(&entries->early);
    entries->early_after = 0;
}

/* --- Records come --- */

static void note_births(lum_reader *r)
{
    struct place *p = &r->place;
    const lum_demux *demux = lum_framer_demux(r->framer);
    const lum_pack *early =
        p->entries.early.len != 0 ? &p->entries.early : &p->start;
    while (p->index.birth_count < lum_demux_sensor_count(demux)) {
        lum_index_birth *b = &p->index.births[p->index.birth_count];
        if (!copy_bytes(early, &b->capture, &b->capture_len)) {
            p->keeps_index = false;
            return;
        }
        b->after = p->entries.early_after;
        p->index.birth_count++;
    }
}

/* After each jump they become known in the same order. */
static void note_origins(lum_reader *r)
{
    lum_index *x = &r->place.index;
    const lum_demux *demux = lum_framer_demux(r->framer);
    while (x->origin_count < lum_demux_origin_count(demux)) {
        x->origins[x->origin_count] = (lum_index_origin){
            .is = lum_demux_origin_at(demux, x->origin_count),
            .known = r->place.records};
        x->origin_count++;
    }
}

static void keep_early(lum_reader *r)
{
    struct place *p = &r->place;
    if (p->records % EARLY_RECORDS == 0 &&
        !lum_demux_is_behind(lum_framer_demux(r->framer))) {
        lum_pack_reset(&p->entries.early);
        p->entries.early_after = p->records;
        if (lum_capture_pack(r->capture, &p->entries.early, NULL) != 0 ||
            p->entries.early.len > STATE_BYTES_MAX) {
            lum_pack_reset(&p->entries.early);
            p->entries.early_after = 0;
        }
    }
}

/* A frame has begun, and no line of it was handed out yet. */
static void note_begin(lum_reader *r, size_t sensor, uint32_t frame)
{
    struct entry_maker *m = &r->place.entries.sensors[sensor];
    const bool is_due =
        !m->has_marked || frame - m->marked >= r->place.index.stride;
    lum_index_entry *entry = is_due ? make_entry(r, sensor, frame) : NULL;
    if (entry != NULL) {
        add_pending(m, entry);
        m->has_marked = true;
        m->marked = frame;
    }
}

/* A sensor may have sent data. */
static void note_data(lum_reader *r, size_t sensor, bool may_mark)
{
    uint32_t frame = 0;
    struct entry_maker *m = &r->place.entries.sensors[sensor];
    m->active = r->place.records;
    if (!lum_demux_newest(lum_framer_demux(r->framer), sensor, &frame)) {
        return;
    }
    const bool rises = m->has_newest && lum_frame_is_before(m->newest, frame);
    m->newest = rises || !m->has_newest ? frame : m->newest;
    m->has_newest = true;
    if (rises && may_mark && lum_framer_gives(r->framer, sensor)) {
        note_begin(r, sensor, frame);
    }
}

/* What was held is of any sensor, and frames may have begun before. */
static void note_all_data(lum_reader *r)
{
    const lum_demux *demux = lum_framer_demux(r->framer);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        if (lum_demux_is_requested(demux, i)) {
            note_data(r, i, false);
        }
    }
}

/* 1. While lines are passed over, or it is not sure whose data comes, the
 * states are not those of a reading from the start: nothing is noted.
 * 2. While packets are held, assemblers are not where the capture is: it is
 *    noted that all sensors may have sent something, but no entry is made.
 * 3. Else the record's sensor gets an entry if it has begun a frame, unless the
 *    record was read before, too. */
void lum_index_entries_note_record(lum_reader *reader)
{
    struct place *p = &reader->place;
    const lum_demux *demux = lum_framer_demux(reader->framer);
    size_t sensor = 0;
    if (!p->keeps_index || lum_framer_is_skipping(reader->framer) ||
        lum_demux_is_unsure(demux)) {
        return;
    }
    const bool is_new = p->records > p->index.known;
    note_births(reader);
    note_origins(reader);
    if (lum_demux_is_behind(demux)) {
        note_all_data(reader);
    } else if (lum_demux_last(demux, &sensor)) {
        note_data(reader, sensor, is_new);
    }
    p->index.known = is_new ? p->records : p->index.known;
    keep_early(reader);
}

/* Only then it may be found out whose some data is. */
void lum_index_entries_note_end(lum_reader *reader)
{
    struct place *p = &reader->place;
    if (lum_framer_is_skipping(reader->framer)) {
        return;
    }
    if (p->keeps_index) {
        note_births(reader);
        note_origins(reader);
    }
    p->index.is_whole |= !p->jump.is_approaching && !p->frames.is_lost;
}

/* 1. Entries that begin with the frame, or before it, are complete. Each would
 *    give this frame first, so only the last stays: from it the least is read.
 * 2. Entries stand by the order of frames, of which each has one at most. */
void lum_index_entries_finish(struct place *p, size_t sensor, int64_t number,
                              const uint32_t lines[LUM_EYES])
{
    struct entry_maker *m = &p->entries.sensors[sensor];
    const lum_index *x = &p->index;
    lum_index_entry *e = NULL;
    while (m->pending_count > 0 &&
           !lum_frame_is_before(number, m->pending[0]->from)) {
        lum_index_entry_free(e);
        e = take_oldest(m);
    }
    if (e == NULL || (x->count != 0 &&
                      x->entries[x->count - 1u]->order >= p->frames.order)) {
        lum_index_entry_free(e);
        return;
    }
    e->order = p->frames.order;
    e->number = number;
    e->highest_ns = p->frames.highest_ns;
    memcpy(e->lines, lines, sizeof e->lines);
    lum_index_add(&p->index, e);
}

void lum_index_entries_go_on(lum_reader *reader, const lum_index_entry *entry)
{
    struct entry_maker *m = &reader->place.entries.sensors[entry->sensor];
    m->has_newest = lum_demux_newest(lum_framer_demux(reader->framer),
                                     entry->sensor, &m->newest);
    m->has_marked = true;
    m->marked = entry->from;
    m->active = entry->after;
}
