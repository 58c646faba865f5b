#include "reader_internal.h"

#include "capture/capture_state.h"
#include "capture/demux_state.h"
#include "framer_state.h"

#include <stdlib.h>
#include <string.h>

/* Longer states are not worth their memory. */
#define STATE_BYTES_MAX ((size_t)1024 * 1024)

/* Records between two states that are kept for sensors that appear. */
#define EARLY_RECORDS 1024u

/* Numbers of frames go round 32 bits. */
static bool is_before(uint32_t a, uint32_t b)
{
    return (a - b) >> 31 != 0;
}

/* --- The start and the end --- */

void lum_place_begin(lum_reader *reader)
{
    struct place *p = &reader->place;
    if (p->has_begun) {
        return;
    }
    p->has_begun = true;
    p->highest_ns = INT64_MIN;
    p->index.stride = p->index.stride != 0 ? p->index.stride : 1u;
    if (reader->capture == NULL || !lum_capture_can_seek(reader->capture)) {
        p->keeps_index = false;
    } else if (lum_capture_pack(reader->capture, &p->start, NULL) != 0) {
        lum_pack_reset(&p->start);
        p->keeps_index = false;
    }
    if (!lum_framer_pack_clocks(reader->framer, &p->taught)) {
        lum_pack_reset(&p->taught);
    }
    p->keeps_index = p->keeps_index && lum_framer_gives(reader->framer, 0);
}

static void drop_pending(struct followed *s)
{
    while (s->pending_count > 0) {
        lum_index_entry_free(s->pending[--s->pending_count]);
    }
}

static void forget(struct place *p)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        drop_pending(&p->sensors[i]);
        p->sensors[i] = (struct followed){.has_newest = false};
    }
    lum_pack_reset(&p->early);
    p->early_after = 0;
    p->awaited_count = 0;
    p->awaited_next = 0;
    p->is_approaching = false;
    p->is_lost = false;
    p->has_jumped = false;
}

void lum_place_free(struct place *place)
{
    forget(place);
    lum_pack_reset(&place->start);
    lum_pack_reset(&place->taught);
    lum_index_clear(&place->index);
}

/* --- Entries are made --- */

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
        e->active[i] = r->place.sensors[i].active;
    }
    return e;
}

/* The oldest of them are no longer pending. */
static void take_off(struct followed *s, size_t count)
{
    s->pending_count -= count;
    for (size_t i = 0; i < s->pending_count; i++) {
        s->pending[i] = s->pending[i + count];
    }
}

/* The oldest goes where there are too many. */
static void add_pending(struct followed *s, lum_index_entry *entry)
{
    if (s->pending_count == LUM_PLACE_PENDING_MAX) {
        lum_index_entry_free(s->pending[0]);
        take_off(s, 1);
    }
    s->pending[s->pending_count++] = entry;
}

static void note_births(lum_reader *r)
{
    struct place *p = &r->place;
    const lum_demux *demux = lum_framer_demux(r->framer);
    const lum_pack *early = p->early.len != 0 ? &p->early : &p->start;
    while (p->index.birth_count < lum_demux_sensor_count(demux)) {
        lum_index_birth *b = &p->index.births[p->index.birth_count];
        if (!copy_bytes(early, &b->capture, &b->capture_len)) {
            p->keeps_index = false;
            return;
        }
        b->after = p->early_after;
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
        lum_pack_reset(&p->early);
        p->early_after = p->records;
        if (lum_capture_pack(r->capture, &p->early, NULL) != 0 ||
            p->early.len > STATE_BYTES_MAX) {
            lum_pack_reset(&p->early);
            p->early_after = 0;
        }
    }
}

/* A frame has begun, and no line of it was handed out yet. */
static void note_begin(lum_reader *r, size_t sensor, uint32_t frame)
{
    struct followed *s = &r->place.sensors[sensor];
    const bool is_due =
        !s->has_marked || frame - s->marked >= r->place.index.stride;
    lum_index_entry *entry = is_due ? make_entry(r, sensor, frame) : NULL;
    if (entry != NULL) {
        add_pending(s, entry);
        s->has_marked = true;
        s->marked = frame;
    }
}

/* A sensor may have sent data. */
static void note_data(lum_reader *r, size_t sensor, bool may_mark)
{
    uint32_t frame = 0;
    struct followed *s = &r->place.sensors[sensor];
    s->active = r->place.records;
    if (!lum_demux_newest(lum_framer_demux(r->framer), sensor, &frame)) {
        return;
    }
    const bool rises = s->has_newest && is_before(s->newest, frame);
    s->newest = rises || !s->has_newest ? frame : s->newest;
    s->has_newest = true;
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

void lum_place_note_record(lum_reader *reader)
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
void lum_place_note_end(lum_reader *reader)
{
    struct place *p = &reader->place;
    if (lum_framer_is_skipping(reader->framer)) {
        return;
    }
    if (p->keeps_index) {
        note_births(reader);
        note_origins(reader);
    }
    p->index.is_whole |= !p->is_approaching && !p->is_lost;
}

/* Entries get the first frame that they give, and so their place in the
 * order; of several that would get one frame the last stays. */
static void finish_entries(struct place *p, struct followed *s,
                           const lum_frame_info *info,
                           const uint32_t lines[LUM_EYES])
{
    size_t done = 0;
    while (done < s->pending_count &&
           !is_before((uint32_t)info->number, s->pending[done]->from)) {
        done++;
    }
    for (size_t i = 0; i < done; i++) {
        lum_index_entry *e = s->pending[i];
        const lum_index *x = &p->index;
        e->order = p->order;
        e->number = info->number;
        e->highest_ns = p->highest_ns;
        memcpy(e->lines, lines, sizeof e->lines);
        if (i + 1u == done &&
            (x->count == 0 ||
             x->entries[x->count - 1u].entry->order < p->order)) {
            lum_index_add(&p->index, e);
        } else {
            lum_index_entry_free(e);
        }
    }
    take_off(s, done);
}

/* --- Frames come --- */

/* When a frame begins; without a line it does not. */
static bool find_begin(const lum_frame_info *info, int64_t *begin_ns)
{
    *begin_ns = info->times.begin_utc_ns != 0 ? info->times.begin_utc_ns
                                              : info->times.begin_arrival_ns;
    return info->lines[LUM_EYE_BLUE] != 0 || info->lines[LUM_EYE_GREEN] != 0;
}

static bool is_sought(const struct target *t, const lum_frame_info *info,
                      uint64_t order)
{
    int64_t begin_ns = 0;
    switch (t->what) {
    case SOUGHT_ORDER:
        return order >= t->order;
    case SOUGHT_NUMBER:
        return info->sensor == t->sensor && info->sensor_interface[0] == '\0' &&
               !is_before((uint32_t)info->number, (uint32_t)t->number);
    case SOUGHT_TIME:
        return find_begin(info, &begin_ns) && begin_ns >= t->time_ns;
    case SOUGHT_NOTHING:
    default:
        return true;
    }
}

/* Whether the first frame that comes whole is there. */
static bool arrives(struct place *p, size_t sensor, int64_t number)
{
    if (sensor != p->anchor.sensor ||
        is_before((uint32_t)number, p->anchor.from)) {
        return false;
    }
    p->is_approaching = false;
    p->order = p->anchor.order;
    p->highest_ns = p->anchor.highest_ns;
    return true;
}

static void note_frame(struct place *p, struct followed *s,
                       const lum_frame_info *info)
{
    int64_t begin_ns = 0;
    s->has_last = true;
    s->last = info->number;
    p->order++;
    p->index.frames = p->order > p->index.frames ? p->order : p->index.frames;
    if (find_begin(info, &begin_ns) && begin_ns > p->highest_ns) {
        p->highest_ns = begin_ns;
    }
}

/* Returns whether it is to be told. */
static bool take_frame(lum_reader *r)
{
    struct place *p = &r->place;
    const size_t sensor = lum_framer_sensor(r->framer);
    struct followed *s = &p->sensors[sensor];
    uint32_t lines[LUM_EYES];
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(lum_framer_frame(r->framer, 0), &info);
    memcpy(lines, s->lines, sizeof lines);
    lum_framer_get_lines(r->framer, sensor, s->lines);
    if (p->is_approaching && !arrives(p, sensor, info.number)) {
        return false;
    }
    finish_entries(p, s, &info, lines);
    const bool is_told = is_sought(&p->target, &info, p->order);
    note_frame(p, s, &info);
    if (is_told) {
        p->target.what = SOUGHT_NOTHING;
    }
    return is_told;
}

bool lum_place_shows(lum_reader *reader, lum_framer_event event)
{
    if (event == LUM_FRAMER_FRAME) {
        return take_frame(reader);
    }
    return reader->place.target.what == SOUGHT_NOTHING ||
           event == LUM_FRAMER_FAILED;
}

/* --- Going to another place --- */

/* As where the first record comes next. */
static int restart(lum_reader *r, lum_error *error)
{
    struct place *p = &r->place;
    lum_pack taught = lum_pack_of(p->taught.written, p->taught.len);
    lum_pack start = lum_pack_of(p->start.written, p->start.len);
    lum_framer_restart(r->framer);
    if (p->taught.len != 0 && !lum_framer_pack_clocks(r->framer, &taught)) {
        return lum_error_set(error, "out of memory");
    }
    forget(p);
    p->records = 0;
    p->order = 0;
    p->highest_ns = INT64_MIN;
    r->stage = READING;
    r->status = 0;
    r->record = (lum_record){.kind = LUM_RECORD_OTHER};
    return p->start.len != 0 ? lum_capture_pack(r->capture, &start, error)
                             : lum_reader_reopen(r, error);
}

/* Each sensor needs the state before its own frame. */
static void await(lum_reader *r, size_t sensor)
{
    struct place *p = &r->place;
    const lum_index_birth *birth = &p->index.births[sensor];
    const lum_index_entry *entry =
        lum_index_of(&p->index, (uint32_t)sensor, p->anchor.order);
    const struct awaited a = {.sensor = (uint32_t)sensor,
                              .after =
                                  entry != NULL ? entry->after : birth->after,
                              .entry = entry,
                              .birth = birth};
    size_t at = p->awaited_count++;
    while (at > 0 && p->awaited[at - 1u].after > a.after) {
        p->awaited[at] = p->awaited[at - 1u];
        at--;
    }
    p->awaited[at] = a;
    lum_demux_hold(lum_framer_sensors(r->framer), sensor, true);
}

/* As near before a record as it is sure whose data comes. */
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

static int jump(lum_reader *r, const lum_index_entry *to, lum_error *error)
{
    struct place *p = &r->place;
    const lum_index_entry anchor = *to;
    if (restart(r, error) != 0) {
        return -1;
    }
    p->has_jumped = true;
    p->anchor = anchor;
    p->anchor.capture = NULL;
    p->anchor.state = NULL;
    p->is_approaching = true;
    for (size_t i = 0; i < p->index.birth_count; i++) {
        if (anchor.active[i] != 0 && lum_framer_gives(r->framer, i)) {
            await(r, i);
        }
    }
    return p->awaited_count != 0 ? move_capture(r, p->awaited[0].after, error)
                                 : -1;
}

/* From the start, up to the present place, or to what is sought. */
static int read_again(lum_reader *r, lum_error *error)
{
    const struct place *p = &r->place;
    const struct target target =
        p->target.what != SOUGHT_NOTHING
            ? p->target
            : (struct target){.what = SOUGHT_ORDER, .order = p->order};
    const int result = restart(r, error);
    r->place.target = target;
    return result;
}

/* An index that is of no use is dropped. */
static int go_without_index(lum_reader *r, lum_error *error)
{
    lum_index_clear(&r->place.index);
    return read_again(r, error);
}

static bool load(lum_reader *r, const struct awaited *a)
{
    struct place *p = &r->place;
    struct followed *s = &p->sensors[a->sensor];
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
    s->has_newest =
        lum_demux_newest(lum_framer_demux(r->framer), a->sensor, &s->newest);
    s->has_marked = true;
    s->marked = a->entry->from;
    s->active = a->after;
    return true;
}

/* Whether no sensor that has its state sends before the next one gets its: as
 * far as is known, up to the anchor. */
static bool is_idle(const lum_reader *r)
{
    const struct place *p = &r->place;
    const struct awaited *next = &p->awaited[p->awaited_next];
    if (next->after <= p->records || next->after > p->anchor.after ||
        !lum_index_is_certain(&p->index, next->after) ||
        lum_demux_is_behind(lum_framer_demux(r->framer))) {
        return false;
    }
    for (size_t i = 0; i < p->awaited_next; i++) {
        if (p->anchor.active[p->awaited[i].sensor] > p->records) {
            return false;
        }
    }
    return true;
}

static int approach(lum_reader *reader, lum_error *error)
{
    struct place *p = &reader->place;
    lum_error reason = {""};
    while (p->awaited_next < p->awaited_count) {
        const struct awaited *a = &p->awaited[p->awaited_next];
        if (a->after == p->records) {
            if (!load(reader, a)) {
                return go_without_index(reader, error);
            }
            p->awaited_next++;
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
    const struct place *p = &reader->place;
    if (lum_demux_is_unsure(lum_framer_demux(reader->framer))) {
        return read_again(reader, error);
    }
    return p->awaited_next < p->awaited_count ? approach(reader, error) : 0;
}

/* --- What callers seek --- */

static int refuse(const lum_reader *r, lum_error *error)
{
    if (r->go_on.has_stopped) {
        return lum_error_set(error, "%s", LUM_GO_ON_STOPPED);
    }
    if (r->capture == NULL) {
        return lum_error_set(error, "records that are no capture cannot be "
                                    "sought in");
    }
    return lum_framer_gives(r->framer, 0)
               ? 0
               : lum_error_set(error, "a reader that gives no frames cannot "
                                      "seek one; lum_framer_options.wants");
}

static int fail_to_restart(const lum_reader *r, lum_error *error)
{
    lum_capture_source source = {.struct_size = sizeof source};
    (void)lum_capture_get_source(r->capture, 0, &source);
    return lum_error_set(error,
                         "%s: cannot be read again from its start; only "
                         "frames behind the present one can be sought",
                         source.name);
}

/* All frames of it are known, and the sought one is not among them. */
static bool is_beyond(const struct place *p, const struct target *target)
{
    return p->index.is_whole && target->what == SOUGHT_ORDER &&
           target->order >= p->index.frames;
}

static void end_at_once(lum_reader *r)
{
    r->stage = ENDED;
    r->status = 0;
    r->place.is_lost = true;
    r->place.target.what = SOUGHT_NOTHING;
}

static int fail_seek(lum_reader *r, const lum_error *reason, lum_error *error)
{
    end_at_once(r);
    r->status = -1;
    r->error = *reason;
    return lum_error_set(error, "%s", reason->text);
}

/* is_ahead: the present place is before the target too. */
static int seek(lum_reader *r, const struct target *target,
                const lum_index_entry *entry, bool is_ahead, lum_error *error)
{
    struct place *p = &r->place;
    lum_error reason = {""};
    int result = 0;
    is_ahead = is_ahead && !p->is_approaching && !p->is_lost;
    if (is_beyond(p, target)) {
        end_at_once(r);
        return 0;
    }
    if (entry != NULL && (!is_ahead || entry->order > p->order)) {
        result = jump(r, entry, NULL);
        result = result == 0 ? 0 : go_without_index(r, &reason);
    } else if (!is_ahead) {
        if (p->start.len == 0 && r->paths == NULL) {
            return fail_to_restart(r, error);
        }
        result = restart(r, &reason);
    }
    if (result != 0) {
        return fail_seek(r, &reason, error);
    }
    p->target = *target;
    return 0;
}

static int begin_seek(lum_reader *r, lum_error *error)
{
    if (refuse(r, error) != 0) {
        return -1;
    }
    lum_place_begin(r);
    return 0;
}

int lum_reader_seek_frame(lum_reader *reader, uint64_t frame, lum_error *error)
{
    const struct target target = {.what = SOUGHT_ORDER, .order = frame};
    if (begin_seek(reader, error) != 0) {
        return -1;
    }
    return seek(reader, &target, lum_index_at(&reader->place.index, frame),
                reader->place.order <= frame, error);
}

/* The sensor's index; LUM_DEMUX_SENSORS_MAX: it is not known. */
static size_t find_sensor(const lum_index *index, uint32_t address)
{
    size_t i = 0;
    while (i < index->origin_count && index->origins[i].is.address != address) {
        i++;
    }
    return i < index->origin_count ? index->origins[i].is.sensor
                                   : LUM_DEMUX_SENSORS_MAX;
}

int lum_reader_seek_number(lum_reader *reader, uint32_t sensor, int64_t number,
                           lum_error *error)
{
    struct place *p = &reader->place;
    const struct target target = {
        .what = SOUGHT_NUMBER, .sensor = sensor, .number = number};
    if (begin_seek(reader, error) != 0) {
        return -1;
    }
    if (number < 0 || number > UINT32_MAX) {
        return lum_error_set(error, "a frame's number is from 0 to 4294967295");
    }
    const lum_demux *demux = lum_framer_demux(reader->framer);
    const size_t count = lum_demux_sensor_count(demux);
    bool is_ahead = !p->has_jumped;
    size_t i = 0;
    while (i < count && lum_demux_address(demux, i) != sensor) {
        i++;
    }
    if (i < count && p->sensors[i].has_last) {
        is_ahead = is_before((uint32_t)p->sensors[i].last, (uint32_t)number);
    }
    i = find_sensor(&p->index, sensor);
    return seek(reader, &target,
                lum_index_at_number(&p->index, (uint32_t)i, number), is_ahead,
                error);
}

int lum_reader_seek_time(lum_reader *reader, int64_t utc_ns, lum_error *error)
{
    struct place *p = &reader->place;
    const struct target target = {.what = SOUGHT_TIME, .time_ns = utc_ns};
    if (begin_seek(reader, error) != 0) {
        return -1;
    }
    return seek(reader, &target, lum_index_at_time(&p->index, utc_ns),
                p->highest_ns < utc_ns, error);
}
