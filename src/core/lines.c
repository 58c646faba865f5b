#include "lines.h"

#include "check.h"
#include "frames.h"
#include "stream.h"

#include <string.h>

/* A line is open from its first packet until it is closed and handed out. An
 * eye can have several open lines, since packets of neighbouring lines may
 * arrive mixed. For each packet:
 *
 * 1. If a line of its number is open and their clocks are at most line_span_us
 *    apart, the packet belongs to it.
 * 2. If such a line is open but older, the number has come round: that line and
 *    all that were opened before it are closed, and a new one opens.
 * 3. If the packet is of a line that has been closed, it is late and dropped. A
 *    line is handed out once, so nothing can be added to it any more.
 * 4. Otherwise a new line opens. If all slots are open, the oldest is closed
 *    before.
 *
 * The slots of an eye are a ring. From oldest on, open_count of them are open,
 * in the order in which they were opened; the others follow from unused on. */

void lum_lines_init(lum_assembler *a, const lum_assembler_storage *storage)
{
    const lum_assembler_config *c = &a->config;
    lum_line_slot *slot = storage->slots;
    uint32_t *words = storage->words;
    lum_reach *reach = storage->reach;
    memset(reach, 0,
           (size_t)LUM_ASSEMBLER_REACH(c->reorder_lines) * sizeof *reach);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_eye_state *eye = &a->eye[e];
        eye->reach = reach;
        eye->lines.oldest = slot;
        eye->lines.unused = slot;
        lum_lines_forget(a, eye);
        for (unsigned i = 0; i < c->open_lines; i++) {
            slot->line.angles = slot->angles;
            slot->line.angle_marks = slot->angle_marks;
            slot->line.words = words;
            slot->line.eye = (uint8_t)e;
            slot->words = words;
            slot->next = i + 1u < c->open_lines ? slot + 1 : eye->lines.oldest;
            words += c->words_per_line;
            slot++;
        }
        reach += c->reorder_lines;
    }
}

/* How far a packet's clock is ahead, in microseconds; bounded to 32 bits. */
static int32_t lead(const lum_awaited *packet, const int64_t *clock_us)
{
    return lum_stream_lead(&packet->clock_us, clock_us);
}

/* Step 3. The last R closed lines (reorder_lines) are known by number and
 * clock. What is older than these is known by its clock: it is below
 * low_clock_us, the largest clock with which a closed line began. */
static bool was_closed(const lum_assembler *a, const lum_eye_state *eye,
                       uint32_t number)
{
    const lum_awaited *packet = &a->awaited;
    const unsigned r = a->config.reorder_lines;
    for (unsigned i = 0; i < r; i++) {
        const lum_reach *closed = &eye->reach[i];
        if (closed->number == number &&
            stream_is_within(lead(packet, &closed->clock_us),
                             a->line_span_us)) {
            return true;
        }
    }
    return lead(packet, &eye->lines.low_clock_us) < 0;
}

lum_result lum_lines_find(lum_assembler *a, const lum_eye_state *eye,
                          uint32_t number, lum_line_slot **found)
{
    lum_awaited *packet = &a->awaited;
    const unsigned open_count = eye->lines.open_count;
    lum_line_slot *slot = eye->lines.oldest;
    for (unsigned i = 0; i < open_count; i++) {
        if (slot->line.number == number) {
            const int32_t ahead_us = lead(packet, &slot->line.clock_us);
            if (stream_is_within(ahead_us, a->line_span_us)) {
                *found = slot; /* step 1 */
                return LUM_OK;
            }
            if (ahead_us < 0) {
                return LUM_E_LATE; /* of an earlier frame */
            }
            /* step 2: this line and the i that are older */
            packet->to_close = (uint8_t)(i + 1u);
            return LUM_OK;
        }
        slot = slot->next;
    }
    if (was_closed(a, eye, number)) {
        return LUM_E_LATE;
    }
    /* step 4 */
    packet->to_close = open_count == a->config.open_lines ? 1 : 0;
    return LUM_OK;
}

lum_line_slot *lum_lines_open(const lum_assembler *a, lum_eye_state *eye,
                              uint32_t number)
{
    const lum_awaited *packet = &a->awaited;
    lum_line_slot *slot = eye->lines.unused;
    lum_line *line = &slot->line;
    LUM_CHECK(eye->lines.open_count < a->config.open_lines);
    eye->lines.unused = slot->next;
    eye->lines.open_count++;
    line->clock_us = packet->clock_us;
    line->arrival = packet->arrival;
    line->word_count = 0;
    line->lost_words = 0;
    line->number = number;
    line->angle_count = 0;
    slot->low_clock_us = INT64_MAX;
    slot->last_arrival = packet->arrival;
    slot->accepted = 0;
    slot->words_seen = 0;
    slot->words_end = 0;
    memset(slot->angle_marks, 0, sizeof slot->angle_marks);
    return slot;
}

void lum_lines_take(lum_assembler *a, lum_eye_state *eye, lum_line_slot *slot)
{
    const lum_awaited *packet = &a->awaited;
    slot->last_arrival = packet->arrival;
    if (packet->clock_us < slot->low_clock_us) {
        slot->low_clock_us = packet->clock_us;
    }
    /* Only the second packet decides the frame: one packet with a corrupted
     * line number must not begin a frame. From 2 on, accepted need not be
     * exact. */
    if (slot->accepted < 2 && ++slot->accepted == 2) {
        slot->frame = lum_frames_decide(a, eye, slot->line.number);
    }
}

/* The R lines that were closed last are kept in a ring, for was_closed(). */
static void remember(const lum_assembler *a, lum_eye_state *eye,
                     const lum_line *line)
{
    lum_eye_lines *lines = &eye->lines;
    lum_reach *closed = &eye->reach[lines->closed_next];
    LUM_CHECK(lines->closed_next < a->config.reorder_lines);
    closed->clock_us = line->clock_us;
    closed->number = line->number;
    lines->closed_next++;
    if (lines->closed_next == a->config.reorder_lines) {
        lines->closed_next = 0;
    }
}

/* Storage is used again; what an earlier line left there must not show. */
static void clear_unmarked(lum_line_slot *slot)
{
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        if ((slot->angle_marks[p / 32u] >> (p % 32u) & 1u) == 0) {
            slot->angles[p] = (lum_angle){0, 0};
        }
    }
}

lum_line *lum_lines_close(const lum_assembler *a, lum_eye_state *eye)
{
    lum_line_slot *slot = eye->lines.oldest;
    lum_line *line = &slot->line;
    LUM_CHECK(eye->lines.open_count > 0);
    eye->lines.oldest = slot->next;
    eye->lines.open_count--;
    if (slot->accepted < 2) {
        /* Too little to decide: the current frame, and no later packet is late
         * because of this line's clock, which may be corrupted. */
        slot->frame = eye->frames.frame;
    } else if (slot->low_clock_us > eye->lines.low_clock_us) {
        eye->lines.low_clock_us = slot->low_clock_us;
    }
    line->frame = slot->frame;
    /* The packets gave positions up to words_end, but brought fewer words. */
    if (slot->words_end > slot->words_seen) {
        line->lost_words = slot->words_end - slot->words_seen;
    }
    if (line->angle_count < LUM_LINE_PIXELS) {
        clear_unmarked(slot);
    }
    remember(a, eye, line);
    return line;
}

/* Moves an open line before the oldest, which stands behind all that are
 * unused. */
static void make_oldest(lum_eye_lines *lines, lum_line_slot *before_it)
{
    lum_line_slot *slot = before_it->next;
    lum_line_slot *last = before_it;
    LUM_CHECK(slot != lines->oldest);
    before_it->next = slot->next;
    while (last->next != lines->oldest) {
        last = last->next;
    }
    last->next = slot;
    slot->next = lines->oldest;
    if (lines->unused == lines->oldest) { /* all are open */
        lines->unused = slot;
    }
    lines->oldest = slot;
}

bool lum_lines_pull_idle(lum_eye_state *eye, int64_t before)
{
    lum_line_slot *slot = eye->lines.oldest;
    lum_line_slot *previous = NULL;
    for (unsigned i = 0; i < eye->lines.open_count; i++) {
        if (slot->last_arrival < before) {
            if (previous != NULL) {
                make_oldest(&eye->lines, previous);
            }
            return true;
        }
        previous = slot;
        slot = slot->next;
    }
    return false;
}

/* The clock has jumped: the clocks of closed lines mean nothing any more. */
void lum_lines_forget(const lum_assembler *a, lum_eye_state *eye)
{
    LUM_CHECK(eye->lines.open_count == 0);
    eye->lines.low_clock_us = STREAM_LONG_AGO;
    for (unsigned i = 0; i < a->config.reorder_lines; i++) {
        eye->reach[i].clock_us = STREAM_LONG_AGO;
    }
}
