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

/* Most pixels have one return: a rising word, and a falling one or none. */
static bool number_lone(const uint32_t *words, size_t begin, size_t end,
                        lum_return *out)
{
    static const lum_return lone = {.number = 1, .count = 1};
    if (end - begin == 1) {
        out[begin] = lone;
        return true;
    }
    if (end - begin > 2 || !lum_word_is_rising(words[begin]) ||
        lum_word_is_rising(words[begin + 1])) {
        return false;
    }
    const int32_t width =
        lum_word_tof(words[begin + 1]) - lum_word_tof(words[begin]);
    out[begin] = lone;
    out[begin].width_tof = width > 0 ? (uint32_t)width : 0;
    out[begin + 1] = lone;
    return true;
}

void lum_returns_compute(const uint32_t *words, size_t n, lum_return *out)
{
    size_t begin = 0;
    while (begin < n) {
        const uint32_t pixel = lum_word_pixel(words[begin]);
        size_t end = begin + 1;
        while (end < n && lum_word_pixel(words[end]) == pixel) {
            end++;
        }
        if (!number_lone(words, begin, end, out)) {
            number_run(words, begin, end, out);
        }
        begin = end;
    }
}
