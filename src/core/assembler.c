#include "lum/assembler.h"

#include "counter.h"
#include "frames.h"
#include "lines.h"
#include "stream.h"
#include "words.h"

#include <string.h>

#define GAP_US_MAX (UINT32_C(1) << 30)

/* Where the packet at hand stands between two pushes of it. */
enum stage {
    STAGE_NEW,   /* nothing done yet */
    STAGE_OPEN,  /* it opens a line once those before it have closed */
    STAGE_BREAK, /* likewise, and it proved a jump of the clock */
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

static void init_eyes(lum_assembler *a, lum_line_slot *slots, uint32_t *words)
{
    const unsigned count = a->config.open_lines;
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_eye_state *eye = &a->eye[e];
        eye->frame = 1;
        eye->candidate_us = STREAM_LONG_AGO;
        eye->low_clock_us = STREAM_LONG_AGO;
        eye->oldest = slots;
        eye->unused = slots;
        for (unsigned i = 0; i < count; i++) {
            lum_line_slot *slot = &slots[i];
            slot->line.angles = slot->angles;
            slot->line.angle_marks = slot->angle_marks;
            slot->line.words = words;
            slot->line.eye = (uint8_t)e;
            slot->words = words;
            slot->next = slot + 1;
            words += a->config.words_per_line;
        }
        slots[count - 1u].next = slots;
        slots += count;
    }
}

lum_result lum_assembler_init(lum_assembler *a,
                              const lum_assembler_config *config,
                              const lum_layout *layout, lum_line_slot *slots,
                              uint32_t *words)
{
    const lum_profile *profile = &layout->profile;
    if (!is_valid(config)) {
        return LUM_E_VALUE;
    }
    memset(a, 0, sizeof *a);
    a->config = *config;
    a->line_span_us = profile->line_span_us;
    a->angle_order = profile->angle_order;
    a->clock_bytes = profile->group[LUM_FIELD_TIMESTAMP].bytes;
    a->clock_begun = a->clock_bytes == 0;
    a->next_frame = INT64_MAX;
    a->handed_low = INT64_MAX;
    init_eyes(a, slots, words);
    return LUM_OK;
}

const lum_line *lum_assembler_line(const lum_assembler *a)
{
    return a->line;
}

int64_t lum_assembler_frame(const lum_assembler *a)
{
    return a->next_frame - 1;
}

const lum_assembly_counters *lum_assembler_counters(const lum_assembler *a)
{
    return &a->counters;
}

/* The other eye tells the time by lines of more than one packet: one packet
 * ahead of its time makes nobody silent. */
static bool is_silent(const lum_assembler *a, const lum_eye_state *eye,
                      const lum_eye_state *other)
{
    return lum_stream_lead(&other->low_clock_us, &eye->heard_us) >
           (int32_t)a->config.gap_us;
}

static bool is_frame_due(const lum_assembler *a)
{
    const lum_eye_state *blue = &a->eye[LUM_EYE_BLUE];
    const lum_eye_state *green = &a->eye[LUM_EYE_GREEN];
    const bool blue_past = lum_lines_are_past(a, blue);
    const bool green_past = lum_lines_are_past(a, green);
    return blue_past ? green_past || is_silent(a, green, blue)
                     : green_past && is_silent(a, blue, green);
}

static lum_result announce(lum_assembler *a)
{
    a->announced = true;
    a->next_frame++;
    return LUM_FRAME_READY;
}

/* Both eyes number without holes, so the span of the numbers counts them. */
static void count_frame(lum_assembler *a, int64_t frame)
{
    if (frame < a->handed_low) {
        a->handed_low = frame;
    }
    if (frame > a->handed_high) {
        a->handed_high = frame;
    }
    a->counters.frames = (uint64_t)(a->handed_high - a->handed_low) + 1u;
}

static lum_result close_oldest(lum_assembler *a, lum_eye_state *eye)
{
    lum_assembly_counters *c = &a->counters;
    const lum_line *line = lum_lines_close(a, eye);
    a->line = line;
    lum_frames_note(a, line->frame);
    count_frame(a, line->frame);
    lum_counter_add(&c->lines, 1);
    lum_counter_add(&c->words, line->word_count);
    lum_counter_add(&c->lost_words, line->lost_words);
    lum_counter_add(&c->lines_missing_angles,
                    line->angle_count < LUM_LINE_PIXELS ? 1 : 0);
    return LUM_LINE_READY;
}

/* Finds out what the packet belongs to, and what has to close before. */
static lum_result place(lum_assembler *a, lum_eye_state *eye,
                        const lum_group *group, lum_line_slot **found)
{
    const enum lum_stream_place place =
        lum_stream_place(a, eye, group->clock_raw);
    if (place == STREAM_STRAY) {
        return LUM_E_STRAY;
    }
    if (place == STREAM_BREAK) {
        a->stage = STAGE_BREAK;
        a->to_close = eye->open_count;
        return LUM_OK;
    }
    a->stage = STAGE_OPEN;
    return lum_lines_find(a, eye, group->line, found);
}

static void count_accepted(lum_assembler *a, lum_eye_state *eye,
                           lum_line_slot *slot, const lum_group *group)
{
    const lum_eye_state *other = &a->eye[LUM_EYES - 1u - group->eye];
    if (group->tag == LUM_TAG_RANGES) {
        lum_words_count_sent(a, slot, group);
    }
    if (a->packet_clock_us < slot->low_clock_us) {
        slot->low_clock_us = a->packet_clock_us;
    }
    if (slot->accepted < 2 && ++slot->accepted == 2) {
        slot->line.frame = lum_frames_decide(a, eye, other, group->line);
        lum_frames_note(a, slot->line.frame);
    }
}

static lum_result accept(lum_assembler *a, lum_eye_state *eye,
                         lum_line_slot *slot, const lum_group *group)
{
    lum_result r = LUM_OK;
    if (group->tag == LUM_TAG_ANGLES) {
        r = lum_words_place_angles(a, slot, group);
    } else if (!lum_words_append(a, slot, group)) {
        r = lum_words_insert(a, slot, group);
    }
    if (r == LUM_OK) {
        count_accepted(a, eye, slot, group);
    }
    return r;
}

static void count_drop(lum_assembly_counters *c, lum_result r)
{
    uint64_t *counter = &c->no_room;
    if (r == LUM_E_STRAY) {
        counter = &c->stray;
    } else if (r == LUM_E_LATE) {
        counter = &c->late;
    } else if (r == LUM_E_DUPLICATE) {
        counter = &c->duplicate;
    } else if (r == LUM_E_CONFLICT) {
        counter = &c->conflict;
    }
    lum_counter_add(counter, 1);
}

/* The last push of a packet. */
static lum_result finish(lum_assembler *a, lum_result r)
{
    a->stage = STAGE_NEW;
    a->to_close = 0;
    if (r != LUM_OK) {
        count_drop(&a->counters, r);
    }
    return r;
}

lum_result lum_assembler_push(lum_assembler *a, const lum_group *group,
                              int64_t arrival)
{
    lum_eye_state *eye = &a->eye[group->eye];
    lum_line_slot *slot = NULL;
    if (a->stage == STAGE_NEW) {
        if (is_frame_due(a)) {
            return announce(a);
        }
        const lum_result r = place(a, eye, group, &slot);
        if (r != LUM_OK) {
            return finish(a, r);
        }
    }
    if (a->to_close > 0) {
        a->to_close--;
        return close_oldest(a, eye);
    }
    if (a->stage == STAGE_BREAK) {
        lum_stream_jump(a, eye);
    }
    if (slot == NULL) {
        slot = lum_lines_open(a, eye, group->line);
        slot->line.arrival = arrival;
    }
    return finish(a, accept(a, eye, slot, group));
}

lum_result lum_assembler_flush(lum_assembler *a)
{
    lum_eye_state *blue = &a->eye[LUM_EYE_BLUE];
    lum_eye_state *green = &a->eye[LUM_EYE_GREEN];
    if (blue->open_count > 0) {
        return close_oldest(a, blue);
    }
    if (green->open_count > 0) {
        return close_oldest(a, green);
    }
    lum_frames_count_gap(a, blue);
    lum_frames_count_gap(a, green);
    return a->next_frame <= a->highest_frame ? announce(a) : LUM_OK;
}
