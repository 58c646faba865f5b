#include "lum/returns.h"

#include "lum/group.h"

#include <stdbool.h>

static bool is_one_pixel(uint32_t a, uint32_t b)
{
    return ((a ^ b) & (uint32_t)LUM_WORD_PIXEL) == 0;
}

static bool is_pulse(uint32_t first, uint32_t second)
{
    return (first & ~second & LUM_WORD_RISING) != 0;
}

static uint32_t pulse_width(uint32_t rise, uint32_t fall)
{
    const int32_t width = lum_word_tof(fall) - lum_word_tof(rise);
    return width > 0 ? (uint32_t)width : 0;
}

/* Where an edge's count stands in a pair of 16 bits. */
static unsigned shift_of(uint32_t word)
{
    return (unsigned)((word & LUM_WORD_RISING) >> 6);
}

/* How many words the first pixel has; counts: of each edge. */
static size_t count_words(const uint32_t *words, size_t n, uint32_t *counts)
{
    uint32_t pair = UINT32_C(1) << shift_of(words[0]);
    size_t i = 1;
    while (i < n && is_one_pixel(words[0], words[i])) {
        pair += UINT32_C(1) << shift_of(words[i]);
        i++;
    }
    *counts = pair;
    return i;
}

/* All words of a pixel that has both edges. The k-th falling word ends the
 * pulse that the k-th rising one began. */
static void number_both(const uint32_t *words, size_t n, uint32_t counts,
                        lum_return *out)
{
    size_t fall = 0;
    uint32_t seen = 0;
    for (size_t i = 0; i < n; i++) {
        const unsigned shift = shift_of(words[i]);
        seen += UINT32_C(1) << shift;
        out[i].number = (uint16_t)(seen >> shift & 0xffffu);
        out[i].count = (uint16_t)(counts >> shift & 0xffffu);
        out[i].width_tof = 0;
        if (shift != 0) {
            while (fall < n && lum_word_is_rising(words[fall])) {
                fall++;
            }
            if (fall < n) {
                out[i].width_tof = pulse_width(words[i], words[fall]);
                fall++;
            }
        }
    }
}

/* All words of a pixel that has one edge. */
static void number_one(size_t n, lum_return *out)
{
    for (size_t i = 0; i < n; i++) {
        out[i] =
            (lum_return){.number = (uint16_t)(i + 1u), .count = (uint16_t)n};
    }
}

/* Numbers the words of the first pixel. Returns how many it has. */
static size_t number_pixel(const uint32_t *words, size_t n, lum_return *out)
{
    uint32_t counts = 0;
    const size_t count = count_words(words, n, &counts);
    if ((counts & 0xffffu) == 0 || counts >> 16 == 0) {
        number_one(count, out);
    } else {
        number_both(words, count, counts, out);
    }
    return count;
}

/* Most pixels have one return, a rising word and a falling one or none: these
 * are numbered at once. */
void lum_returns_compute(const uint32_t *words, size_t n, lum_return *out)
{
    static const lum_return lone = {.number = 1, .count = 1};
    while (n > 0) {
        size_t count = 1;
        out[0] = lone;
        if (n > 1 && is_one_pixel(words[0], words[1])) {
            count = 2;
            if ((n == 2 || !is_one_pixel(words[0], words[2])) &&
                is_pulse(words[0], words[1])) {
                out[0].width_tof = pulse_width(words[0], words[1]);
                out[1] = lone;
            } else {
                count = number_pixel(words, n, out);
            }
        }
        words += count;
        out += count;
        n -= count;
    }
}
