#include "words.h"

#include "bytes.h"

#include <string.h>

/* The pixels of mark word w that lie in [first, end). */
static uint32_t range_mask(uint32_t w, uint32_t first, uint32_t end)
{
    const uint32_t base = 32u * w;
    uint32_t mask = 0xffffffffu;
    if (first > base) {
        mask &= 0xffffffffu << (first - base);
    }
    if (end < base + 32u) {
        mask &= 0xffffffffu >> (base + 32u - end);
    }
    return mask;
}

/* An int16_t may be written as its unsigned type, bit by bit as it came; where
 * the order is that of lum_angle this is a plain copy. */
static void copy_angles(lum_line_slot *slot, const lum_layout *layout,
                        const lum_group *group)
{
    uint16_t *restrict to =
        (uint16_t *)&slot->angles[group->first_sample_index];
    const uint8_t *restrict from = group->samples;
    const uint32_t values = 2u * group->num_samples;
    if (layout->profile.angle_order == LUM_AZIMUTH_ELEVATION) {
        for (uint32_t i = 0; i < values; i++) {
            to[i] = load_u16(from + (size_t)2 * i);
        }
    } else {
        for (uint32_t i = 0; i < values; i++) {
            to[i ^ 1u] = load_u16(from + (size_t)2 * i);
        }
    }
}

lum_result words_place_angles(lum_line_slot *slot, const lum_layout *layout,
                              const lum_group *group)
{
    const uint32_t first = group->first_sample_index;
    const uint32_t end = first + group->num_samples;
    uint32_t there = 0;
    uint32_t missing = 0;
    for (uint32_t w = first / 32u; w <= (end - 1u) / 32u; w++) {
        const uint32_t mask = range_mask(w, first, end);
        there |= slot->angle_marks[w] & mask;
        missing |= ~slot->angle_marks[w] & mask;
    }
    if (there != 0) {
        return missing == 0 ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    for (uint32_t w = first / 32u; w <= (end - 1u) / 32u; w++) {
        slot->angle_marks[w] |= range_mask(w, first, end);
    }
    slot->angle_count = (uint16_t)(slot->angle_count + group->num_samples);
    copy_angles(slot, layout, group);
    return LUM_OK;
}

/* Copies words and tells whether all are good and in order of pixels. */
static bool copy_if_in_order(uint32_t *restrict to,
                             const uint8_t *restrict from, uint32_t n)
{
    uint32_t any = load_u32(from);
    uint32_t borrow = 0;
    to[0] = any;
    for (uint32_t i = 1; i < n; i++) {
        const uint32_t word = load_u32(from + (size_t)LUM_SAMPLE_BYTES * i);
        const uint32_t before =
            load_u32(from + (size_t)LUM_SAMPLE_BYTES * (i - 1u));
        to[i] = word;
        any |= word;
        borrow |= (word & LUM_WORD_PIXEL) - (before & LUM_WORD_PIXEL);
    }
    return (any & LUM_WORD_ZERO) == 0 && (borrow >> 31) == 0 &&
           lum_word_is_good(to[n - 1u]);
}

/* The usual case: good words, behind all the line has. What was copied counts
 * only once word_count says so. */
static bool append(lum_line_slot *slot, uint32_t capacity,
                   const lum_group *group)
{
    uint32_t *to = slot->words + slot->word_count;
    if (group->num_samples > capacity - slot->word_count) {
        return false;
    }
    const uint32_t first = lum_group_word(group, 0);
    if (slot->word_count > 0 &&
        lum_word_pixel(first) <= lum_word_pixel(to[-1])) {
        return false;
    }
    if (!copy_if_in_order(to, group->samples, group->num_samples)) {
        return false;
    }
    slot->word_count += group->num_samples;
    return true;
}

/* How many words are good, and how many of them find words of their pixel. */
static uint32_t count_good(const lum_line_slot *slot, const lum_group *group,
                           uint16_t *placement, uint32_t *there)
{
    uint32_t good = 0;
    memset(placement, 0, LUM_LINE_PIXELS * sizeof *placement);
    for (uint32_t i = 0; i < slot->word_count; i++) {
        placement[lum_word_pixel(slot->words[i])] = 1;
    }
    *there = 0;
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = lum_group_word(group, i);
        if (lum_word_is_good(word)) {
            good++;
            *there += placement[lum_word_pixel(word)];
        }
    }
    return good;
}

/* Moves the line's words apart, from the end, and leaves in placement where
 * each pixel of the packet begins. */
static void make_room(lum_line_slot *slot, const lum_group *group,
                      uint16_t *placement, uint32_t good)
{
    uint32_t from = slot->word_count;
    uint32_t to = slot->word_count + good;
    memset(placement, 0, LUM_LINE_PIXELS * sizeof *placement);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = lum_group_word(group, i);
        if (lum_word_is_good(word)) {
            placement[lum_word_pixel(word)]++;
        }
    }
    for (uint32_t pixel = LUM_LINE_PIXELS; pixel-- > 0;) {
        while (from > 0 && lum_word_pixel(slot->words[from - 1u]) == pixel) {
            slot->words[--to] = slot->words[--from];
        }
        to -= placement[pixel];
        placement[pixel] = (uint16_t)to;
    }
}

static void insert(lum_line_slot *slot, const lum_group *group,
                   uint16_t *placement, uint32_t good)
{
    make_room(slot, group, placement, good);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = lum_group_word(group, i);
        if (lum_word_is_good(word)) {
            slot->words[placement[lum_word_pixel(word)]++] = word;
        }
    }
    slot->word_count += good;
}

static lum_result place(lum_line_slot *slot, uint32_t capacity,
                        const lum_group *group, uint16_t *placement,
                        uint64_t *bad_words)
{
    uint32_t there = 0;
    if (append(slot, capacity, group)) {
        return LUM_OK;
    }
    const uint32_t good = count_good(slot, group, placement, &there);
    if (there > 0) {
        return there == good ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    if (good > capacity - slot->word_count) {
        return LUM_E_NO_ROOM;
    }
    if (good > 0) {
        insert(slot, group, placement, good);
    }
    *bad_words += group->num_samples - good;
    return LUM_OK;
}

lum_result words_place_ranges(lum_line_slot *slot, uint32_t capacity,
                              const lum_group *group,
                              uint16_t placement[LUM_LINE_PIXELS],
                              uint64_t *bad_words)
{
    const lum_result r = place(slot, capacity, group, placement, bad_words);
    if (r != LUM_OK) {
        return r;
    }
    const uint64_t end =
        (uint64_t)group->first_sample_index + group->num_samples;
    slot->words_seen += group->num_samples;
    if (end <= capacity && end > slot->words_end) {
        slot->words_end = (uint32_t)end;
    }
    return LUM_OK;
}
