#include "lum/receiver.h"

#include "bytes.h"
#include "check.h"
#include "clock.h"
#include "counter.h"
#include "group.h"
#include "layout.h"
#include "product.h"
#include "words.h"

#include <stddef.h>
#include <string.h>

#define REACH 8u /* lines */

/* All clocks compared here are of one eye and within gap_us of its newest
 * clock; otherwise the eye has started again. So the low 32 bits show which is
 * older. */

/* --- Opening --- */

/* A line of which nothing is known. */
static LUM_ONE_COPY void clear_line(const lum_receiver *r, lum_line_slot *slot)
{
    memset(slot, 0, offsetof(lum_line_slot, angles));
    slot->line.angles = slot->angles;
    slot->line.angle_marks = slot->angle_marks;
    slot->line.words = r->words;
}

lum_result lum_receiver_init(lum_receiver *r, const lum_layout *layout,
                             uint32_t gap_us, uint32_t *words,
                             uint32_t word_count)
{
    const lum_profile *profile = &layout->profile;
    if (gap_us >= LUM_GAP_US_END || !lum_layout_is_read(layout)) {
        return LUM_E_VALUE;
    }
    if (word_count == 0) {
        return LUM_E_SPACE;
    }
    memset(r, 0, sizeof *r);
    r->angle_order = profile->angle_order;
    lum_clock_init(&r->clock, profile);
    r->line_span_us = profile->line_span_us;
    r->gap_us = gap_us;
    r->words = words;
    r->word_room = word_count;
    clear_line(r, &r->eye[0].slot);
    r->line = &r->eye[0].slot.line;
    return LUM_OK;
}

const lum_line *lum_receiver_line(const lum_receiver *r)
{
    return r->line;
}

bool lum_receiver_is_sorted(const lum_receiver *r)
{
    return r->is_sorted;
}

const lum_receiver_counters *lum_receiver_counted(const lum_receiver *r)
{
    return &r->counters;
}

/* --- Lines --- */

static bool is_within(uint32_t ahead_us, uint32_t reach_us)
{
    return ahead_us + reach_us <= 2u * reach_us;
}

static bool is_before(const lum_receiver *r, uint32_t clock_us,
                      uint32_t other_us)
{
    return other_us - clock_us - 1u < r->gap_us;
}

/* Numbers between two lines of a frame; those before the first of the next
 * frame, whose number has fallen by more than the reach. */
static uint32_t count_skipped(uint32_t last, uint32_t number)
{
    if (number > last) {
        return number - last - 1u;
    }
    return last - number > REACH ? number : 0;
}

/* Two packets have agreed on the line: packets older than both are late from
 * now on, and once the line has ended, so are its own packets. */
static void settle(lum_receiver *r, lum_receiver_eye *eye)
{
    const lum_line *line = &eye->slot.line;
    if (eye->has_settled) {
        lum_counter_add(&r->counters.lines_skipped,
                        count_skipped(eye->settled, line->number));
    }
    eye->has_settled = true;
    eye->settled = line->number;
    eye->settled_us = is_before(r, r->clock_us, (uint32_t)line->clock_us)
                          ? r->clock_us
                          : (uint32_t)line->clock_us;
}

static void close_line(lum_receiver *r, lum_receiver_eye *eye)
{
    lum_receiver_counters *c = &r->counters;
    const lum_line *line = &eye->slot.line;
    if (!eye->is_open) {
        return;
    }
    eye->is_open = false;
    lum_counter_add(&c->lines, 1);
    lum_counter_add(&c->lost_words, line->lost_words);
    if (line->angle_count < LUM_LINE_PIXELS) {
        lum_counter_add(&c->lines_missing_angles, 1);
    }
}

static void open_line(const lum_receiver *r, lum_receiver_eye *eye,
                      const lum_group *group)
{
    lum_line_slot *slot = &eye->slot;
    eye->is_open = true;
    memset(eye->word_marks, 0, sizeof eye->word_marks);
    clear_line(r, slot);
    slot->line.eye = group->eye;
    slot->line.number = group->line;
    slot->line.clock_us = r->clock_us;
}

/* --- Clocks --- */

/* Any clock may come next. */
static void begin_anew(lum_receiver *r, lum_receiver_eye *eye)
{
    close_line(r, eye);
    eye->has_heard = false;
    eye->has_settled = false;
}

/* The clock of a packet (docs/protocol.md, section 6, Reassembly, rules 1 and
 * 2): returns false for a stray. */
static LUM_ONE_COPY bool follow(lum_receiver *r, lum_receiver_eye *eye,
                                const lum_group *group)
{
    uint64_t ticks = 0;
    const uint32_t clock_us =
        (uint32_t)lum_clock_follow(&r->clock, group, &ticks);
    const uint32_t gap_us = r->gap_us;
    if (eye->has_heard && !is_within(clock_us - eye->newest_us, gap_us)) {
        if (!eye->has_candidate ||
            !is_within(clock_us - eye->candidate_us, gap_us)) {
            eye->candidate_us = clock_us;
            eye->has_candidate = true;
            return false;
        }
        begin_anew(r, eye);
    }
    eye->has_candidate = false;
    if (!eye->has_heard || is_before(r, eye->newest_us, clock_us)) {
        eye->newest_us = clock_us;
    }
    eye->has_heard = true;
    r->clock_us = clock_us;
    clock_take(&r->clock, &ticks);
    return true;
}

/* For a packet that is not of the current line. Clocks distinguish a line from
 * the same number of another frame; if they do not, the numbers show that it is
 * older. */
static bool is_late(const lum_receiver *r, const lum_receiver_eye *eye,
                    uint32_t number, uint32_t clock_us)
{
    if (!eye->has_settled) {
        return false;
    }
    const uint32_t behind = eye->settled - number;
    return is_before(r, clock_us, eye->settled_us) ||
           (behind <= REACH && is_within(clock_us - eye->settled_us,
                                         behind == 0 ? r->line_span_us : 0));
}

/* Makes the packet's line the current one; false: it is late. */
static LUM_ONE_COPY bool go_to_line(lum_receiver *r, lum_receiver_eye *eye,
                                    const lum_group *group)
{
    const lum_line *line = &eye->slot.line;
    const uint32_t clock_us = r->clock_us;
    if (eye->is_open && line->number == group->line) {
        const uint32_t line_us = (uint32_t)line->clock_us;
        if (is_within(clock_us - line_us, r->line_span_us)) {
            return true;
        }
        if (is_before(r, clock_us, line_us)) {
            return false;
        }
    } else if (is_late(r, eye, group->line, clock_us)) {
        return false;
    }
    close_line(r, eye);
    open_line(r, eye, group);
    return true;
}

/* --- Words and packets --- */

static uint32_t mark_of(const uint32_t *marks, uint32_t pixel)
{
    return marks[pixel / 32u] >> (pixel % 32u) & 1u;
}

/* Copies the good words, as many as there is room for, and tells whether some
 * or all of them are of pixels that have words. */
static lum_result copy_words(lum_receiver *r, const lum_receiver_eye *eye,
                             const lum_group *group, uint32_t *count)
{
    uint32_t there = 0;
    uint32_t good = 0;
    uint32_t before = 0;
    uint32_t borrow = 0; /* its highest bit: a pixel was below the one before */
    const uint32_t n = group->num_samples;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t word = group_word(group, i);
        const uint32_t pixel = place_of(word);
        if (pixel < LUM_LINE_PIXELS) {
            if (good < r->word_room) {
                r->words[good] = word;
            }
            good++;
            there += mark_of(eye->word_marks, pixel);
            borrow |= pixel - before;
            before = pixel;
        }
    }
    *count = good;
    if (there > 0) {
        return there == good ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    if (good > r->word_room) {
        return LUM_E_NO_ROOM;
    }
    r->is_sorted = borrow >> 31 == 0;
    return LUM_OK;
}

static lum_result take_words(lum_receiver *r, lum_receiver_eye *eye,
                             const lum_group *group)
{
    lum_line_slot *slot = &eye->slot;
    uint32_t count = 0;
    const lum_result result = copy_words(r, eye, group, &count);
    if (result != LUM_OK) {
        return result;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t pixel = lum_word_pixel(r->words[i]);
        eye->word_marks[pixel / 32u] |= UINT32_C(1) << (pixel % 32u);
    }
    lum_words_count_sent(slot, group, LUM_LINE_WORDS_MAX);
    slot->line.lost_words = slot->words_end > slot->words_seen
                                ? slot->words_end - slot->words_seen
                                : 0;
    slot->line.word_count = count;
    lum_counter_add(&r->counters.words, count);
    lum_counter_add(&r->counters.bad_words, group->num_samples - count);
    return LUM_OK;
}

/* Samples into their line. */
static LUM_ONE_COPY lum_result accept(lum_receiver *r, lum_receiver_eye *eye,
                                      const lum_group *group)
{
    lum_line_slot *slot = &eye->slot;
    const lum_result result =
        group->tag == LUM_TAG_ANGLES
            ? lum_words_place_angles(slot, group, r->angle_order)
            : take_words(r, eye, group);
    if (result == LUM_OK) {
        r->line = &slot->line;
        slot->accepted++;
        if (slot->accepted == 2) {
            settle(r, eye);
        }
    }
    return result;
}

static lum_result take(lum_receiver *r, const lum_group *group)
{
    lum_receiver_eye *eye = &r->eye[group->eye];
    if (!follow(r, eye, group)) {
        return LUM_E_STRAY;
    }
    if (!go_to_line(r, eye, group)) {
        return LUM_E_LATE;
    }
    return accept(r, eye, group);
}

/* The counters of drops come first and in the order of their results. */
#define CHECK_DROP(name, member, result)                                       \
    LUM_CHECK_BUILD(name,                                                      \
                    offsetof(lum_receiver_counters, member) ==                 \
                        sizeof(uint64_t) * (size_t)(LUM_E_STRAY - (result)))
CHECK_DROP(stray_is_where_its_result_says, stray, LUM_E_STRAY);
CHECK_DROP(late_is_where_its_result_says, late, LUM_E_LATE);
CHECK_DROP(duplicate_is_where_its_result_says, duplicate, LUM_E_DUPLICATE);
CHECK_DROP(conflict_is_where_its_result_says, conflict, LUM_E_CONFLICT);
CHECK_DROP(no_room_is_where_its_result_says, no_room, LUM_E_NO_ROOM);

static void count_drop(lum_receiver_counters *c, lum_result result)
{
    uint64_t *counters = &c->stray;
    LUM_CHECK(result <= LUM_E_STRAY);
    LUM_CHECK(result >= LUM_E_NO_ROOM);
    lum_counter_add(&counters[LUM_E_STRAY - result], 1);
}

lum_result lum_receiver_push(lum_receiver *r, const lum_group *group)
{
    if (r->word_room == 0) {
        return LUM_E_ORDER;
    }
    r->line->word_count = 0;
    r->is_sorted = true;
    if (group->eye >= LUM_EYES ||
        lum_group_check(group->tag, group->num_samples,
                        group->first_sample_index) != LUM_OK) {
        return LUM_E_VALUE;
    }
    const lum_result result = take(r, group);
    if (result != LUM_OK) {
        count_drop(&r->counters, result);
    }
    return result;
}

void lum_receiver_forget(lum_receiver *r)
{
    if (r->line != NULL) {
        r->line->word_count = 0;
    }
    for (unsigned e = 0; e < LUM_EYES; e++) {
        begin_anew(r, &r->eye[e]);
    }
}
