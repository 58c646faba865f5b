#include "lum/assembler.h"

#include "frames.h"
#include "lum/clock.h"
#include "words.h"

#include <string.h>

#define GAP_US_MAX (UINT32_C(1) << 30)
#define NO_SLOT    0xffu

/* Where the packet at hand stands between two pushes of it. */
enum stage {
    STAGE_NEW,   /* nothing done yet */
    STAGE_BREAK, /* it proved a jump of the clock: lines are closing */
    STAGE_FIND,  /* it belongs to the stream: look for its line */
    STAGE_CLOSE, /* lines before its own are closing */
};

void lum_assembler_config_default(lum_assembler_config *out)
{
    *out = (lum_assembler_config){.open_lines = 4,
                                  .reorder_lines = 8,
                                  .words_per_line = 16384,
                                  .gap_us = 100000};
}

static bool is_valid(const lum_assembler_config *c)
{
    return c->open_lines >= 1 && c->open_lines <= LUM_OPEN_LINES_MAX &&
           c->reorder_lines >= 1 && c->reorder_lines <= LUM_REORDER_MAX &&
           c->words_per_line >= 1 && c->words_per_line <= LUM_LINE_WORDS_MAX &&
           c->gap_us < GAP_US_MAX;
}

lum_result lum_assembler_init(lum_assembler *a,
                              const lum_assembler_config *config,
                              const lum_layout *layout, lum_line_slot *slots,
                              uint32_t *words)
{
    if (!is_valid(config)) {
        return LUM_E_VALUE;
    }
    memset(a, 0, sizeof *a);
    a->config = *config;
    a->layout = *layout;
    a->slots = slots;
    a->handed_out = NO_SLOT;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        frames_init(&a->eye[i].frames);
    }
    for (unsigned i = 0; i < LUM_EYES * (unsigned)config->open_lines; i++) {
        slots[i].used = false;
        slots[i].words = words + (size_t)i * config->words_per_line;
    }
    return LUM_OK;
}

const lum_line *lum_assembler_line(const lum_assembler *a)
{
    return &a->line;
}

int64_t lum_assembler_frame(const lum_assembler *a)
{
    return a->due_frame;
}

const lum_assembly_counters *lum_assembler_counters(const lum_assembler *a)
{
    return &a->counters;
}

static int64_t distance(int64_t a, int64_t b)
{
    return a > b ? a - b : b - a;
}

static void note_frame(lum_assembler *a, int64_t frame)
{
    const bool none_announced = a->next_frame == a->lowest_frame;
    if (!a->frame_begun) {
        a->frame_begun = true;
        a->next_frame = frame;
        a->lowest_frame = frame;
        a->highest_frame = frame;
        return;
    }
    if (frame < a->lowest_frame) {
        a->lowest_frame = frame;
        a->next_frame = none_announced ? frame : a->next_frame;
    }
    if (frame > a->highest_frame) {
        a->highest_frame = frame;
    }
}

/* The other eye tells the time by lines of more than one packet: one packet
 * ahead of its time makes nobody silent. */
static bool is_silent(const lum_assembler *a, const lum_eye_state *eye,
                      const lum_eye_state *other)
{
    return other->has_low_clock &&
           other->low_clock_us - eye->heard_us > (int64_t)a->config.gap_us;
}

static bool is_frame_due(lum_assembler *a)
{
    const lum_eye_state *blue = &a->eye[LUM_EYE_BLUE];
    const lum_eye_state *green = &a->eye[LUM_EYE_GREEN];
    if (!a->frame_begun) {
        return false;
    }
    const bool blue_past = blue->frames.past >= a->next_frame;
    const bool green_past = green->frames.past >= a->next_frame;
    const bool due = (blue_past && green_past) ||
                     (blue_past && is_silent(a, green, blue)) ||
                     (green_past && is_silent(a, blue, green));
    if (due) {
        a->due_frame = a->next_frame++;
    }
    return due;
}

static lum_line_slot *open_slot(lum_assembler *a, const lum_eye_state *eye,
                                unsigned position)
{
    return &a->slots[eye->open[position]];
}

static void update_past(lum_assembler *a, lum_eye_state *eye)
{
    int64_t lowest = INT64_MAX;
    for (unsigned i = 0; i < eye->open_count; i++) {
        const lum_line_slot *slot = open_slot(a, eye, i);
        if (slot->accepted >= 2 && slot->frame < lowest) {
            lowest = slot->frame;
        }
    }
    frames_update_past(&eye->frames, a->config.reorder_lines, lowest);
}

static void remember_closed(lum_assembler *a, lum_eye_state *eye,
                            const lum_line_slot *slot)
{
    eye->closed[eye->closed_next] =
        (lum_closed_line){slot->clock_us, slot->number};
    eye->closed_next =
        (uint8_t)((eye->closed_next + 1u) % a->config.reorder_lines);
    if (eye->closed_count < a->config.reorder_lines) {
        eye->closed_count++;
    }
    if (slot->accepted >= 2 &&
        (!eye->has_low_clock || slot->low_clock_us > eye->low_clock_us)) {
        eye->has_low_clock = true;
        eye->low_clock_us = slot->low_clock_us;
    }
}

static void count_line(lum_assembler *a, const lum_line *line)
{
    lum_assembly_counters *c = &a->counters;
    c->lines++;
    c->words += line->word_count;
    c->lost_words += line->lost_words;
    if (line->angle_count < LUM_LINE_PIXELS) {
        c->lines_missing_angles++;
    }
    if (c->lines == 1) {
        a->handed_low = line->frame;
        a->handed_high = line->frame;
    }
    if (line->frame < a->handed_low) {
        a->handed_low = line->frame;
    }
    if (line->frame > a->handed_high) {
        a->handed_high = line->frame;
    }
    /* both eyes number without holes, so the span counts distinct numbers */
    c->frames = (uint64_t)(a->handed_high - a->handed_low) + 1u;
}

/* Storage is used again; what an earlier line left there must not show. */
static void clear_unmarked(lum_line_slot *slot)
{
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        if (((slot->angle_marks[p / 32u] >> (p % 32u)) & 1u) == 0) {
            slot->angles[p] = (lum_angle){0, 0};
        }
    }
}

static void fill_line(lum_line *line, const lum_line_slot *slot, uint8_t eye)
{
    *line = (lum_line){
        .frame = slot->frame,
        .clock_us = slot->clock_us,
        .arrival = slot->arrival,
        .angles = slot->angles,
        .angle_marks = slot->angle_marks,
        .words = slot->words,
        .word_count = slot->word_count,
        .lost_words = slot->words_end > slot->words_seen
                          ? slot->words_end - (uint32_t)slot->words_seen
                          : 0,
        .number = slot->number,
        .angle_count = slot->angle_count,
        .eye = eye,
    };
}

/* Hands out the line that was opened first. Its storage stays until the next
 * call into the assembler. */
static lum_result close_oldest(lum_assembler *a, uint8_t eye_index)
{
    lum_eye_state *eye = &a->eye[eye_index];
    const uint8_t index = eye->open[0];
    lum_line_slot *slot = &a->slots[index];
    if (slot->accepted < 2) {
        slot->frame = frames_current(&eye->frames);
    }
    note_frame(a, slot->frame);
    eye->open_count--;
    for (unsigned i = 0; i < eye->open_count; i++) {
        eye->open[i] = eye->open[i + 1u];
    }
    remember_closed(a, eye, slot);
    update_past(a, eye);
    if (slot->angle_count < LUM_LINE_PIXELS) {
        clear_unmarked(slot);
    }
    fill_line(&a->line, slot, eye_index);
    count_line(a, &a->line);
    a->handed_out = index;
    return LUM_LINE_READY;
}

static void release_handed_out(lum_assembler *a)
{
    if (a->handed_out != NO_SLOT) {
        a->slots[a->handed_out].used = false;
        a->handed_out = NO_SLOT;
    }
}

static uint8_t free_slot(const lum_assembler *a)
{
    uint8_t i = 0;
    while (a->slots[i].used) {
        i++;
    }
    return i;
}

static lum_line_slot *open_line(lum_assembler *a, lum_eye_state *eye,
                                uint32_t number, int64_t arrival)
{
    const uint8_t index = free_slot(a);
    lum_line_slot *slot = &a->slots[index];
    slot->used = true;
    slot->word_count = 0;
    slot->words_seen = 0;
    slot->words_end = 0;
    slot->accepted = 0;
    slot->angle_count = 0;
    memset(slot->angle_marks, 0, sizeof slot->angle_marks);
    slot->number = number;
    slot->clock_us = a->packet_clock_us;
    slot->arrival = arrival;
    eye->open[eye->open_count++] = index;
    return slot;
}

static unsigned find_open(lum_assembler *a, const lum_eye_state *eye,
                          uint32_t number)
{
    unsigned i = 0;
    while (i < eye->open_count && open_slot(a, eye, i)->number != number) {
        i++;
    }
    return i;
}

static lum_result judge_clock(lum_assembler *a, lum_eye_state *eye)
{
    const int64_t gap = a->config.gap_us;
    const int64_t clock = a->packet_clock_us;
    if (!eye->seen || distance(clock, eye->newest_us) <= gap) {
        if (!eye->seen || clock > eye->newest_us) {
            eye->newest_us = clock;
        }
        eye->heard_us = eye->newest_us;
        eye->seen = true;
        eye->has_candidate = false;
        a->stage = STAGE_FIND;
        return LUM_OK;
    }
    if (eye->has_candidate && distance(clock, eye->candidate_us) <= gap) {
        eye->has_candidate = false;
        a->stage = STAGE_BREAK;
        return LUM_OK;
    }
    eye->has_candidate = true;
    eye->candidate_us = clock;
    a->counters.stray++;
    return LUM_E_STRAY;
}

/* Silence is counted from here on, for a clock that has begun or jumped. */
static void hear_both(lum_assembler *a)
{
    a->eye[LUM_EYE_BLUE].heard_us = a->packet_clock_us;
    a->eye[LUM_EYE_GREEN].heard_us = a->packet_clock_us;
}

static lum_result place_in_time(lum_assembler *a, const lum_group *group)
{
    const unsigned bytes = a->layout.profile.group[LUM_FIELD_TIMESTAMP].bytes;
    a->packet_clock_us =
        a->clock_begun || bytes == 0
            ? lum_clock_extend(a->clock_us, group->clock_raw, bytes)
            : (int64_t)group->clock_raw;
    const lum_result r = judge_clock(a, &a->eye[group->eye]);
    if (r != LUM_OK) {
        return r;
    }
    if (!a->clock_begun) {
        a->clock_begun = true;
        hear_both(a);
    }
    a->clock_us = a->packet_clock_us;
    return LUM_OK;
}

static void end_break(lum_assembler *a, lum_eye_state *eye)
{
    eye->closed_count = 0;
    eye->closed_next = 0;
    eye->has_low_clock = false;
    eye->newest_us = a->packet_clock_us;
    hear_both(a);
    frames_break(&eye->frames);
    a->stage = STAGE_FIND;
}

static bool was_closed(const lum_assembler *a, const lum_eye_state *eye,
                       uint32_t number)
{
    const int64_t span = a->layout.profile.line_span_us;
    for (unsigned i = 0; i < eye->closed_count; i++) {
        if (eye->closed[i].number == number &&
            distance(a->packet_clock_us, eye->closed[i].clock_us) <= span) {
            return true;
        }
    }
    return eye->has_low_clock && a->packet_clock_us < eye->low_clock_us;
}

static lum_result find_line(lum_assembler *a, const lum_eye_state *eye,
                            uint32_t number)
{
    const int64_t span = a->layout.profile.line_span_us;
    const unsigned position = find_open(a, eye, number);
    bool is_late = false;
    a->to_close = 0;
    a->opening = true;
    if (position < eye->open_count) {
        const int64_t ahead =
            a->packet_clock_us - open_slot(a, eye, position)->clock_us;
        is_late = ahead < -span;
        a->opening = ahead > span;
        a->to_close = (uint8_t)(a->opening ? position + 1u : 0);
    } else {
        is_late = was_closed(a, eye, number);
        a->to_close = eye->open_count == a->config.open_lines ? 1 : 0;
    }
    a->stage = is_late ? STAGE_NEW : STAGE_CLOSE;
    if (is_late) {
        a->counters.late++;
        return LUM_E_LATE;
    }
    return LUM_OK;
}

static lum_result place_samples(lum_assembler *a, lum_line_slot *slot,
                                const lum_group *group)
{
    if (group->tag == LUM_TAG_ANGLES) {
        return words_place_angles(slot, &a->layout, group);
    }
    return words_place_ranges(slot, a->config.words_per_line, group,
                              a->placement, &a->counters.bad_words);
}

static void count_drop(lum_assembly_counters *c, lum_result r)
{
    if (r == LUM_E_DUPLICATE) {
        c->duplicate++;
    } else if (r == LUM_E_CONFLICT) {
        c->conflict++;
    } else {
        c->no_room++;
    }
}

static lum_result accept(lum_assembler *a, const lum_group *group,
                         int64_t arrival)
{
    lum_eye_state *eye = &a->eye[group->eye];
    lum_line_slot *slot =
        a->opening ? open_line(a, eye, group->line, arrival)
                   : open_slot(a, eye, find_open(a, eye, group->line));
    const lum_result r = place_samples(a, slot, group);
    if (r != LUM_OK) {
        count_drop(&a->counters, r);
        return r;
    }
    if (slot->accepted == 0 || a->packet_clock_us < slot->low_clock_us) {
        slot->low_clock_us = a->packet_clock_us;
    }
    slot->accepted = (uint8_t)(slot->accepted < 2 ? slot->accepted + 1 : 3);
    if (slot->accepted == 2) {
        slot->frame = frames_decide(
            &eye->frames, &a->eye[LUM_EYES - 1u - group->eye].frames,
            group->line, a->config.reorder_lines, &a->counters.lines_skipped);
        note_frame(a, slot->frame);
        update_past(a, eye);
    }
    return LUM_OK;
}

lum_result lum_assembler_push(lum_assembler *a, const lum_group *group,
                              int64_t arrival)
{
    lum_eye_state *eye = &a->eye[group->eye];
    lum_result r = LUM_OK;
    release_handed_out(a);
    if (a->stage == STAGE_NEW) {
        if (is_frame_due(a)) {
            return LUM_FRAME_READY;
        }
        r = place_in_time(a, group);
    }
    if (a->stage == STAGE_BREAK) {
        if (eye->open_count > 0) {
            return close_oldest(a, group->eye);
        }
        end_break(a, eye);
    }
    if (a->stage == STAGE_FIND) {
        r = find_line(a, eye, group->line);
    }
    if (r != LUM_OK) {
        return r;
    }
    if (a->to_close > 0) {
        a->to_close--;
        return close_oldest(a, group->eye);
    }
    a->stage = STAGE_NEW;
    return accept(a, group, arrival);
}

lum_result lum_assembler_flush(lum_assembler *a)
{
    release_handed_out(a);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        if (a->eye[e].open_count > 0) {
            return close_oldest(a, (uint8_t)e);
        }
    }
    if (!a->flushed) {
        a->flushed = true;
        a->counters.lines_skipped += (uint64_t)a->eye[0].frames.gap;
        a->counters.lines_skipped += (uint64_t)a->eye[1].frames.gap;
    }
    if (a->frame_begun && a->next_frame <= a->highest_frame) {
        a->due_frame = a->next_frame++;
        return LUM_FRAME_READY;
    }
    return LUM_OK;
}
