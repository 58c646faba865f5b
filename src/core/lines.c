#include "lines.h"

#include "stream.h"

#include <string.h>

/* The frame of an open line that is not decided: behind all others. */
#define UNDECIDED INT64_MAX

static bool was_closed(const lum_assembler *a, const lum_eye_state *eye,
                       uint32_t number)
{
    for (unsigned i = 0; i < eye->closed_count; i++) {
        const lum_closed_line *closed = &eye->closed[i];
        if (closed->number == number &&
            stream_is_within(
                lum_stream_lead(&a->packet_clock_us, &closed->clock_us),
                a->line_span_us)) {
            return true;
        }
    }
    return lum_stream_lead(&a->packet_clock_us, &eye->low_clock_us) < 0;
}

lum_result lum_lines_find(lum_assembler *a, const lum_eye_state *eye,
                          uint32_t number, lum_line_slot **found)
{
    lum_line_slot *slot = eye->oldest;
    for (unsigned i = 0; i < eye->open_count; i++) {
        if (slot->line.number == number) {
            const int32_t ahead_us =
                lum_stream_lead(&a->packet_clock_us, &slot->line.clock_us);
            if (stream_is_within(ahead_us, a->line_span_us)) {
                *found = slot;
                return LUM_OK;
            }
            a->to_close = (uint8_t)(i + 1u);
            return ahead_us < 0 ? LUM_E_LATE : LUM_OK;
        }
        slot = slot->next;
    }
    a->to_close = eye->open_count == a->config.open_lines ? 1 : 0;
    return was_closed(a, eye, number) ? LUM_E_LATE : LUM_OK;
}

lum_line_slot *lum_lines_open(const lum_assembler *a, lum_eye_state *eye,
                              uint32_t number)
{
    lum_line_slot *slot = eye->unused;
    lum_line *line = &slot->line;
    eye->unused = slot->next;
    eye->open_count++;
    line->frame = UNDECIDED;
    line->clock_us = a->packet_clock_us;
    line->word_count = 0;
    line->lost_words = 0;
    line->number = number;
    line->angle_count = 0;
    slot->low_clock_us = INT64_MAX;
    slot->accepted = 0;
    slot->words_seen = 0;
    slot->words_end = 0;
    memset(slot->angle_marks, 0, sizeof slot->angle_marks);
    return slot;
}

static void remember(const lum_assembler *a, lum_eye_state *eye,
                     const lum_line *line)
{
    lum_closed_line *closed = &eye->closed[eye->closed_next];
    closed->clock_us = line->clock_us;
    closed->number = line->number;
    eye->closed_next++;
    if (eye->closed_count < eye->closed_next) {
        eye->closed_count = eye->closed_next;
    }
    if (eye->closed_next == a->config.reorder_lines) {
        eye->closed_next = 0;
    }
}

/* Storage is used again; what an earlier line left there must not show. */
static void clear_unmarked(lum_line_slot *slot)
{
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        if (!lum_line_has_angles(&slot->line, p)) {
            slot->angles[p] = (lum_angle){0, 0};
        }
    }
}

lum_line *lum_lines_close(const lum_assembler *a, lum_eye_state *eye)
{
    lum_line_slot *slot = eye->oldest;
    lum_line *line = &slot->line;
    eye->oldest = slot->next;
    eye->open_count--;
    if (slot->accepted < 2) {
        line->frame = eye->frame;
    } else if (slot->low_clock_us > eye->low_clock_us) {
        eye->low_clock_us = slot->low_clock_us;
    }
    if (slot->words_end > slot->words_seen) {
        line->lost_words = slot->words_end - slot->words_seen;
    }
    if (line->angle_count < LUM_LINE_PIXELS) {
        clear_unmarked(slot);
    }
    remember(a, eye, line);
    return line;
}

bool lum_lines_are_past(const lum_assembler *a, const lum_eye_state *eye)
{
    const lum_line_slot *slot = eye->oldest;
    if (eye->highest[a->config.reorder_lines - 1u] <= a->next_frame) {
        return false;
    }
    for (unsigned i = 0; i < eye->open_count; i++) {
        if (slot->line.frame <= a->next_frame) {
            return false;
        }
        slot = slot->next;
    }
    return true;
}
