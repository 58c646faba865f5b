/* Packets to lines: a packet comes in; completed lines and ended frames go
 * out, one event each call. Decides when a frame is complete. */
#include "lum/assembler.h"

#include "check.h"
#include "clock.h"
#include "counter.h"
#include "frames.h"
#include "group.h"
#include "layout.h"
#include "lines.h"
#include "stream.h"
#include "words.h"

#include <string.h>

/* An event is returned before its packet is consumed, so the same packet is
 * pushed again until nothing stands before it. An example, where packet P
 * belongs to line 12, at most 4 lines may be open, and 8 to 11 are:
 *
 *   call     what is found                         step after it  returns
 *   push(P)  frame 5 is due, which P may not see   STEP_NEW       FRAME_READY
 *   push(P)  no frame is due; P opens line 12, so  STEP_OPEN      LINE_READY
 *            line 8 closes first (to_close 1, then 0)
 *   push(P)  nothing is left to close: line 12     STEP_NONE      OK
 *            opens and takes P
 *
 * So each part of lum_assembler_push() is done once for a packet, and what it
 * found is kept in lum_awaited: its step, its clock, and to_close, the lines
 * that are still to be closed before it. */
enum step {
    STEP_NONE,  /* no event waits */
    STEP_NEW,   /* not processed yet: a frame was announced first */
    STEP_OPEN,  /* it opens a line once those before it have closed */
    STEP_BREAK, /* likewise, and it proved a jump of the clock */
};

void lum_assembler_config_default(lum_assembler_config *out)
{
    *out = (lum_assembler_config){.open_lines = 4,
                                  .reorder_lines = 8,
                                  .words_per_line = 16384,
                                  .gap_us = LUM_GAP_US};
}

static bool is_valid(const lum_assembler_config *c)
{
    return c->open_lines >= 1 && c->open_lines <= LUM_OPEN_LINES_MAX &&
           c->reorder_lines >= 1 && c->reorder_lines <= LUM_REORDER_MAX &&
           c->words_per_line >= 1 && c->words_per_line <= LUM_LINE_WORDS_MAX &&
           c->gap_us < LUM_GAP_US_END;
}

static bool is_enough(const lum_assembler_storage *s,
                      const lum_assembler_config *c)
{
    return s->slot_count >= LUM_ASSEMBLER_SLOTS(c->open_lines) &&
           s->word_count >=
               LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line) &&
           s->reach_count >= LUM_ASSEMBLER_REACH(c->reorder_lines);
}

lum_result lum_assembler_init(lum_assembler *a,
                              const lum_assembler_config *config,
                              const lum_layout *layout,
                              const lum_assembler_storage *storage)
{
    const lum_profile *profile = &layout->profile;
    if (!is_valid(config) || !lum_layout_is_read(layout)) {
        return LUM_E_VALUE;
    }
    if (!is_enough(storage, config)) {
        return LUM_E_SPACE;
    }
    memset(a, 0, sizeof *a);
    a->config = *config;
    a->line_span_us = profile->line_span_us;
    a->angle_order = profile->angle_order;
    lum_lines_init(a, storage);
    lum_frames_init(a);
    lum_clock_init(&a->stream.clock, profile);
    return LUM_OK;
}

const lum_line *lum_assembler_line(const lum_assembler *a)
{
    return a->line;
}

int64_t lum_assembler_frame(const lum_assembler *a)
{
    return (int64_t)(uint32_t)(a->frames.next - 1u);
}

const lum_assembly_counters *lum_assembler_counters(const lum_assembler *a)
{
    return &a->counters;
}

/* Whether lum_assembler_init() was called; otherwise all bytes are 0. */
static bool is_begun(const lum_assembler *a)
{
    return a->config.open_lines != 0;
}

/* The counters of drops come first and in the order of their results. */
#define CHECK_DROP(name, member, result)                                       \
    LUM_CHECK_BUILD(name,                                                      \
                    offsetof(lum_assembly_counters, member) ==                 \
                        sizeof(uint64_t) * (size_t)(LUM_E_STRAY - (result)))
CHECK_DROP(stray_is_where_its_result_says, stray, LUM_E_STRAY);
CHECK_DROP(late_is_where_its_result_says, late, LUM_E_LATE);
CHECK_DROP(duplicate_is_where_its_result_says, duplicate, LUM_E_DUPLICATE);
CHECK_DROP(conflict_is_where_its_result_says, conflict, LUM_E_CONFLICT);
CHECK_DROP(no_room_is_where_its_result_says, no_room, LUM_E_NO_ROOM);
CHECK_DROP(refused_is_where_its_result_says, refused, LUM_E_ORDER);

static void count_drop(lum_assembly_counters *c, lum_result r)
{
    uint64_t *counters = &c->stray;
    LUM_CHECK(r <= LUM_E_STRAY);
    LUM_CHECK(r >= LUM_E_ORDER);
    lum_counter_add(&counters[LUM_E_STRAY - r], 1);
}

static lum_result refuse(lum_assembler *a)
{
    count_drop(&a->counters, LUM_E_ORDER);
    return LUM_E_ORDER;
}

/* The samples may have moved to another address since then. The members after
 * them, from the clock to the order of the samples, have no padding between. */
LUM_CHECK_BUILD(the_clock_follows_the_samples,
                offsetof(lum_group, clock_raw) <= sizeof(uint64_t));
LUM_CHECK_BUILD(all_from_clock_to_order_is_compared,
                offsetof(lum_group, sample_order) + 1u ==
                    offsetof(lum_group, clock_raw) + sizeof(uint64_t) +
                        3u * sizeof(uint32_t) + 3u);

static bool is_awaited(const lum_group *awaited, const lum_group *group)
{
    const size_t from = offsetof(lum_group, clock_raw);
    const size_t to =
        offsetof(lum_group, sample_order) + sizeof group->sample_order;
    return memcmp((const uint8_t *)awaited + from,
                  (const uint8_t *)group + from, to - from) == 0;
}

static lum_result announce(lum_assembler *a)
{
    lum_frames_announce(a);
    return LUM_FRAME_READY;
}

static lum_result close_oldest(lum_assembler *a, lum_eye_state *eye)
{
    lum_assembly_counters *c = &a->counters;
    const lum_line *line = lum_lines_close(a, eye);
    a->line = line;
    lum_frames_note(a, (uint32_t)line->frame);
    lum_counter_add(&c->lines, 1);
    lum_counter_add(&c->words, line->word_count);
    lum_counter_add(&c->lost_words, line->lost_words);
    lum_counter_add(&c->lines_missing_angles,
                    line->angle_count < LUM_LINE_PIXELS ? 1 : 0);
    return LUM_LINE_READY;
}

/* Finds out what a new packet belongs to, and what has to close before. */
static lum_result place(lum_assembler *a, lum_eye_state *eye,
                        const lum_group *group, lum_line_slot **found)
{
    lum_awaited *p = &a->awaited;
    p->clock_us = lum_clock_follow(&a->stream.clock, group, &p->ticks);
    const enum lum_stream_place where = lum_stream_take(a, &eye->stream);
    if (where == STREAM_STRAY) {
        return LUM_E_STRAY;
    }
    if (where == STREAM_BREAK) {
        p->step = STEP_BREAK;
        p->to_close = eye->lines.open_count;
        return LUM_OK;
    }
    p->step = STEP_OPEN;
    return lum_lines_find(a, eye, group->line, found);
}

/* All lines of before have closed. */
static void jump(lum_assembler *a, lum_eye_state *eye)
{
    lum_lines_forget(a, eye);
    lum_frames_break(a, eye);
}

/* Samples into their line, and what the line then is. */
static lum_result accept(lum_assembler *a, lum_eye_state *eye,
                         lum_line_slot *slot, const lum_group *group)
{
    const lum_result r =
        group->tag == LUM_TAG_ANGLES
            ? lum_words_place_angles(slot, group, a->angle_order)
            : lum_words_place_ranges(a, slot, group);
    if (r == LUM_OK) {
        lum_lines_take(a, eye, slot);
    }
    return r;
}

/* The last push of a packet. */
static lum_result finish(lum_assembler *a, lum_result r)
{
    a->awaited.step = STEP_NONE;
    if (r != LUM_OK) {
        count_drop(&a->counters, r);
    }
    return r;
}

lum_result lum_assembler_push(lum_assembler *a, const lum_group *group,
                              int64_t arrival)
{
    lum_awaited *p = &a->awaited;
    lum_line_slot *slot = NULL;
    if (group->eye >= LUM_EYES ||
        lum_group_check(group->tag, group->num_samples,
                        group->first_sample_index) != LUM_OK) {
        return LUM_E_VALUE;
    }
    if (!is_begun(a) ||
        (p->step != STEP_NONE && !is_awaited(&p->group, group))) {
        return refuse(a);
    }
    lum_eye_state *eye = &a->eye[group->eye];
    p->arrival = arrival;
    /* 1. Frames that are due come before it; then find its place, once. */
    if (p->step <= STEP_NEW) {
        p->step = STEP_NEW;
        if (lum_frames_are_due(a)) {
            p->group = *group;
            return announce(a);
        }
        const lum_result r = place(a, eye, group, &slot);
        if (r != LUM_OK) {
            return finish(a, r);
        }
    }
    /* 2. Lines that close before it, one at each push. */
    if (p->to_close > 0) {
        p->to_close--;
        p->group = *group;
        return close_oldest(a, eye);
    }
    /* 3. Nothing stands before it: its samples go into their line. */
    if (p->step == STEP_BREAK) {
        jump(a, eye);
    }
    if (slot == NULL) {
        slot = lum_lines_open(a, eye, group->line);
    }
    return finish(a, accept(a, eye, slot, group));
}

lum_result lum_assembler_close_idle(lum_assembler *a, int64_t before)
{
    if (!is_begun(a) || a->awaited.step != STEP_NONE) {
        return refuse(a);
    }
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_eye_state *eye = &a->eye[e];
        if (lum_lines_pull_idle(eye, before)) {
            lum_counter_add(&a->counters.lines_idle, 1);
            return close_oldest(a, eye);
        }
    }
    return LUM_OK;
}

lum_result lum_assembler_flush(lum_assembler *a)
{
    if (!is_begun(a)) {
        return refuse(a);
    }
    if (a->awaited.step != STEP_NONE) {
        lum_counter_add(&a->counters.refused, 1);
        a->awaited.step = STEP_NONE;
        a->awaited.to_close = 0;
    }
    for (unsigned e = 0; e < LUM_EYES; e++) {
        if (a->eye[e].lines.open_count > 0) {
            return close_oldest(a, &a->eye[e]);
        }
    }
    lum_frames_count_gaps(a);
    if (lum_frames_remain(a)) {
        return announce(a);
    }
    lum_stream_end(a);
    lum_frames_end(a);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_lines_forget(a, &a->eye[e]);
    }
    return LUM_OK;
}
