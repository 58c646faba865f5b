/* One sensor of a framer: its clock and pauses, its counters, and what a frame
 * of it lacks when it ends. */
#include "framer_internal.h"

#include "base/sized.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- A sensor --- */

size_t lum_sensor_stream_way(const lum_framer *f, size_t i)
{
    const int member =
        f->member_count != 0 ? lum_demux_member_of(f->demux, i) : 0;
    return member > 0 ? (size_t)member : 0;
}

lum_sensor_stream *lum_sensor_stream_at(lum_framer *f, size_t i, size_t way)
{
    const bool has_clock = f->ways[way].has_clock;
    lum_sensor_stream *s = f->sensors[i];
    if (s != NULL) {
        return s;
    }
    s = calloc(1, sizeof *s);
    if (s == NULL) {
        return NULL;
    }
    s->way = way;
    s->pause = f->ways[way].pause;
    s->clock = has_clock ? lum_clock_fit_new() : NULL;
    if (has_clock && s->clock == NULL) {
        free(s);
        return NULL;
    }
    f->sensors[i] = s;
    return s;
}

void lum_sensor_stream_free(lum_sensor_stream *s)
{
    if (s != NULL) {
        lum_drafts_drop_below(&s->drafts, INT64_MAX);
        lum_clock_fit_free(s->clock);
        free(s);
    }
}

/* A line of a frame, whose first packet came at a time. */
static void take_pace(lum_pace *p, int64_t frame, int64_t time_ns)
{
    if (p->has_frame && frame <= p->frame) {
        return;
    }
    if (p->has_frame && !p->has_begin) {
        p->has_begin = true;
        p->first = frame;
        p->first_ns = time_ns;
    }
    p->has_frame = true;
    p->frame = frame;
    p->last_ns = time_ns;
}

/* Frames a second; 0: no whole frame came. */
static double rate_of(const lum_pace *p)
{
    return p->has_begin && p->last_ns > p->first_ns
               ? (double)(p->frame - p->first) /
                     ((double)(p->last_ns - p->first_ns) * 1e-9)
               : 0.0;
}

void lum_sensor_stream_take(lum_sensor_stream *s, const lum_line *line,
                            bool is_decided)
{
    s->counters.lines[line->eye]++;
    if (!s->has_joined) {
        s->has_joined = true;
        s->joined = line->frame;
    }
    take_pace(&s->pace, line->frame, line->arrival);
    lum_pause_take(&s->pause, line, is_decided);
    if (s->clock != NULL) {
        (void)lum_clock_fit_add(s->clock, line->clock_us, line->arrival);
    }
}

/* --- A frame: its beginning and its end --- */

bool lum_sensor_stream_begin(const lum_framer *f, const lum_sensor_stream *s,
                             lum_draft *draft, int64_t number, bool is_empty)
{
    return lum_draft_begin(draft, number,
                           lum_framer_makes_frames(f) ? &f->views : NULL,
                           f->pool, is_empty ? NULL : s->drafts.recent_points);
}

/* Once it is past a jump, the frame before it has not all of its lines here. */
static void take_next(lum_lines_before *before, int64_t number)
{
    if (before->has_next && !lum_frame_is_before(number, before->next_from)) {
        memcpy(before->lines, before->next, sizeof before->lines);
        before->has_next = false;
    }
}

static void count_missing(lum_framer_counters *c, const lum_frame_info *info)
{
    const uint64_t lines = (uint64_t)info->lines_missing[LUM_EYE_BLUE] +
                           info->lines_missing[LUM_EYE_GREEN];
    c->lines_missing += lines;
    c->missing_under_way += info->is_first || info->is_last ? lines : 0;
}

/* What only the framer knows of a frame. */
static void describe(const lum_framer *f, const lum_sensor_stream *s,
                     int64_t number, lum_frame *frame)
{
    const size_t sensor = lum_demux_current_index(f->demux);
    const lum_member_way *way = &f->ways[s->way];
    lum_frame_info *out = &frame->info;
    frame->pose = way->pose;
    frame->is_placed = way->is_placed;
    out->member = f->member_count != 0 ? (uint32_t)s->way + 1u : 0;
    out->number = number;
    out->sensor = lum_demux_address(f->demux, sensor);
    (void)snprintf(out->sensor_interface, sizeof out->sensor_interface, "%s",
                   lum_demux_further(f->demux, sensor));
    out->is_first = s->has_joined && !lum_frame_is_before(s->joined, number);
    out->is_last = f->is_flushing;
}

void lum_sensor_stream_seal(lum_framer *f, lum_sensor_stream *s,
                            lum_draft *draft)
{
    const lum_frame *first = draft->frames[0];
    const lum_frame_info *info = &first->info;
    lum_frame_end end = {.has_clock = f->ways[s->way].has_clock,
                         .clock = s->clock,
                         .lines_late = s->lines_late};
    lum_line_threads_settle(f->threads);
    if (f->is_flushing) {
        lum_pause_end(&s->pause);
    }
    end.has_pause =
        lum_pause_frame_ends(&s->pause, (uint32_t)draft->number, f->choice.eyes,
                             f->is_flushing, &end.lines_in_pauses);
    take_next(&s->before, draft->number);
    memcpy(end.lines_max, s->before.lines, sizeof end.lines_max);
    for (size_t i = 0; i < draft->frame_count; i++) {
        describe(f, s, draft->number, draft->frames[i]);
        lum_frame_seal(draft->frames[i], &end);
    }
    if (lum_framer_makes_frames(f)) {
        s->counters.points_cut += info->points_cut;
        s->counters.lines_cut += info->lines_cut;
    }
    count_missing(&s->counters, info);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        s->before.lines[eye] = lum_frame_whole_rows(first, eye);
    }
    lum_drafts_note_sizes(&s->drafts, draft);
    s->lines_late = 0;
    s->has_done = true;
    s->done = draft->number;
}

/* --- Lines under way when a stream is joined or left --- */

static void count(lum_under_way *all, const lum_under_way *line,
                  const lum_under_way *instead_of)
{
    all->lines += line->lines - instead_of->lines;
    all->words += line->words - instead_of->words;
    all->no_angle += line->no_angle - instead_of->no_angle;
}

void lum_under_way_take(lum_under_way_state *u, const lum_line *line,
                        uint64_t no_angle)
{
    lum_under_way *last = &u->last[line->eye];
    const lum_under_way lacks = {
        .lines = line->angle_count < LUM_LINE_PIXELS ? 1u : 0u,
        .words = line->lost_words,
        .no_angle = no_angle};
    if (!u->has_joined[line->eye]) {
        u->has_joined[line->eye] = true;
        count(&u->counts, &lacks, &(lum_under_way){.lines = 0});
    } else if (u->is_leaving) {
        count(&u->counts, &lacks, last);
        *last = lacks;
    }
}

void lum_under_way_leave(lum_under_way_state *u)
{
    u->is_leaving = true;
}

void lum_under_way_join(lum_under_way_state *u)
{
    *u = (lum_under_way_state){.counts = u->counts};
}

/* --- What is known of a sensor --- */

/* NULL: no line of it came. */
static const lum_sensor_stream *find(const lum_framer *f, size_t sensor)
{
    return sensor < LUM_DEMUX_SENSORS_MAX ? f->sensors[sensor] : NULL;
}

/* One of each break. */
static uint64_t count_stray(const lum_framer *f, size_t sensor)
{
    const uint64_t breaks = f->sensors[sensor]->pause.counts.breaks;
    lum_demux_counters c = {.struct_size = sizeof c};
    (void)lum_demux_count(f->demux, sensor, &c);
    return breaks < c.assembly.stray ? breaks : c.assembly.stray;
}

lum_result lum_framer_count(const lum_framer *framer, size_t sensor,
                            lum_framer_counters *out)
{
    lum_framer_counters counters = {.struct_size = sizeof counters};
    const lum_sensor_stream *s = find(framer, sensor);
    if (s != NULL) {
        counters = s->counters;
        counters.under_way = s->under_way.counts;
        counters.pauses = s->pause.counts.pauses;
        counters.paused_us = s->pause.counts.paused_us;
        counters.lines_in_pauses = s->pause.counts.lines;
        counters.stray_at_breaks = count_stray(framer, sensor);
        counters.frames_per_second = rate_of(&s->pace);
    }
    return lum_sized_fill(out, &counters, sizeof counters) ? LUM_OK
                                                           : LUM_E_VALUE;
}

uint64_t lum_framer_refused(const lum_demux_counters *packets,
                            const lum_framer_counters *lines)
{
    const lum_assembly_counters *a = &packets->assembly;
    const uint64_t *kinds = packets->packets;
    return a->late + a->conflict + a->no_room + a->stray -
           lines->stray_at_breaks + kinds[LUM_PACKET_MALFORMED] +
           kinds[LUM_PACKET_UNKNOWN_TAG] + kinds[LUM_PACKET_UNKNOWN_TYPE] +
           kinds[LUM_PACKET_FOREIGN];
}

bool lum_framer_range(const lum_framer *framer, size_t sensor, int64_t *first,
                      int64_t *last)
{
    const lum_sensor_stream *s = find(framer, sensor);
    if (s == NULL || !s->has_range) {
        return false;
    }
    *first = s->first;
    *last = s->last;
    return true;
}

const lum_clock_fit *lum_framer_clock(const lum_framer *framer, size_t sensor)
{
    const lum_sensor_stream *s = find(framer, sensor);
    return s != NULL ? s->clock : NULL;
}

int lum_framer_learn_clocks(lum_framer *framer, const lum_framer *from)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        const lum_clock_fit *learned = lum_framer_clock(from, i);
        if (learned == NULL) {
            continue;
        }
        lum_sensor_stream *s =
            lum_sensor_stream_at(framer, i, from->sensors[i]->way);
        if (s == NULL) {
            return -1;
        }
        if (s->clock != NULL) {
            lum_clock_fit_learn(s->clock, learned);
        }
    }
    return 0;
}
