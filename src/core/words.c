#include "words.h"

#include "bytes.h"
#include "counter.h"

#include <string.h>

#define ALL_BITS 0xffffffffu

/* Flips the marks of n pixels. LUM_OK where none was set, LUM_E_DUPLICATE where
 * all were, else LUM_E_CONFLICT. */
static lum_result flip_marks(uint32_t *marks, uint32_t first, uint32_t n)
{
    const uint32_t last = first + n - 1u;
    uint32_t mask = ALL_BITS << (first % 32u);
    uint32_t set = 0;
    uint32_t clear = 0;
    for (uint32_t w = first / 32u; w <= last / 32u; w++) {
        if (w == last / 32u) {
            mask &= ALL_BITS >> (31u - last % 32u);
        }
        set |= marks[w] & mask;
        marks[w] ^= mask;
        clear |= marks[w] & mask;
        mask = ALL_BITS;
    }
    if (set == 0) {
        return LUM_OK;
    }
    return clear == 0 ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
}

/* An int16_t may be written as its unsigned type, bit by bit as it came; where
 * the order is that of lum_angle this is a plain copy. */
static void copy_angles(lum_angle *angles, const lum_group *group,
                        uint8_t angle_order)
{
    uint16_t *restrict to = (uint16_t *)angles;
    const uint8_t *restrict from = group->samples;
    const uint32_t values = 2u * group->num_samples;
    if (angle_order == LUM_AZIMUTH_ELEVATION) {
        for (uint32_t i = 0; i < values; i++) {
            to[i] = load_u16(from + (size_t)2 * i);
        }
    } else {
        for (uint32_t i = 0; i < values; i++) {
            to[i ^ 1u] = load_u16(from + (size_t)2 * i);
        }
    }
}

lum_result lum_words_place_angles(const lum_assembler *a, lum_line_slot *slot,
                                  const lum_group *group)
{
    const uint32_t first = group->first_sample_index;
    const uint32_t n = group->num_samples;
    const lum_result r = flip_marks(slot->angle_marks, first, n);
    if (r != LUM_OK) {
        (void)flip_marks(slot->angle_marks, first, n);
        return r;
    }
    slot->line.angle_count = (uint16_t)(slot->line.angle_count + n);
    copy_angles(&slot->angles[first], group, a->angle_order);
    return LUM_OK;
}

/* Where a word belongs: a good one at its pixel, a bad one behind them all. */
static uint32_t place_of(uint32_t word)
{
    return word & (LUM_WORD_ZERO | LUM_WORD_PIXEL);
}

/* Copies words and tells whether all are good and in order of pixels, from
 * first on. */
static bool copy_if_in_order(uint32_t *restrict to,
                             const uint8_t *restrict from, uint32_t n,
                             uint32_t first)
{
    to[0] = load_u32(from);
    uint32_t borrow = place_of(to[0]) - first;
    for (uint32_t i = 1; i < n; i++) {
        const uint32_t before = load_u32(from);
        from += LUM_SAMPLE_BYTES;
        const uint32_t word = load_u32(from);
        to[i] = word;
        borrow |= place_of(word) - place_of(before);
    }
    return borrow >> 31 == 0 && place_of(to[n - 1u]) < LUM_LINE_PIXELS;
}

/* What was copied counts only once word_count says so. */
bool lum_words_append(const lum_assembler *a, lum_line_slot *slot,
                      const lum_group *group)
{
    const uint32_t n = group->num_samples;
    const uint32_t count = slot->line.word_count;
    uint32_t *to = slot->words + count;
    if (n > a->config.words_per_line - count) {
        return false;
    }
    const uint32_t first = count > 0 ? place_of(to[-1]) + 1u : 0;
    if (!copy_if_in_order(to, group->samples, n, first)) {
        return false;
    }
    slot->line.word_count = count + n;
    return true;
}

/* How many words are good, and in placement how many of each pixel, as far as
 * a line can hold them. */
static uint32_t count_good(const lum_group *group, uint16_t *placement)
{
    uint32_t good = 0;
    memset(placement, 0, LUM_LINE_PIXELS * sizeof *placement);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t pixel = place_of(lum_group_word(group, i));
        if (pixel < LUM_LINE_PIXELS && placement[pixel] <= LUM_LINE_WORDS_MAX) {
            placement[pixel]++;
            good++;
        }
    }
    return good;
}

/* How many of the counted words find words of their pixel. They are out of
 * placement then: their packet has no place. */
static uint32_t take_there(const lum_line *line, uint16_t *placement)
{
    uint32_t there = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        uint16_t *count = &placement[place_of(line->words[i])];
        there += *count;
        *count = 0;
    }
    return there;
}

/* Moves the line's words apart, from the end, and leaves in placement where
 * each pixel of the packet begins. */
static void make_room(uint32_t *words, uint32_t from, uint32_t to,
                      uint16_t *placement)
{
    for (uint32_t pixel = LUM_LINE_PIXELS; pixel-- > 0;) {
        while (from > 0 && place_of(words[from - 1u]) == pixel) {
            words[--to] = words[--from];
        }
        to -= placement[pixel];
        placement[pixel] = (uint16_t)to;
    }
}

lum_result lum_words_insert(lum_assembler *a, lum_line_slot *slot,
                            const lum_group *group)
{
    const uint32_t count = slot->line.word_count;
    const uint32_t good = count_good(group, a->placement);
    const uint32_t there = take_there(&slot->line, a->placement);
    if (there > 0) {
        return there == good ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    if (good > a->config.words_per_line - count) {
        return LUM_E_NO_ROOM;
    }
    make_room(slot->words, count, count + good, a->placement);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = lum_group_word(group, i);
        const uint32_t pixel = place_of(word);
        if (pixel < LUM_LINE_PIXELS) {
            slot->words[a->placement[pixel]++] = word;
        }
    }
    slot->line.word_count += good;
    lum_counter_add(&a->counters.bad_words, group->num_samples - good);
    return LUM_OK;
}

/* Where the line cannot hold them, they tell nothing of what it lost. */
void lum_words_count_sent(const lum_assembler *a, lum_line_slot *slot,
                          const lum_group *group)
{
    const uint32_t capacity = a->config.words_per_line;
    const uint32_t n = group->num_samples;
    const uint32_t end = group->first_sample_index + n;
    if (n > capacity - slot->words_seen) {
        slot->words_seen = capacity;
    } else {
        slot->words_seen += n;
    }
    /* below n, it has gone over its 32 bits */
    if (end >= n && end <= capacity && end > slot->words_end) {
        slot->words_end = end;
    }
}
