#include "words.h"

#include "bytes.h"
#include "check.h"
#include "counter.h"
#include "group.h"
#include "layout.h"
#include "product.h"

#include <string.h>

/* A line has two kinds of samples. Angles have a fixed place each, so a bit for
 * each pixel tells which are there. A pixel can have any number of range words,
 * so these are one array, ordered by pixel. A packet is taken whole or not at
 * all: if some of its pixels are there already, all of it is dropped. */

#define ALL_BITS 0xffffffffu

/* Flips the marks of n pixels, 32 at a time. LUM_OK if none was set,
 * LUM_E_DUPLICATE if all were, else LUM_E_CONFLICT. Flipping them again
 * restores them. */
static lum_result flip_marks(uint32_t *marks, uint32_t first, uint32_t n)
{
    uint32_t end = first % 32u + n; /* from the first word's lowest bit */
    uint32_t mask = ALL_BITS << (first % 32u);
    uint32_t set = 0;
    uint32_t clear = 0;
    LUM_CHECK(n > 0);
    LUM_CHECK(first + n <= LUM_LINE_PIXELS);
    marks += first / 32u;
    for (;; end -= 32u) {
        if (end < 32u) {
            mask &= ~(ALL_BITS << end);
        }
        set |= *marks & mask;
        *marks ^= mask;
        clear |= *marks & mask;
        if (end <= 32u) {
            break;
        }
        mask = ALL_BITS;
        marks++;
    }
    if (set == 0) {
        return LUM_OK;
    }
    return clear == 0 ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
}

lum_result lum_words_place_angles(lum_line_slot *slot, const lum_group *group,
                                  uint8_t angle_order)
{
    const uint32_t first = group->first_sample_index;
    const uint32_t n = group->num_samples;
    const lum_result r = flip_marks(slot->angle_marks, first, n);
    if (r != LUM_OK) {
        (void)flip_marks(slot->angle_marks, first, n);
        return r;
    }
    slot->line.angle_count = (uint16_t)(slot->line.angle_count + n);
    lum_layout_copy_angles(&slot->angles[first], group, angle_order);
    return LUM_OK;
}

/* Copies words that are good and in order of pixels, from first on; false: not
 * all are. It is made once for each order of bytes. */
#if LUM_VECTORS
/* Compilers make vector code of a loop whose turns need nothing of each other
 * and have no branch. So the word before is read again, and where a place is
 * below the one before it, the difference is negative and sets the highest bit
 * of borrow. If the places only rise, only the last can be too high. */
static LUM_IN_PLACE bool copy_words(uint32_t *restrict to,
                                    const uint8_t *restrict from, uint32_t n,
                                    uint32_t first, uint8_t order)
{
    const size_t end = (size_t)LUM_SAMPLE_BYTES * n;
    uint32_t borrow = 0;
    to[0] = load_sample(from, order);
    if (place_of(to[0]) < first) {
        return false;
    }
    for (uint32_t i = 1; i < n; i++) {
        const size_t at = (size_t)LUM_SAMPLE_BYTES * i;
        const uint32_t word = load_sample(from + at, order);
        const uint32_t before =
            load_sample(from + at - LUM_SAMPLE_BYTES, order);
        to[i] = word;
        borrow |= place_of(word) - place_of(before);
    }
    return borrow >> 31 == 0 &&
           place_of(load_sample(from + end - LUM_SAMPLE_BYTES, order)) <
               LUM_LINE_PIXELS;
}
#else
static LUM_IN_PLACE bool copy_words(uint32_t *restrict to,
                                    const uint8_t *restrict from, uint32_t n,
                                    uint32_t first, uint8_t order)
{
    const uint8_t *const end = from + (size_t)LUM_SAMPLE_BYTES * n;
    do {
        const uint32_t word = load_sample(from, order);
        const uint32_t place = place_of(word);
        from += LUM_SAMPLE_BYTES;
        if (place < first) {
            return false;
        }
        first = place;
        *to++ = word;
    } while (from != end);
    return first < LUM_LINE_PIXELS;
}
#endif

/* Where flash is dear, words of the other order go the longer way. */
static bool copy_in_order(uint32_t *to, const lum_group *group, uint32_t first)
{
    const uint32_t n = group->num_samples;
    if (group->sample_order == LUM_ORDER_LITTLE) {
        return copy_words(to, group->samples, n, first, LUM_ORDER_LITTLE);
    }
#if LUM_BY_PARTS
    return false;
#else
    return copy_words(to, group->samples, n, first, LUM_ORDER_BIG);
#endif
}

/* The usual case: the packet's words are all good, in order of pixels, behind
 * all that the line has, and few enough. What was copied counts only once
 * word_count says so. */
static bool append(const lum_assembler *a, lum_line_slot *slot,
                   const lum_group *group)
{
    const uint32_t n = group->num_samples;
    const uint32_t count = slot->line.word_count;
    uint32_t *to = slot->words + count;
    if (n > a->config.words_per_line - count) {
        return false;
    }
    const uint32_t first = count > 0 ? place_of(to[-1]) + 1u : 0;
    if (!copy_in_order(to, group, first)) {
        return false;
    }
    slot->line.word_count = count + n;
    return true;
}

/* Any other packet is merged into the words of the line, in place:
 *
 * 1. count_good(): table[pixel] is how many words of the packet the pixel has.
 * 2. count_there(): if the line has words of one of these pixels already, the
 *    packet is dropped.
 * 3. make_room(): the line's words move up, the last first, so that gaps appear
 *    where the packet's words belong; table[pixel] is then where a gap begins.
 * 4. fill_room(): the packet's words go into the gaps, in their order.
 * 5. The table is set to 0 again, from the packet's lowest pixel to its
 * highest, so that a call costs nothing for the other pixels. */

struct merge {
    uint32_t *words; /* of the line */
    uint16_t *table;
    uint32_t good; /* words of the packet; they may be too many for a line */
    uint32_t low;  /* their lowest pixel, from step 2 on */
    uint32_t end;  /* behind their highest pixel */
};

/* Step 1. A line holds LUM_LINE_WORDS_MAX words, so one more is enough to know
 * that it has no room. */
static void count_good(struct merge *m, const lum_group *group)
{
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t pixel = place_of(group_word(group, i));
        if (pixel < LUM_LINE_PIXELS && m->table[pixel] <= LUM_LINE_WORDS_MAX) {
            m->table[pixel]++;
            m->good++;
            if (pixel >= m->end) {
                m->end = pixel + 1u;
            }
        }
    }
}

/* The next lower pixel that the packet has words of; there is one. */
static inline uint32_t next_below(const struct merge *m, uint32_t pixel)
{
    do {
        pixel--;
    } while (m->table[pixel] == 0);
    return pixel;
}

/* Step 2: how many words of the packet belong to pixels that have words in the
 * line. Both are walked down side by side, from the highest pixel; the line's
 * words of higher pixels are passed by four at a time as long as there are so
 * many. */
static uint32_t count_there(struct merge *m, uint32_t count)
{
    const uint32_t *const words = m->words;
    uint32_t there = 0;
    uint32_t pixel = m->end;
    for (uint32_t left = m->good; left > 0;) {
        pixel = next_below(m, pixel);
        while (count >= 4u && place_of(words[count - 4u]) > pixel) {
            count -= 4u;
        }
        for (; count > 0; count--) {
            const uint32_t place = place_of(words[count - 1u]);
            if (place <= pixel) {
                if (place == pixel) {
                    there += m->table[pixel];
                }
                break;
            }
        }
        left -= m->table[pixel];
    }
    m->low = pixel;
    return there;
}

/* Step 3. good is how many words of the packet are still to be placed, and so
 * how far the line's words above this pixel move. */
static void make_room(const struct merge *m, uint32_t count)
{
    uint32_t *const words = m->words;
    uint32_t pixel = m->end;
    for (uint32_t good = m->good; good > 0;) {
        pixel = next_below(m, pixel);
        while (count > 0 && place_of(words[count - 1u]) > pixel) {
            count--;
            words[count + good] = words[count];
        }
        good -= m->table[pixel];
        m->table[pixel] = (uint16_t)(count + good);
    }
}

/* Step 4. */
static void fill_room(const struct merge *m, const lum_group *group)
{
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = group_word(group, i);
        const uint32_t pixel = place_of(word);
        if (pixel < LUM_LINE_PIXELS) {
            m->words[m->table[pixel]++] = word;
        }
    }
}

static lum_result insert(lum_assembler *a, lum_line_slot *slot,
                         const lum_group *group)
{
    struct merge m = {.words = slot->words, .table = a->placement};
    lum_result r = LUM_OK;
    const uint32_t count = slot->line.word_count;
    LUM_CHECK(count <= a->config.words_per_line);
    count_good(&m, group);
    const uint32_t there = count_there(&m, count);
    if (there > 0) {
        r = there == m.good ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    } else if (m.good > a->config.words_per_line - count) {
        r = LUM_E_NO_ROOM;
    } else {
        make_room(&m, count);
        fill_room(&m, group);
        slot->line.word_count = count + m.good;
        lum_counter_add(&a->counters.bad_words, group->num_samples - m.good);
    }
    memset(m.table + m.low, 0, (size_t)(m.end - m.low) * sizeof *m.table);
    return r;
}

void lum_words_count_sent(lum_line_slot *slot, const lum_group *group,
                          uint32_t capacity)
{
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

lum_result lum_words_place_ranges(lum_assembler *a, lum_line_slot *slot,
                                  const lum_group *group)
{
    const lum_result r =
        append(a, slot, group) ? LUM_OK : insert(a, slot, group);
    if (r == LUM_OK) {
        lum_words_count_sent(slot, group, a->config.words_per_line);
    }
    return r;
}
