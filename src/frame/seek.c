/* Seeks a frame: decides by the index whether to jump, to begin again or to
 * read on (reader_place.c does it), and holds back what comes before the frame.
 */
#include "framer_state.h"
#include "reader_internal.h"

#include "capture/capture_internal.h"

#include <string.h>

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
               !lum_frame_is_before(info->number, t->number);
    case SOUGHT_TIME:
        return find_begin(info, &begin_ns) && begin_ns >= t->time_ns;
    case SOUGHT_NOTHING:
    default:
        return true;
    }
}

static void note_frame(struct place *p, struct last_frame *last,
                       const lum_frame_info *info)
{
    int64_t begin_ns = 0;
    last->is_there = true;
    last->number = info->number;
    p->frames.order++;
    p->index.frames =
        p->frames.order > p->index.frames ? p->frames.order : p->index.frames;
    if (find_begin(info, &begin_ns) && begin_ns > p->frames.highest_ns) {
        p->frames.highest_ns = begin_ns;
    }
}

/* Returns whether it is to be told. */
static bool take_frame(lum_reader *r)
{
    struct place *p = &r->place;
    const size_t sensor = lum_framer_sensor(r->framer);
    struct last_frame *last = &p->frames.last[sensor];
    uint32_t lines[LUM_EYES];
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(lum_framer_frame(r->framer, 0), &info);
    memcpy(lines, last->lines, sizeof lines);
    lum_framer_get_lines(r->framer, sensor, last->lines);
    if (!lum_place_is_reached(p, sensor, info.number)) {
        return false;
    }
    lum_index_entries_finish(p, sensor, info.number, lines);
    const bool is_told = is_sought(&p->target, &info, p->frames.order);
    note_frame(p, last, &info);
    if (is_told) {
        p->target.what = SOUGHT_NOTHING;
    }
    return is_told;
}

bool lum_seek_shows(lum_reader *reader, lum_framer_event event)
{
    if (event == LUM_FRAMER_FRAME) {
        return take_frame(reader);
    }
    return reader->place.target.what == SOUGHT_NOTHING ||
           event == LUM_FRAMER_FAILED;
}

/* --- What callers seek --- */

static int begin_seek(lum_reader *r, lum_error *error)
{
    if (r->go_on.has_stopped) {
        return lum_go_on_fail(error);
    }
    if (r->capture == NULL) {
        return lum_error_set(error, "only a reader of captures can seek; this "
                                    "one was opened on records");
    }
    if (!lum_framer_gives(r->framer, 0)) {
        return lum_error_set(error, "a reader that gives no frames cannot seek "
                                    "one; see lum_framer_options.wants");
    }
    lum_place_begin(r);
    return 0;
}

static int fail_to_restart(const lum_reader *r, lum_error *error)
{
    lum_capture_source source = {.struct_size = sizeof source};
    (void)lum_capture_get_source(r->capture, 0, &source);
    return lum_error_set(error,
                         "%s: cannot be read again from its start; only later "
                         "frames can be sought",
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
    r->place.frames.is_lost = true;
    r->place.target.what = SOUGHT_NOTHING;
}

static int fail_seek(lum_reader *r, const lum_error *reason, lum_error *error)
{
    end_at_once(r);
    r->status = -1;
    r->error = *reason;
    return lum_error_set(error, "%s", reason->text);
}

/* The shortest way that gives the sought frame and all behind it.
 * 1. All frames are known, and it is not among them: the reading ends.
 * 2. An entry is before the target, and reading on from here would be longer:
 *    jump to it.
 * 3. The present place is behind the target: read from the first record.
 * 4. Else read on. Frames before the target are held back.
 * is_ahead: the present place is before the target too. */
static int seek(lum_reader *r, const struct target *target,
                const lum_index_entry *entry, bool is_ahead, lum_error *error)
{
    struct place *p = &r->place;
    lum_error reason = {""};
    int result = 0;
    is_ahead = is_ahead && !p->jump.is_approaching && !p->frames.is_lost;
    if (is_beyond(p, target)) {
        end_at_once(r);
        return 0;
    }
    if (entry != NULL && (!is_ahead || entry->order > p->frames.order)) {
        result = lum_place_jump(r, entry, &reason);
    } else if (!is_ahead) {
        if (p->start.len == 0 && r->paths == NULL) {
            return fail_to_restart(r, error);
        }
        result = lum_place_restart(r, &reason);
    }
    if (result != 0) {
        return fail_seek(r, &reason, error);
    }
    p->target = *target;
    return 0;
}

int lum_reader_seek_frame(lum_reader *reader, uint64_t frame, lum_error *error)
{
    const struct target target = {.what = SOUGHT_ORDER, .order = frame};
    if (begin_seek(reader, error) != 0) {
        return -1;
    }
    return seek(
        reader, &target,
        lum_index_of(&reader->place.index, LUM_DEMUX_SENSORS_MAX, frame),
        reader->place.frames.order <= frame, error);
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
    bool is_ahead = !p->jump.is_made;
    size_t i = 0;
    while (i < count && lum_demux_address(demux, i) != sensor) {
        i++;
    }
    if (i < count && p->frames.last[i].is_there) {
        is_ahead = lum_frame_is_before(p->frames.last[i].number, number);
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
                p->frames.highest_ns < utc_ns, error);
}
