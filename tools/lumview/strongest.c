#include "strongest.h"

/* The return numbers of the widest pulses of a pixel, the first among equals;
 * 0: it has no such edge. */
struct widest {
    uint16_t number[2]; /* by edge: falling, rising */
};

/* Words without a point count too, so samples alone do not tell. Moves at to
 * the word behind the pixel. */
static struct widest find_widest(const lum_line *line,
                                 const lum_return *returns, uint32_t *at)
{
    const uint32_t pixel = lum_word_pixel(line->words[*at]);
    struct widest widest = {{0, 0}};
    uint32_t width[2] = {0, 0};
    for (; *at < line->word_count && lum_word_pixel(line->words[*at]) == pixel;
         ++*at) {
        const lum_return *r = &returns[*at];
        const unsigned edge = lum_word_is_rising(line->words[*at]) ? 1 : 0;
        if (widest.number[edge] == 0 || r->width_tof > width[edge]) {
            widest.number[edge] = r->number;
            width[edge] = r->width_tof;
        }
    }
    return widest;
}

void strongest_mark(const lum_line *line, lum_return *returns,
                    const lum_sample *samples, size_t count, uint8_t *out)
{
    size_t i = 0;
    lum_returns_compute(line->words, line->word_count, returns);
    for (uint32_t at = 0; at < line->word_count && i < count;) {
        const uint32_t pixel = lum_word_pixel(line->words[at]);
        const struct widest widest = find_widest(line, returns, &at);
        for (; i < count && samples[i].pixel == pixel; i++) {
            const unsigned edge = samples[i].edge != 0 ? 1 : 0;
            out[i] = samples[i].return_number == widest.number[edge] ? 1 : 0;
        }
    }
}
