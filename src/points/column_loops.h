/* The loops of columns that are not x, y and z, as the compiler makes vector
 * code of them for the processor of the file that includes this. */
#ifndef LUM_POINTS_COLUMN_LOOPS_H
#define LUM_POINTS_COLUMN_LOOPS_H

#include "arithmetic.h"
#include "kernels.h"

LUM_IN_LOOP void lum_put_by_pixel(const lum_column_numbers *from,
                                  const float *of_pixel, float *restrict out)
{
    const uint32_t *words = from->words;
    const uint32_t n = out != NULL ? from->count : 0;
    for (uint32_t i = 0; i < n; i++) {
        out[i] = of_pixel[lum_word_pixel(words[i])];
    }
}

LUM_IN_LOOP void lum_put_of_words(const lum_column_numbers *from,
                                  uint16_t *restrict pixel,
                                  uint8_t *restrict edge)
{
    const uint32_t *words = from->words;
    const uint32_t n = from->count;
    for (uint32_t i = 0; pixel != NULL && i < n; i++) {
        pixel[i] = (uint16_t)lum_word_pixel(words[i]);
    }
    for (uint32_t i = 0; edge != NULL && i < n; i++) {
        edge[i] = (uint8_t)(words[i] / LUM_WORD_RISING & 1u);
    }
}

/* A width has 20 bits, which are signed faster. */
LUM_IN_LOOP void lum_put_of_returns(const lum_column_numbers *from,
                                    float *restrict width,
                                    uint16_t *restrict returns,
                                    uint16_t *restrict count)
{
    const lum_return *r = from->returns;
    const double lsb_ns = from->tof_lsb_ns;
    const uint32_t n = from->count;
    for (uint32_t i = 0; width != NULL && i < n; i++) {
        width[i] = (float)((int32_t)r[i].width_tof * lsb_ns);
    }
    for (uint32_t i = 0; returns != NULL && i < n; i++) {
        returns[i] = r[i].number;
    }
    for (uint32_t i = 0; count != NULL && i < n; i++) {
        count[i] = r[i].count;
    }
}

LUM_IN_LOOP void lum_numbers_loop(const lum_column_numbers *from,
                                  const lum_column_places *to)
{
    lum_put_by_pixel(from, from->azimuth, to->azimuth);
    lum_put_by_pixel(from, from->elevation, to->elevation);
    lum_put_of_words(from, to->pixel, to->edge);
    lum_put_of_returns(from, to->pulse_width, to->return_number,
                       to->number_of_returns);
}

#endif
