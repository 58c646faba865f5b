/* Which pauses a sensor made, of what its eyes tell, and in which frames. */
#include "pause.h"

#include <string.h>

/* Of arrivals. */
#define ARRIVAL_LEAST_US 1000000

/* The assembler counts lines as skipped up to a reach of reordering later. */
#define FRESH_LINES 80u

void lum_pause_init(lum_pause *p, uint32_t gap_us, const lum_profile *profile)
{
    memset(p, 0, sizeof *p);
    p->by_arrival = profile->group[LUM_FIELD_TIMESTAMP].bytes == 0;
    p->clock.gap_us = p->by_arrival ? INT64_MAX : (int64_t)gap_us;
    p->clock.least_us = p->by_arrival ? ARRIVAL_LEAST_US : 0;
    p->clock.tick_us =
        p->by_arrival ? 0 : ((int64_t)profile->clock_unit_ns + 999) / 1000;
}

/* --- The latest pause --- */

/* What it is in the counts. */
static lum_pause_counts share(const lum_pause_latest *l)
{
    if (!l->has_pause) {
        return (lum_pause_counts){.pauses = 0};
    }
    return (lum_pause_counts){.pauses = 1,
                              .paused_us = (uint64_t)(l->to_us - l->from_us),
                              .lines = l->lines > 0 ? (uint64_t)l->lines : 0};
}

static void add_lines(lum_pause_latest *l, int64_t lines)
{
    const int64_t most = LUM_PAUSE_CLOCK_MAX_US;
    l->lines += l->lines + lines > most || l->lines + lines < -most ? 0 : lines;
}

/* Both eyes pause together; else it is another one. */
static void join(lum_pause_latest *l, const lum_pause_found *found)
{
    if (!l->has_pause) {
        l->has_pause = true;
        l->is_break = false;
        l->from_us = found->from_us;
        l->to_us = found->to_us;
    }
    l->is_break = l->is_break || found->is_break;
    l->from_us = l->from_us < found->from_us ? l->from_us : found->from_us;
    l->to_us = l->to_us > found->to_us ? l->to_us : found->to_us;
}

static bool overlaps(const lum_pause_latest *l, int64_t from_us, int64_t to_us)
{
    return from_us <= l->to_us && l->from_us <= to_us;
}

static bool is_notable(const lum_pause *p, unsigned eye, int64_t lines)
{
    const int64_t n = lines < 0 ? -lines : lines;
    return n >= LUM_PAUSE_LINES_MIN &&
           lum_pause_scan_us(&p->eye[eye].scan, n) >
               2 * p->clock.tick_us + p->clock.least_us;
}

/* --- Frames that one lies in --- */

static void mark(lum_pause *p, unsigned eye, uint32_t frame, int64_t lines)
{
    lum_pause_frame *f = NULL;
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        if (p->frames[i].eyes != 0 && p->frames[i].frame == frame) {
            f = &p->frames[i];
        }
    }
    if (f == NULL) {
        f = &p->frames[p->frames_next];
        p->frames_next = (uint8_t)((p->frames_next + 1u) % LUM_PAUSE_FRAMES);
        *f = (lum_pause_frame){.frame = frame};
    }
    f->eyes = (uint8_t)(f->eyes | 1u << eye);
    f->lines[eye] += (uint64_t)lines;
}

/* Frames that have lines on both sides, or lack their end or all of an eye by
 * it: of the latter, those that may not have been handed out meanwhile. */
static void mark_frames(lum_pause *p, unsigned eye,
                        const lum_pause_found *found)
{
    const bool is_one = lum_pause_turns(found->before, found->behind) == 0;
    for (uint32_t back = LUM_PAUSE_FRAMES - 1u; back > 0; back--) {
        if (lum_pause_turns(found->before, found->behind - back) > 0) {
            mark(p, eye, found->behind - back, 0);
        }
    }
    if (is_one || found->lines_before > 0) {
        mark(p, eye, found->before, found->lines_before);
    }
    if (is_one && found->behind != found->before) {
        mark(p, eye, found->behind, 0);
    }
}

/* --- What an eye has found --- */

static void note(lum_pause *p, unsigned eye, const lum_pause_found *found)
{
    lum_pause_latest *l = &p->latest;
    const bool is_new = found->has_pause || is_notable(p, eye, found->lines);
    const bool is_other = l->has_pause && found->has_pause &&
                          !overlaps(l, found->from_us, found->to_us);
    p->counts.breaks += found->breaks;
    if (is_new && (l->fresh == 0 || is_other)) {
        *l = (lum_pause_latest){.fresh = 0};
    }
    const lum_pause_counts before = share(l);
    if (found->has_pause) {
        join(l, found);
        mark_frames(p, eye, found);
    }
    if (is_new) {
        add_lines(l, found->lines);
    }
    if (found->turn_lines > 0 && overlaps(l, found->turn_us, found->turn_us)) {
        add_lines(l, -found->turn_lines);
    }
    l->has_pause =
        l->has_pause && (l->is_break || l->lines >= LUM_PAUSE_LINES_MIN);
    const lum_pause_counts behind = share(l);
    p->counts.pauses += behind.pauses - before.pauses;
    p->counts.paused_us += behind.paused_us - before.paused_us;
    p->counts.lines += behind.lines - before.lines;
    l->fresh = (uint8_t)(is_new         ? FRESH_LINES
                         : l->fresh > 0 ? l->fresh - 1u
                                        : 0);
}

void lum_pause_take(lum_pause *p, const lum_line *line, bool is_decided)
{
    lum_pause_found found = {.breaks = 0};
    const lum_pause_line b = {.clock_us = p->by_arrival ? line->arrival / 1000
                                                        : line->clock_us,
                              .arrival_ns = line->arrival,
                              .number = line->number,
                              .frame = (uint32_t)line->frame};
    lum_pause_eye_take(&p->eye[line->eye], &p->clock, &b, is_decided, &found);
    note(p, line->eye, &found);
}

static void end_eye(lum_pause *p, unsigned eye, bool is_end)
{
    lum_pause_found found = {.breaks = 0};
    lum_pause_eye_end(&p->eye[eye], &p->clock, is_end, &found);
    note(p, eye, &found);
}

void lum_pause_end(lum_pause *p)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        end_eye(p, eye, true);
    }
}

void lum_pause_join(lum_pause *p)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_pause_eye_join(&p->eye[eye]);
    }
}

/* --- Frames end --- */

static bool is_wanted(unsigned eyes, unsigned eye)
{
    return (eyes >> eye & 1u) != 0;
}

/* Pauses that are known to lie in a frame. */
static bool take_marks(lum_pause *p, uint32_t frame, unsigned eyes,
                       uint64_t *lines)
{
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        lum_pause_frame *f = &p->frames[i];
        if (f->eyes != 0 && f->frame == frame) {
            const bool is_marked = (f->eyes & eyes) != 0;
            f->eyes = 0;
            *lines += is_wanted(eyes, LUM_EYE_BLUE) ? f->lines[0] : 0;
            *lines += is_wanted(eyes, LUM_EYE_GREEN) ? f->lines[1] : 0;
            return is_marked;
        }
    }
    return false;
}

bool lum_pause_frame_ends(lum_pause *p, uint32_t frame, unsigned eyes,
                          bool is_end, uint64_t *lines)
{
    bool has_pause = false;
    *lines = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const lum_pause_eye *e = &p->eye[eye];
        const bool is_torn = lum_pause_eye_doubts(e, frame);
        end_eye(p, eye, false);
        has_pause =
            has_pause ||
            (is_wanted(eyes, eye) &&
             (is_torn || (!is_end && lum_pause_eye_has_stopped(e, frame))));
    }
    return take_marks(p, frame, eyes, lines) || has_pause;
}

/* --- As bytes --- */

static void pack_frame(lum_pack *p, lum_pause_frame *f)
{
    lum_pack_u8(p, &f->eyes);
    if (!lum_pack_check(p, f->eyes < 1u << LUM_EYES)) {
        f->eyes = 0;
    }
    if (f->eyes != 0) {
        lum_pack_u32(p, &f->frame);
        lum_pack_u64(p, &f->lines[LUM_EYE_BLUE]);
        lum_pack_u64(p, &f->lines[LUM_EYE_GREEN]);
    }
}

void lum_pause_pack(lum_pause *p, lum_pack *pack)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_pause_eye_pack(&p->eye[eye], pack);
    }
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        pack_frame(pack, &p->frames[i]);
    }
    lum_pack_u8(pack, &p->frames_next);
    if (!lum_pack_check(pack, p->frames_next < LUM_PAUSE_FRAMES)) {
        p->frames_next = 0;
    }
    if (lum_pack_is_reading(pack)) {
        p->latest = (lum_pause_latest){.fresh = 0};
    }
}
