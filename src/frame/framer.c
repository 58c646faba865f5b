/* Lines and ends of frames come in, frames go out. What makes a frame end is
 * decided in core/frames.c and core/assembler.c. */
#include "framer_internal.h"
#include "framer_state.h"

#include "base/sized.h"

#include <string.h>

/* --- What the options select --- */

static bool is_selected(const lum_framer *f, int64_t number)
{
    const lum_framer_choice *c = &f->choice;
    return !c->has_range ||
           (number >= c->frame_first && number <= c->frame_last);
}

static bool is_line_selected(const lum_framer *f, const lum_line *line)
{
    const bool is_whole =
        line->angle_count == LUM_LINE_PIXELS && line->lost_words == 0;
    return (f->choice.eyes >> line->eye & 1u) != 0 &&
           is_selected(f, line->frame) &&
           (is_whole || !f->choice.drop_incomplete);
}

static bool is_skipped(const lum_framer *f, int64_t number)
{
    return f->has_from && number < f->from;
}

/* The sensor of the latest event; NULL without memory. */
static lum_sensor_stream *current(lum_framer *f)
{
    const size_t i = lum_demux_current_index(f->demux);
    const bool is_new = f->sensors[i] == NULL;
    lum_sensor_stream *s =
        lum_sensor_stream_at(f, i, lum_sensor_stream_way(f, i));
    if (s != NULL && is_new && f->is_flushing) {
        lum_under_way_leave(&s->under_way);
    }
    return s;
}

/* --- A line that was handed out --- */

/* Its points, before and after the selection. */
static void count_points(lum_framer *f, lum_sensor_stream *s)
{
    lum_framer_counters *c = &s->counters;
    lum_line_points *p = &f->line;
    lum_line_points_count(p);
    c->rising += p->rising;
    c->falling += p->falling;
    c->losses.no_angle += p->losses.no_angle;
    c->losses.no_range += p->losses.no_range;
    f->is_wanted = is_line_selected(f, p->line);
    if (f->is_wanted) {
        f->selected = lum_line_points_select(
            p, f->views.count > 0 ? &f->views.view[0] : NULL);
        c->points += f->selected;
    }
}

static void take_line(lum_framer *f, lum_sensor_stream *s)
{
    const lum_assembler *assembler = lum_demux_current(f->demux);
    const lum_line *line = lum_assembler_line(assembler);
    f->in_hand = IN_HAND_NOTHING;
    f->number = line->frame;
    lum_line_points_begin(&f->line, line, &f->ways[s->way].projector);
    if (f->watch != NULL) {
        f->line.packets = lum_raw_watch_take(
            f->watch, lum_demux_current_index(f->demux), line);
    }
    lum_sensor_stream_take(s, line, lum_assembler_line_is_decided(assembler));
    if (is_skipped(f, line->frame)) {
        lum_under_way_take(&s->under_way, line, 0);
        return;
    }
    count_points(f, s);
    lum_under_way_take(&s->under_way, line, f->line.losses.no_angle);
    if (f->is_wanted || (f->choice.wants & LUM_WANT_ALL_LINES) != 0) {
        f->in_hand = IN_HAND_LINE;
    }
}

/* Hand out a frame, if frames are made; its draft is free then. */
static lum_framer_event hand_out(lum_framer *f, lum_sensor_stream *s,
                                 lum_draft *draft)
{
    lum_sensor_stream_seal(f, s, draft);
    if (!lum_framer_makes_frames(f)) {
        lum_draft_drop(draft);
        return LUM_FRAMER_NONE;
    }
    f->number = draft->number;
    f->out = *draft;
    draft->is_used = false;
    draft->frame_count = 0;
    return LUM_FRAMER_FRAME;
}

/* --- A line into its frame --- */

static bool is_late(const lum_sensor_stream *s, int64_t number)
{
    return s->has_done && !lum_frame_is_before(s->done, number);
}

static void count_late(const lum_framer *f, lum_sensor_stream *s)
{
    if (lum_framer_makes_frames(f)) {
        s->lines_late++;
        s->counters.lines_late++;
        s->counters.points_late += f->selected;
    }
}

/* Put the line in its frame. If too many frames are open, the lowest is handed
 * out first. */
static lum_framer_event place_line(lum_framer *f, lum_sensor_stream *s)
{
    const int64_t number = f->line.line->frame;
    lum_draft *draft = lum_drafts_find(&s->drafts, number);
    if (is_late(s, number)) {
        count_late(f, s);
        return LUM_FRAMER_NONE;
    }
    if (draft == NULL) {
        draft = lum_drafts_find_unused(&s->drafts);
        if (draft == NULL) {
            draft = lum_drafts_find_lowest(&s->drafts);
            const lum_framer_event event = hand_out(f, s, draft);
            if (event != LUM_FRAMER_NONE) {
                return event;
            }
        }
        if (!lum_sensor_stream_begin(f, s, draft, number, false)) {
            return LUM_FRAMER_FAILED;
        }
    }
    return lum_draft_add(draft, &f->line, f->threads,
                         lum_framer_makes_frames(f))
               ? LUM_FRAMER_NONE
               : LUM_FRAMER_FAILED;
}

static lum_framer_event go_on_with_line(lum_framer *f, lum_sensor_stream *s)
{
    const unsigned told =
        f->is_wanted ? (unsigned)LUM_WANT_LINES | (unsigned)LUM_WANT_ALL_LINES
                     : (unsigned)LUM_WANT_ALL_LINES;
    if (f->is_wanted) {
        const lum_framer_event event = place_line(f, s);
        if (event != LUM_FRAMER_NONE) {
            return event;
        }
    }
    f->in_hand = IN_HAND_NOTHING;
    f->number = f->line.line->frame;
    return (f->choice.wants & told) != 0 ? LUM_FRAMER_LINE : LUM_FRAMER_NONE;
}

/* --- Ends of frames --- */

/* The frame that is complete; empty if none of its lines came. */
static lum_framer_event hand_out_end(lum_framer *f, lum_sensor_stream *s,
                                     int64_t number)
{
    lum_draft *lowest = NULL;
    while ((lowest = lum_drafts_find_lowest(&s->drafts)) != NULL &&
           !lum_frame_is_before(number, lowest->number)) {
        const lum_framer_event event = hand_out(f, s, lowest);
        if (event != LUM_FRAMER_NONE) {
            return event;
        }
    }
    if (is_late(s, number) || !is_selected(f, number)) {
        return LUM_FRAMER_NONE;
    }
    lum_draft *draft = lum_drafts_find_unused(&s->drafts);
    if (draft == NULL) {
        return LUM_FRAMER_NONE;
    }
    return lum_sensor_stream_begin(f, s, draft, number, true)
               ? hand_out(f, s, draft)
               : LUM_FRAMER_FAILED;
}

static lum_framer_event go_on_with_end(lum_framer *f, lum_sensor_stream *s)
{
    const int64_t number = lum_assembler_frame(lum_demux_current(f->demux));
    s->first = s->has_range ? s->first : number;
    s->last = number;
    s->has_range = true;
    if (is_skipped(f, number)) {
        f->in_hand = IN_HAND_NOTHING;
        return LUM_FRAMER_NONE;
    }
    const lum_framer_event event = hand_out_end(f, s, number);
    if (event != LUM_FRAMER_NONE) {
        return event;
    }
    f->in_hand = IN_HAND_NOTHING;
    f->number = number;
    s->counters.frames += is_selected(f, number) ? 1u : 0u;
    return (f->choice.wants & LUM_WANT_FRAME_ENDS) != 0 ? LUM_FRAMER_FRAME_END
                                                        : LUM_FRAMER_NONE;
}

/* --- Events --- */

static lum_framer_event go_on_with_new(lum_framer *f, lum_sensor_stream *s)
{
    take_line(f, s);
    return f->in_hand == IN_HAND_LINE ? go_on_with_line(f, s) : LUM_FRAMER_NONE;
}

/* Go on with what is in hand. */
static lum_framer_event go_on(lum_framer *f)
{
    if (f->in_hand == IN_HAND_NOTHING) {
        return LUM_FRAMER_NONE;
    }
    lum_sensor_stream *s = current(f);
    if (s == NULL) {
        return LUM_FRAMER_FAILED;
    }
    switch (f->in_hand) {
    case IN_HAND_NEW:
        return go_on_with_new(f, s);
    case IN_HAND_LINE:
        return go_on_with_line(f, s);
    case IN_HAND_END:
        return go_on_with_end(f, s);
    case IN_HAND_NOTHING:
    default:
        return LUM_FRAMER_NONE;
    }
}

static lum_framer_event take(lum_framer *f, lum_result event)
{
    if (f->choice.only_first && lum_demux_current_index(f->demux) > 0) {
        return LUM_FRAMER_NONE;
    }
    switch (event) {
    case LUM_LINE_READY:
        f->in_hand = IN_HAND_NEW;
        break;
    case LUM_FRAME_READY:
        f->in_hand = IN_HAND_END;
        break;
    case LUM_OK:
    case LUM_END:
    case LUM_E_SHORT:
    case LUM_E_SPACE:
    case LUM_E_VALUE:
    case LUM_E_FOREIGN:
    case LUM_E_TYPE:
    case LUM_E_MALFORMED:
    case LUM_E_UNKNOWN_TAG:
    case LUM_E_STRAY:
    case LUM_E_LATE:
    case LUM_E_DUPLICATE:
    case LUM_E_CONFLICT:
    case LUM_E_NO_ROOM:
    case LUM_E_ORDER:
    default: /* no event */
        break;
    }
    return go_on(f);
}

/* Records come again. */
static void end_flush(lum_framer *f)
{
    f->is_flushing = false;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_under_way_join(&f->sensors[i]->under_way);
            lum_pause_join(&f->sensors[i]->pause);
            f->sensors[i]->has_joined = false;
        }
    }
}

void lum_framer_set_interface(lum_framer *framer, const char *name)
{
    lum_demux_set_interface(framer->demux, name);
}

/* A data packet was taken; those that end no line have stamps, too. */
static void note_stamp(lum_framer *f, int64_t time_ns)
{
    size_t i = 0;
    const lum_sensor_stream *s =
        lum_demux_sender(f->demux, &i) ? f->sensors[i] : NULL;
    if (s != NULL && s->clock != NULL) {
        lum_clock_fit_note_stamp(s->clock, time_ns);
    }
}

lum_framer_event lum_framer_push(lum_framer *framer, const lum_record *record,
                                 lum_packet_kind *kind)
{
    lum_packet_kind own = LUM_PACKET_KINDS;
    lum_packet_kind *its = kind != NULL ? kind : &own;
    lum_result r = LUM_OK;
    lum_draft_drop(&framer->out);
    lum_framer_event event = go_on(framer);
    if (framer->is_flushing && event == LUM_FRAMER_NONE) {
        end_flush(framer);
    }
    while (event == LUM_FRAMER_NONE &&
           (r = lum_demux_push(framer->demux, record, its)) > 0) {
        event = take(framer, r);
    }
    if (event == LUM_FRAMER_NONE && r == LUM_OK && *its == LUM_PACKET_DATA) {
        note_stamp(framer, record->time_ns);
    }
    return r >= 0 ? event : LUM_FRAMER_FAILED;
}

/* All lines are there. */
static void end_pauses(lum_framer *f)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_pause_end(&f->sensors[i]->pause);
        }
    }
}

static void begin_flush(lum_framer *f)
{
    f->is_flushing = true;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_under_way_leave(&f->sensors[i]->under_way);
        }
    }
}

lum_framer_event lum_framer_flush(lum_framer *framer)
{
    lum_result r = LUM_OK;
    lum_draft_drop(&framer->out);
    lum_framer_event event = go_on(framer);
    if (!framer->is_flushing) {
        begin_flush(framer);
    }
    while (event == LUM_FRAMER_NONE &&
           (r = lum_demux_flush(framer->demux)) > 0) {
        event = take(framer, r);
    }
    if (event == LUM_FRAMER_NONE) {
        end_pauses(framer);
    }
    return r >= 0 ? event : LUM_FRAMER_FAILED;
}

/* --- Skipping --- */

void lum_framer_skip_to(lum_framer *framer, int64_t frame)
{
    lum_line_threads_settle(framer->threads);
    framer->has_from = true;
    framer->from = frame;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        lum_sensor_stream *s = framer->sensors[i];
        if (s != NULL) {
            lum_drafts_drop_below(&s->drafts, frame);
            memset(s->before.lines, 0, sizeof s->before.lines);
            s->lines_late = 0;
        }
    }
}

/* --- What the last event is about --- */

const lum_line *lum_framer_line(const lum_framer *framer)
{
    return framer->line.line;
}

bool lum_framer_line_is_wanted(const lum_framer *framer)
{
    return framer->is_wanted;
}

size_t lum_framer_line_samples(lum_framer *framer, size_t view,
                               const lum_sample **out)
{
    const lum_checked_view *checked =
        view < framer->views.count ? &framer->views.view[view] : NULL;
    if (out == NULL) {
        return checked != NULL
                   ? (size_t)lum_line_points_select(&framer->line, checked)
                   : 0;
    }
    *out = framer->line.work.sample;
    return checked != NULL ? lum_line_points_sample(&framer->line, checked) : 0;
}

const lum_frame *lum_framer_frame(const lum_framer *framer, size_t view)
{
    return view < framer->out.frame_count ? framer->out.frames[view] : NULL;
}

bool lum_framer_frame_view(const lum_framer *framer, size_t view, lum_view *out)
{
    if (view >= framer->out.views.count || framer->out.frame_count == 0) {
        return false;
    }
    const lum_view *asked = &framer->out.views.view[view].asked;
    return lum_sized_fill(out, asked, sizeof *asked);
}

void lum_framer_leave(lum_framer *framer, unsigned leaves)
{
    framer->line.leaves = leaves;
}

int64_t lum_framer_frame_number(const lum_framer *framer)
{
    return framer->number;
}

size_t lum_framer_sensor(const lum_framer *framer)
{
    return lum_demux_current_index(framer->demux);
}

int lum_framer_member(const lum_framer *framer, size_t sensor)
{
    return framer->member_count != 0 &&
                   sensor < lum_demux_sensor_count(framer->demux)
               ? lum_demux_member_of(framer->demux, sensor)
               : -1;
}

const lum_demux *lum_framer_demux(const lum_framer *framer)
{
    return framer->demux;
}
