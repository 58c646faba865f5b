#include "lum/returns.h"

#include "lum/group.h"

#include <stdbool.h>

/* Numbers those of the words [begin, end) of one pixel that bear an edge. */
static void number_edge(const uint32_t *words, size_t begin, size_t end,
                        bool rising, lum_return *out)
{
    uint16_t count = 0;
    for (size_t i = begin; i < end; i++) {
        if (lum_word_is_rising(words[i]) == rising) {
            count++;
            out[i].number = count;
            out[i].width_tof = 0;
        }
    }
    for (size_t i = begin; i < end; i++) {
        if (lum_word_is_rising(words[i]) == rising) {
            out[i].count = count;
        }
    }
}

static size_t next_of_edge(const uint32_t *words, size_t i, size_t end,
                           bool rising)
{
    while (i < end && lum_word_is_rising(words[i]) != rising) {
        i++;
    }
    return i;
}

/* The k-th falling word ends the pulse that the k-th rising one began. */
static void measure_pulses(const uint32_t *words, size_t begin, size_t end,
                           lum_return *out)
{
    size_t rise = next_of_edge(words, begin, end, true);
    size_t fall = next_of_edge(words, begin, end, false);
    while (rise < end && fall < end) {
        const int32_t width =
            lum_word_tof(words[fall]) - lum_word_tof(words[rise]);
        out[rise].width_tof = width > 0 ? (uint32_t)width : 0;
        rise = next_of_edge(words, rise + 1, end, true);
        fall = next_of_edge(words, fall + 1, end, false);
    }
}

static void number_run(const uint32_t *words, size_t begin, size_t end,
                       lum_return *out)
{
    number_edge(words, begin, end, true, out);
    number_edge(words, begin, end, false, out);
    measure_pulses(words, begin, end, out);
}

static size_t end_of_pixel(const uint32_t *words, size_t i, size_t n)
{
    const uint32_t pixel = lum_word_pixel(words[i]);
    while (i < n && lum_word_pixel(words[i]) == pixel) {
        i++;
    }
    return i;
}

/* Whether words[i] and the next are of one pixel. */
static inline bool is_joined(const uint32_t *words, size_t i, size_t n)
{
    return i + 1u < n &&
           ((words[i] ^ words[i + 1u]) & (uint32_t)LUM_WORD_PIXEL) == 0;
}

static inline bool is_pulse(uint32_t first, uint32_t second)
{
    return lum_word_is_rising(first) && !lum_word_is_rising(second);
}

/* Most pixels have one return, a rising word and a falling one or none: these
 * are numbered at once. */
void lum_returns_compute(const uint32_t *words, size_t n, lum_return *out)
{
    static const lum_return lone = {.number = 1, .count = 1};
    size_t i = 0;
    while (i < n) {
        if (!is_joined(words, i, n)) {
            out[i++] = lone;
        } else if (!is_joined(words, i + 1u, n) &&
                   is_pulse(words[i], words[i + 1u])) {
            const int32_t width =
                lum_word_tof(words[i + 1u]) - lum_word_tof(words[i]);
            out[i] = lone;
            out[i].width_tof = width > 0 ? (uint32_t)width : 0;
            out[i + 1u] = lone;
            i += 2u;
        } else {
            const size_t end = end_of_pixel(words, i, n);
            number_run(words, i, end, out);
            i = end;
        }
    }
}
